// SPDX-License-Identifier: Apache-2.0
#include "io/files/bytes.h"
#include "support/test.h"

namespace espalier::io {
namespace {

TEST(ByteInput, ReadsNumbersInBothByteOrders) {
    const std::string_view bytes("\1\2\3\4\5\6\xff", 7);
    ByteInput little(bytes, std::endian::little);
    EXPECT_EQ(little.number<std::uint16_t>(), 0x0201);
    EXPECT_EQ(little.left(), 5);
    EXPECT_EQ(little.bytes(1), "\3");
    EXPECT_THAT((little.numbersAs<std::uint16_t, std::int64_t>(2)), ElementsAre(0x0504, 0xff06));
    EXPECT_EQ(little.left(), 0);
    EXPECT_THAT((little.numbersAs<double, double>(0)), ElementsAre());
    ByteInput big(bytes, std::endian::big);
    EXPECT_THAT((big.numbersAs<std::uint16_t, std::uint16_t>(3)),
                ElementsAre(0x0102, 0x0304, 0x0506));
    EXPECT_THAT((big.numbersAs<std::int8_t, double>(1)), ElementsAre(-1));
}

TEST(ByteInput, RefusesToReadBeyondTheEnd) {
    ByteInput in("12345678", std::endian::little);
    EXPECT_REFUSED(CodingError, "9 bytes are expected, 8 bytes are there", in.bytes(9));
    EXPECT_REFUSED(CodingError, "3 numbers of 4 bytes are expected",
                   in.numbersAs<std::int32_t, double>(3));
    // 2^62 numbers of 4 bytes are 2^64 bytes, which is 0 in 64 bits.
    EXPECT_REFUSED(CodingError, "4611686018427387904 numbers of 4 bytes",
                   in.numbersAs<std::int32_t, double>(std::uint64_t{1} << 62));
    // A refused read does not move the position.
    EXPECT_EQ(in.bytes(8), "12345678");
    EXPECT_REFUSED(CodingError, "1 bytes are expected, 0 bytes are there",
                   in.number<std::int8_t>());
}

}  // namespace
}  // namespace espalier::io
