// SPDX-License-Identifier: Apache-2.0
#include "io/files/coding.h"
#include "io/files/bytes.h"
#include "support/test.h"

namespace espalier::io {
namespace {

// "aaaaaaaaaa" by zlib: a head, a block of fixed codes, and Adler's checksum, big-endian. Its sums
// are 1 + 10 · 97 = 0x3cb, and 10 + 97 · (1 + ... + 10) = 0x14e1.
const std::string kRaw("\x4b\x4c\x84\x01\x00", 5);
const std::string kZlib = "\x78\x9c" + kRaw + "\x14\xe1\x03\xcb";
const std::string kPlain(10, 'a');

std::string inflated(std::string_view stream, std::uint64_t size, DeflateForm form) {
    std::string bytes = "before";
    appendInflated(stream, size, form, bytes);
    EXPECT_TRUE(bytes.starts_with("before"));
    return bytes.substr(6);
}

TEST(Inflate, InflatesStreamsWithAndWithoutZlibHead) {
    EXPECT_EQ(inflated(kZlib, 10, DeflateForm::Zlib), kPlain);
    EXPECT_EQ(inflated(kRaw, 10, DeflateForm::Raw), kPlain);
    EXPECT_EQ(inflated(kRaw + "more", 10, DeflateForm::Raw), kPlain);
    // A last block of fixed codes whose first code ends it.
    EXPECT_EQ(inflated(std::string_view("\x03\x00", 2), 0, DeflateForm::Raw), "");
    EXPECT_THROW(inflated(kRaw, 10, DeflateForm::Zlib), CodingError);
    EXPECT_THROW(inflated(kZlib, 10, DeflateForm::Raw), CodingError);
}

TEST(Inflate, RefusesTruncatedStreams) {
    for (std::size_t size = 0; size < kZlib.size(); ++size)
        EXPECT_THROW(inflated(kZlib.substr(0, size), 10, DeflateForm::Zlib), CodingError) << size;
    for (std::size_t size = 0; size < kRaw.size(); ++size)
        EXPECT_THROW(inflated(kRaw.substr(0, size), 10, DeflateForm::Raw), CodingError) << size;
    EXPECT_THROW(inflated("", 0, DeflateForm::Raw), CodingError);
}

TEST(Inflate, RefusesAWrongSize) {
    for (const std::uint64_t size : {0u, 1u, 9u, 11u, 1000u})
        EXPECT_REFUSED(CodingError, "is damaged", inflated(kRaw, size, DeflateForm::Raw)) << size;
    // 5 bytes can inflate to at most 5160 bytes.
    for (const std::uint64_t size :
         {std::uint64_t{10'000}, std::numeric_limits<std::uint64_t>::max()})
        EXPECT_REFUSED(CodingError, "5 compressed bytes claims to hold " + std::to_string(size),
                       inflated(kRaw, size, DeflateForm::Raw));
}

}  // namespace
}  // namespace espalier::io
