// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>

#include "io/files/number_types.h"
#include "support/test.h"

namespace espalier::test {
namespace {

using io::NumberType;

constexpr NumberType kAll[] = {NumberType::Int8,   NumberType::UInt8,  NumberType::Int16,
                               NumberType::UInt16, NumberType::Int32,  NumberType::UInt32,
                               NumberType::Int64,  NumberType::UInt64, NumberType::Float32,
                               NumberType::Float64};

TEST(VtkNumbers, HaveNamesAndSizes) {
    EXPECT_EQ(io::numberOfXmlName("UInt16"), NumberType::UInt16);
    EXPECT_EQ(io::numberOfXmlName("Float64"), NumberType::Float64);
    EXPECT_FALSE(io::numberOfXmlName("String"));
    EXPECT_FALSE(io::numberOfXmlName("Bit"));
    for (const NumberType type : kAll) EXPECT_EQ(io::numberOfXmlName(io::xmlName(type)), type);
    EXPECT_EQ(io::numberOfLegacyName("unsigned_char"), NumberType::UInt8);
    EXPECT_EQ(io::numberOfLegacyName("vtkidtype"), NumberType::Int32);
    EXPECT_EQ(io::numberOfLegacyName("vtktypeint64"), NumberType::Int64);
    EXPECT_FALSE(io::numberOfLegacyName("bit"));
    EXPECT_EQ(io::byteSize(NumberType::UInt16), 2u);
    EXPECT_EQ(io::byteSize(NumberType::Float64), 8u);
    EXPECT_TRUE(io::isInteger(NumberType::UInt64));
    EXPECT_FALSE(io::isInteger(NumberType::Float32));
}

TEST(VtkNumbers, AreDecodedInBothByteOrders) {
    const std::string bytes("\x01\x02\xff\xfe", 4);
    const auto big = [&](NumberType type) {
        return io::decodeNumbers<std::int64_t>(bytes, type, std::endian::big);
    };
    using Values = std::vector<std::int64_t>;
    EXPECT_EQ(big(NumberType::Int8), (Values{1, 2, -1, -2}));
    EXPECT_EQ(big(NumberType::UInt8), (Values{1, 2, 255, 254}));
    EXPECT_EQ(big(NumberType::Int16), (Values{0x0102, -2}));
    EXPECT_EQ(big(NumberType::UInt16), (Values{0x0102, 0xfffe}));
    EXPECT_EQ(big(NumberType::Int32), (Values{0x0102fffe}));
    EXPECT_EQ(io::decodeNumbers<std::int64_t>(bytes, NumberType::UInt32, std::endian::little),
              (Values{0xfeff0201}));
    // 1.5 is 3fc00000 (IEEE 754, single).
    EXPECT_EQ(io::decodeNumbers<double>(std::string_view("\0\0\xc0\x3f", 4), NumberType::Float32,
                                        std::endian::little),
              (std::vector<double>{1.5}));
}

TEST(VtkNumbers, RoundTripIsExact) {
    for (const NumberType type : kAll)
        for (const auto order : {std::endian::little, std::endian::big}) {
            const std::vector<double> reals = {0, 1, 100};
            EXPECT_EQ(io::decodeNumbers<double>(io::encodeNumbers<double>(reals, type, order), type,
                                                order),
                      io::isInteger(type) ? std::vector<double>{} : reals);
            if (!io::isInteger(type)) continue;
            const std::vector<std::int64_t> integers = {0, 1, 100};
            EXPECT_EQ(io::decodeNumbers<std::int64_t>(
                          io::encodeNumbers<std::int64_t>(integers, type, order), type, order),
                      integers);
        }
}

TEST(VtkNumbers, TextIsRoundedToTheNumberType) {
    io::TextReader text("f", "0.1 0.1 1e-46 1e39 7");
    EXPECT_EQ(io::readNumber<double>(text, NumberType::Float64, "a number"), 0.1);
    EXPECT_EQ(io::readNumber<double>(text, NumberType::Float32, "a number"), double{0.1f});
    // The first number is below the smallest float, the second above the largest.
    EXPECT_EQ(io::readNumber<double>(text, NumberType::Float32, "a number"), 0);
    EXPECT_EQ(io::readNumber<double>(text, NumberType::Float32, "a number"), kInfinity);
    EXPECT_EQ(io::readNumber<std::int64_t>(text, NumberType::UInt8, "a number"), 7);
    io::TextReader bad("f", "x 1.5");
    EXPECT_THROW(io::readNumber<double>(bad, NumberType::Float32, "a number"), io::FileError);
    EXPECT_THROW(io::readNumber<std::int64_t>(bad, NumberType::Int32, "a number"), io::FileError);
}

TEST(SaturatingProduct, StopsAtTheLargestNumber) {
    constexpr std::size_t kLargest = std::numeric_limits<std::size_t>::max();
    EXPECT_EQ(io::saturatingProduct(3, 5), 15u);
    EXPECT_EQ(io::saturatingProduct(kLargest, 0), 0u);
    EXPECT_EQ(io::saturatingProduct(kLargest / 2, 3), kLargest);
}

}  // namespace
}  // namespace espalier::test
