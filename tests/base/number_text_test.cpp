// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/number_text.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#define FMT_HEADER_ONLY
#include "base/portable_number_text.h"
#include "support/test.h"

namespace espalier {
namespace {

/// Numbers of every size and kind: random bits, whole numbers, short decimals, powers of two and
/// ten, and the ends of the range.
template <class Real>
std::vector<Real> numbersOfAllKinds() {
    using Bits = std::conditional_t<sizeof(Real) == 8, std::uint64_t, std::uint32_t>;
    using Limits = std::numeric_limits<Real>;
    std::vector<Real> numbers = {0,
                                 -Real(0),
                                 Limits::max(),
                                 Limits::min(),
                                 Limits::denorm_min(),
                                 Limits::infinity(),
                                 -Limits::infinity()};
    std::mt19937_64 random(1);
    for (int i = 0; i < 20000; ++i) {
        const Real any = std::bit_cast<Real>(static_cast<Bits>(random()));
        if (std::isfinite(any)) numbers.push_back(any);
        numbers.push_back(
            static_cast<Real>(static_cast<std::int64_t>(random()) >> (random() % 64)));
        numbers.push_back(static_cast<Real>(static_cast<int>(random() % 2000001) - 1000000) /
                          Real(1000));
    }
    for (int power = Limits::min_exponent - 60; power <= Limits::max_exponent; ++power)
        for (const int step : {-1, 0, 1}) {
            const Real exact = std::ldexp(Real(1), power);
            numbers.push_back(step == 0  ? exact
                              : step < 0 ? std::nextafter(exact, Real(0))
                                         : std::nextafter(exact, Limits::max()));
        }
    for (int power = Limits::min_exponent10 - 10; power <= Limits::max_exponent10; ++power)
        for (const char* mantissa : {"1e", "9e", "1.5e", "-9.999999e"})
            numbers.push_back(static_cast<Real>(
                std::strtold((mantissa + std::to_string(power)).c_str(), nullptr)));
    return numbers;
}

template <class Real>
class NumberTexts : public ::testing::Test {};
TYPED_TEST_SUITE(NumberTexts, Reals);

/// Reading back gives the same bits, and the portable form writes the same text.
TYPED_TEST(NumberTexts, ReadBackAndDoNotDependOnTheStandardLibrary) {
    for (const TypeParam number : numbersOfAllKinds<TypeParam>()) {
        const NumberText text(number);
        char portable[32];
        const std::string_view portableText(
            portable, static_cast<std::size_t>(portable::writeNumber(portable, number) - portable));
        ASSERT_EQ(text.view(), portableText);

        for (const auto read :
             {&portable::scanNumber<TypeParam>,
              static_cast<std::from_chars_result (*)(std::string_view, TypeParam&)>(&scanNumber)}) {
            TypeParam back = -1;
            const auto [end, error] = read(text.view(), back);
            ASSERT_EQ(error, std::errc()) << text.view();
            ASSERT_EQ(end, text.view().data() + text.view().size()) << text.view();
            ASSERT_EQ(std::signbit(back), std::signbit(number)) << text.view();
            ASSERT_EQ(back, number);
        }
    }
}

/// By hand: the shorter notation, and the fixed one of two with equal lengths.
TEST(NumberText, IsTheShorterNotation) {
    const auto text = [](auto number) { return std::string(NumberText(number).view()); };
    EXPECT_EQ(text(0.1), "0.1");
    EXPECT_EQ(text(-0.0), "-0");
    EXPECT_EQ(text(1e-4), "1e-04");       // 5 bytes; 0.0001 has 6
    EXPECT_EQ(text(0.0012), "0.0012");    // 6 bytes; 1.2e-03 has 7
    EXPECT_EQ(text(0.00012), "0.00012");  // 7 bytes, as 1.2e-04
    EXPECT_EQ(text(10000.0), "10000");    // 5 bytes, as 1e+04
    EXPECT_EQ(text(100000.0), "1e+05");
    EXPECT_EQ(text(123456.5f), "123456.5");
    EXPECT_EQ(text(9007199254740993e3), "9007199254740993024");  // all digits: a multiple of 1024
    EXPECT_EQ(text(std::int64_t{-42}), "-42");
    EXPECT_EQ(text(std::uint8_t{200}), "200");
}

TEST(NumberText, InFixedNotationIsRounded) {
    for (const auto& fixed : {&fixedText, &portable::fixedText}) {
        EXPECT_EQ(fixed(0.46, 1), "0.5");
        EXPECT_EQ(fixed(999.96, 1), "1000.0");
        EXPECT_EQ(fixed(0.25, 1), "0.2");  // a tie goes to the even digit
        EXPECT_EQ(fixed(-2, 0), "-2");
        EXPECT_EQ(fixed(1e300, 2).size(), 304u);
    }
}

/// Texts that are no number, go on after it, or are out of range, by both.
TYPED_TEST(NumberTexts, OfOtherKindsGiveTheSameErrors) {
    for (const std::string_view text : {"",         "x",      "-",
                                        "+1",       " 1",     "1 ",
                                        "1x",       "1e",     "1e+",
                                        ".5",       "5.",     ".",
                                        "-.5e1",    "0x10",   "1e999",
                                        "-1e999",   "1e-999", "0e999",
                                        "0.0e-999", "1e39",   "3e-46",
                                        "inf",      "-inf",   "INFINITY",
                                        "infinite", "nan",    "NaN",
                                        "1,5",      "1d5",    "00012",
                                        "1E5",      "1e5.5",  "1e99999999999999999999"}) {
        TypeParam standard = 7, portable = 7;
        const auto expected = scanNumber(text, standard);
        const auto found = portable::scanNumber(text, portable);
        EXPECT_EQ(found.ec, expected.ec) << text;
        EXPECT_EQ(found.ptr - text.data(), expected.ptr - text.data()) << text;
        if (std::isnan(standard))
            EXPECT_TRUE(std::isnan(portable)) << text;
        else
            EXPECT_EQ(portable, standard) << text;
    }
}

}  // namespace
}  // namespace espalier
