// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "io/vtk/vtk_numbers.h"

namespace espalier::test {
namespace {

using io::VtkNumber;

constexpr VtkNumber kAll[] = {
    VtkNumber::Int8,   VtkNumber::UInt8, VtkNumber::Int16,  VtkNumber::UInt16,  VtkNumber::Int32,
    VtkNumber::UInt32, VtkNumber::Int64, VtkNumber::UInt64, VtkNumber::Float32, VtkNumber::Float64};

TEST(VtkNumbers, HaveNamesAndSizes) {
    EXPECT_EQ(io::numberOfXmlName("UInt16"), VtkNumber::UInt16);
    EXPECT_EQ(io::numberOfXmlName("Float64"), VtkNumber::Float64);
    EXPECT_FALSE(io::numberOfXmlName("String"));
    EXPECT_FALSE(io::numberOfXmlName("Bit"));
    for (const VtkNumber type : kAll) EXPECT_EQ(io::numberOfXmlName(io::xmlName(type)), type);
    EXPECT_EQ(io::numberOfLegacyName("unsigned_char"), VtkNumber::UInt8);
    EXPECT_EQ(io::numberOfLegacyName("vtkidtype"), VtkNumber::Int32);
    EXPECT_EQ(io::numberOfLegacyName("vtktypeint64"), VtkNumber::Int64);
    EXPECT_FALSE(io::numberOfLegacyName("bit"));
    EXPECT_EQ(io::byteSize(VtkNumber::UInt16), 2u);
    EXPECT_EQ(io::byteSize(VtkNumber::Float64), 8u);
    EXPECT_TRUE(io::isInteger(VtkNumber::UInt64));
    EXPECT_FALSE(io::isInteger(VtkNumber::Float32));
}

TEST(VtkNumbers, AreDecodedInBothByteOrders) {
    const std::string bytes("\x01\x02\xff\xfe", 4);
    const auto big = [&](VtkNumber type) {
        return io::decodeNumbers<std::int64_t>(bytes, type, std::endian::big);
    };
    using Values = std::vector<std::int64_t>;
    EXPECT_EQ(big(VtkNumber::Int8), (Values{1, 2, -1, -2}));
    EXPECT_EQ(big(VtkNumber::UInt8), (Values{1, 2, 255, 254}));
    EXPECT_EQ(big(VtkNumber::Int16), (Values{0x0102, -2}));
    EXPECT_EQ(big(VtkNumber::UInt16), (Values{0x0102, 0xfffe}));
    EXPECT_EQ(big(VtkNumber::Int32), (Values{0x0102fffe}));
    EXPECT_EQ(io::decodeNumbers<std::int64_t>(bytes, VtkNumber::UInt32, std::endian::little),
              (Values{0xfeff0201}));
    // 1.5 is 3fc00000 (IEEE 754, single).
    EXPECT_EQ(io::decodeNumbers<double>(std::string_view("\0\0\xc0\x3f", 4), VtkNumber::Float32,
                                        std::endian::little),
              (std::vector<double>{1.5}));
}

TEST(VtkNumbers, ComeBackAsTheyWere) {
    for (const VtkNumber type : kAll)
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

TEST(VtkNumbers, OfTextAreRoundedAsTheirTypeSays) {
    io::TextReader text("f", "0.1 0.1 1e-46 1e39 7");
    EXPECT_EQ(io::readNumber<double>(text, VtkNumber::Float64, "a number"), 0.1);
    EXPECT_EQ(io::readNumber<double>(text, VtkNumber::Float32, "a number"), double{0.1f});
    // Below the smallest float and above the largest.
    EXPECT_EQ(io::readNumber<double>(text, VtkNumber::Float32, "a number"), 0);
    EXPECT_EQ(io::readNumber<double>(text, VtkNumber::Float32, "a number"),
              std::numeric_limits<double>::infinity());
    EXPECT_EQ(io::readNumber<std::int64_t>(text, VtkNumber::UInt8, "a number"), 7);
    io::TextReader bad("f", "x 1.5");
    EXPECT_THROW(io::readNumber<double>(bad, VtkNumber::Float32, "a number"), io::FileError);
    EXPECT_THROW(io::readNumber<std::int64_t>(bad, VtkNumber::Int32, "a number"), io::FileError);
}

TEST(SaturatingProduct, StopsAtTheLargestNumber) {
    constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
    EXPECT_EQ(io::saturatingProduct(3, 5), 15u);
    EXPECT_EQ(io::saturatingProduct(kMost, 0), 0u);
    EXPECT_EQ(io::saturatingProduct(kMost / 2, 3), kMost);
}

}  // namespace
}  // namespace espalier::test
