// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/index.h>
#include <io/model_files.h>

#include <cstdint>

#include "io/files/bytes.h"
#include "io/matrices/npy.h"

namespace espalier::io {
namespace {

constexpr auto kLittle = std::endian::little;
constexpr auto kBig = std::endian::big;

/// Returns a file of version 1 with this head.
std::string npyFile(const std::string& head, const std::string& data) {
    return std::string("\x93NUMPY\x01\x00", 8) +
           bytesOf(static_cast<std::uint16_t>(head.size()), kLittle) + head + data;
}

/// Returns a file with this type and shape.
std::string npyArray(const std::string& type, const std::string& shape, const std::string& data) {
    return npyFile("{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }\n",
                   data);
}

template <class Number>
std::string bytesOfAll(std::initializer_list<Number> numbers, std::endian order) {
    std::string bytes;
    for (const Number number : numbers) bytes += bytesOf(number, order);
    return bytes;
}

template <class Number>
Array<Number> numbersIn(const std::string& bytes) {
    return npyNumbers<Number>(readNpy(bytes));
}

std::string textIn(const std::string& bytes) {
    return npyText(readNpy(bytes));
}

template <class Call>
void expectCodingError(Call call, const std::string& why) {
    EXPECT_THAT(call, ThrowsMessage<CodingError>(HasSubstr(why)));
}

TEST(NpyReader, ReadsAllNumberTypesAndByteOrders) {
    const auto check = [](auto zero, const std::string& name) {
        using Number = decltype(zero);
        for (const auto& [order, sign] : {std::pair(kLittle, "<"), std::pair(kBig, ">")}) {
            const std::string bytes =
                npyArray(sign + name, "(2,)", bytesOfAll<Number>({1, 100}, order));
            EXPECT_THAT(numbersIn<double>(bytes), ElementsAre(1, 100)) << sign << name;
            if constexpr (std::is_integral_v<Number>) {
                EXPECT_THAT(numbersIn<Index>(bytes), ElementsAre(1, 100)) << sign << name;
                EXPECT_THAT(numbersIn<Offset>(bytes), ElementsAre(1, 100)) << sign << name;
            } else {
                expectCodingError([&] { numbersIn<Index>(bytes); }, "expected integers");
            }
        }
    };
    check(std::int16_t{}, "i2");
    check(std::int32_t{}, "i4");
    check(std::int64_t{}, "i8");
    check(std::uint16_t{}, "u2");
    check(std::uint32_t{}, "u4");
    check(std::uint64_t{}, "u8");
    check(float{}, "f4");
    check(double{}, "f8");
    EXPECT_THAT(numbersIn<Index>(npyArray("|i1", "(2,)", "\xff\x7f")), ElementsAre(-1, 127));
    EXPECT_THAT(numbersIn<Index>(npyArray("|u1", "(2,)", "\xff\x7f")), ElementsAre(255, 127));
    EXPECT_THAT(numbersIn<Offset>(npyArray("<i8", "(0,)", "")), ElementsAre());
}

TEST(NpyReader, AcceptsOtherSpellingsOfTheHead) {
    const std::string data = bytesOfAll<std::int32_t>({3, 5}, kLittle);
    for (const std::string head :
         {"{'descr':'<i4','fortran_order':False,'shape':(2,)}",
          "{\"shape\" : ( 2 , ), \"fortran_order\" : True , \"descr\" : \"<i4\" , }  \n",
          "{'descr': '<i4', 'fortran_order': False, 'shape': (2L,), }\n"}) {
        EXPECT_THAT(numbersIn<Index>(npyFile(head, data)), ElementsAre(3, 5)) << head;
        // Versions 2 and 3 allow longer heads.
        for (const char version : {'\2', '\3'}) {
            const std::string longer = std::string("\x93NUMPY") + version + '\0' +
                                       bytesOf(std::uint32_t(head.size()), kLittle) + head + data;
            EXPECT_THAT(numbersIn<Index>(longer), ElementsAre(3, 5));
        }
    }
}

TEST(NpyReader, RefusesNumbersOutOfRange) {
    constexpr std::int64_t kLargest = std::int64_t{1} << 53;
    const auto wide = [](std::int64_t number) {
        return npyArray("<i8", "(2,)", bytesOfAll<std::int64_t>({0, number}, kLittle));
    };
    const auto widest =
        npyArray(">u8", "(1,)", bytesOfAll({std::numeric_limits<std::uint64_t>::max()}, kBig));
    for (const std::int64_t number : {kLargest, -kLargest})
        EXPECT_THAT(numbersIn<double>(wide(number)), ElementsAre(0, number));
    for (const std::int64_t number : {kLargest + 1, -kLargest - 1})
        expectCodingError([&] { numbersIn<double>(wide(number)); },
                          "number 1 is " + std::to_string(number) + ", which is out of range");
    expectCodingError([&] { numbersIn<double>(widest); },
                      "number 0 is 18446744073709551615, which is out of range");
    expectCodingError([&] { numbersIn<Offset>(widest); },
                      "number 0 is 18446744073709551615, which is out of range");
    expectCodingError([&] { numbersIn<Index>(wide(std::int64_t{1} << 31)); },
                      "is 2147483648, which is out of range");
    expectCodingError([&] { numbersIn<Index>(wide(-(std::int64_t{1} << 31) - 1)); }, "-2147483649");
    // npyNumbers() does not check that numbers are finite; its callers do.
    const auto infinite = npyArray("<f4", "(1,)", bytesOfAll<float>({INFINITY}, kLittle));
    EXPECT_THAT(numbersIn<double>(infinite), ElementsAre(INFINITY));
}

TEST(NpyReader, ReadsTextsOfBytesAndUnicode) {
    EXPECT_EQ(textIn(npyArray("|S3", "()", "csr")), "csr");
    EXPECT_EQ(textIn(npyArray("|S5", "()", std::string("csr\0\0", 5))), "csr");
    EXPECT_EQ(textIn(npyArray("<U2", "()", bytesOfAll<std::uint32_t>({'a', 'b'}, kLittle))), "ab");
    EXPECT_EQ(textIn(npyArray(">U2", "()", bytesOfAll<std::uint32_t>({'a', 0}, kBig))), "a");
    expectCodingError([] { textIn(npyArray("|S1", "()", "\xe9")); }, "is not a text in ASCII");
    expectCodingError([] { textIn(npyArray("<i4", "()", "abcd")); },
                      "is of type '<i4'; expected a single text");
    expectCodingError([] { textIn(npyArray("|S1", "(2,)", "ab")); }, "expected a single text");
}

TEST(NpyReader, RefusesOtherTypes) {
    const auto reading = [](const std::string& type, const std::string& data) {
        return [=] { numbersIn<double>(npyArray(type, "(1,)", data)); };
    };
    expectCodingError(reading("<c16", std::string(16, '\0')),
                      "is of type '<c16'; expected integers, or reals of 4 or 8 bytes");
    expectCodingError(reading("<f2", "ab"), "is of type '<f2'");
    expectCodingError(reading("|b1", "a"), "is of type '|b1'");
    expectCodingError(reading("|S3", "csr"), "is of type '|S3'");
    for (const char* type :
         {"|O", "f8", "=f8", "<f", "<f0", "<f-8", "<f8x", "", "<U9999999999999999999"})
        expectCodingError(reading(type, "abcdefgh"), "is of type '" + std::string(type) + "'");
    expectCodingError(reading("<U4611686018427387904", ""), "which is too large");
    expectCodingError([] { numbersIn<double>(npyArray("<f4", "()", "abcd")); }, "is a single item");
}

TEST(NpyReader, RefusesMalformedHeads) {
    const auto refusedHead = [](const std::string& head, const std::string& why) {
        expectCodingError([&] { readNpy(npyFile(head, "abcd")); }, why);
    };
    const std::string type = "'descr': '<i4', ", order = "'fortran_order': False, ",
                      shape = "'shape': (1,), ";
    EXPECT_NO_THROW(readNpy(npyFile("{" + type + order + shape + "}", "abcd")));
    refusedHead("", "expected '{' before its end");
    refusedHead("{" + type + order + "}", "expected 'descr', 'fortran_order' and 'shape'");
    refusedHead("{" + type + shape + "}", "expected 'descr', 'fortran_order' and 'shape'");
    refusedHead("{" + order + shape + "}", "expected 'descr', 'fortran_order' and 'shape'");
    refusedHead("{" + type + order + shape + "} x", "got 'x'");
    refusedHead("{" + type + order + shape + shape + "}", "each key once");
    refusedHead("{" + type + order + shape + "'more': 1}", "its keys");
    refusedHead("{" + type + order + shape, "a text in quotes before its end");
    refusedHead("{'descr' '<i4'}", "expected ':', got ''<i4'}'");
    refusedHead("{'descr': '<i4", "a text in quotes");
    refusedHead("{'descr': [('a', '<i4')]}", "expected a text in quotes, got '[('a', '<i4')]}'");
    refusedHead("{'fortran_order': 0}", "True or False");
    refusedHead("{'shape': 1}", "expected '('");
    refusedHead("{'shape': (1)}", "expected ','");
    refusedHead("{'shape': (-1,)}", "a number of items");
    refusedHead("{'shape': (99999999999999999999,)}", "a number of items");
    refusedHead("{'shape': (1, 1)}", "expected 'descr', 'fortran_order' and 'shape'");
    refusedHead("{'shape': (1, 1 1)}", "expected ')'");
}

TEST(NpyReader, ReadsMatricesRowByRow) {
    const auto stored = bytesOfAll<std::int32_t>({1, 2, 3, 4, 5, 6}, kLittle);
    const auto rows = readNpy(npyArray("<i4", "(2, 3)", stored));
    EXPECT_THAT(npyMatrix(rows), ElementsAre(1, 2, 3, 4, 5, 6));
    EXPECT_EQ(shapeText(rows.shape), "(2, 3)");
    expectCodingError([&] { npyNumbers<Index>(rows); }, "has several axes; expected one");
    const auto columns =
        readNpy(npyFile("{'descr': '<i4', 'fortran_order': True, 'shape': (2L, 3L,), }", stored));
    EXPECT_THAT(npyMatrix(columns), ElementsAre(1, 3, 5, 2, 4, 6));
    expectCodingError([&] { npyMatrix(readNpy(npyArray("<i4", "(6,)", stored))); },
                      "has 1 axes; expected two");
    EXPECT_EQ(shapeText(readNpy(npyArray("<i4", "(6,)", stored)).shape), "(6,)");
}

TEST(NpyReader, ChecksClaimedSizes) {
    const auto claims = [](const std::string& type, const std::string& shape, std::size_t there) {
        return [=] { readNpy(npyArray(type, shape, std::string(there, 'x'))); };
    };
    expectCodingError(claims("<i4", "(2,)", 7), "claims 2 items of 4 bytes, but 7 bytes are there");
    expectCodingError(claims("<i4", "(2,)", 9), "claims 2 items of 4 bytes, but 9 bytes are there");
    expectCodingError(claims("<i4", "()", 8), "claims 1 items of 4 bytes");
    // 2^62 items of 4 bytes are 2^64 bytes, which is 0 in 64 bits.
    expectCodingError(claims("<i4", "(4611686018427387904,)", 0),
                      "claims 4611686018427387904 items");
    expectCodingError(claims("<i4", "(4294967296, 4294967296)", 0), "claims more than 2^64 items");
    expectCodingError(claims("<i4", "(2, 3)", 20), "claims 6 items of 4 bytes");
    expectCodingError(claims("|S18446744073709551615", "()", 3), "of 18446744073709551615 bytes");
    expectCodingError([] { readNpy("\x93NUMPX"); }, "is not an array of NumPy");
    for (const char version : {'\0', '\4', '\xff'})
        expectCodingError(
            [&] { readNpy(std::string("\x93NUMPY") + version + std::string(9, '\0')); },
            "expected 1 to 3");
    const std::string whole = npyArray("<i4", "(2,)", "abcdefgh");
    for (std::size_t size = 0; size < whole.size(); ++size)
        EXPECT_THROW(readNpy(std::string_view(whole).substr(0, size)), CodingError) << size;
    const std::string longHead = std::string("\x93NUMPY\2\0\xff\xff\xff\xff", 12) + "{}";
    expectCodingError([&] { readNpy(longHead); },
                      "4294967295 bytes are expected, 2 bytes are there");
}

}  // namespace
}  // namespace espalier::io
