// SPDX-License-Identifier: Apache-2.0
#include "io/files/gzip.h"
#include <espalier/base/memory.h>
#include "io/files/bytes.h"
#include "support/test.h"

namespace espalier::io {
namespace {

// "aaaaaaaaaa": the head without a name and a time, written by Unix (3); a block of fixed codes;
// the CRC-32, which zlib computes as 0x4c11cdf0, and the size, both little-endian.
const std::string kCompressedLetters(
    "\x1f\x8b\x08\0\0\0\0\0\0\x03\x4b\x4c\x84\x01\0\xf0\xcd\x11\x4c\x0a\0\0\0", 23);
const std::string kTenLetters(10, 'a');

TEST(Gzip, InflatesFilesOfOneMemberAndOfSeveral) {
    EXPECT_EQ(gunzip(kCompressedLetters), kTenLetters);
    EXPECT_EQ(gunzip(kCompressedLetters + kCompressedLetters + kCompressedLetters),
              kTenLetters + kTenLetters + kTenLetters);
    EXPECT_EQ(gunzip(kCompressedLetters + std::string(5, '\0')), kTenLetters);
    EXPECT_TRUE(isGzip(kCompressedLetters));
    EXPECT_FALSE(isGzip("\x1f"));
    EXPECT_FALSE(isGzip("FoamFile"));
}

TEST(Gzip, ReturnsWhatItCompressed) {
    // Longer than the blocks in which zlib works.
    std::string text;
    for (int i = 0; text.size() < 3'000'000; ++i) text += std::to_string(i * 7919 % 100'003) + "\n";
    for (const std::string& bytes : {std::string(), kTenLetters, text}) {
        const std::string file = gzip(bytes);
        EXPECT_TRUE(isGzip(file));
        EXPECT_TRUE(gunzip(file) == bytes);
        EXPECT_TRUE(gzip(bytes) == file);
    }
    EXPECT_LT(gzip(text).size(), text.size() / 2);
    // RFC 1952: no flags, so no name; a time of 0.
    EXPECT_EQ(gzip(kTenLetters).substr(0, 8), kCompressedLetters.substr(0, 8));
}

TEST(Gzip, RefusesDamagedFiles) {
    for (std::size_t size = 0; size < kCompressedLetters.size(); ++size)
        EXPECT_REFUSED(CodingError, "is damaged: it ends too early",
                       gunzip(kCompressedLetters.substr(0, size)))
            << size;
    for (const std::size_t at : {0, 1, 2, 10, 15, 19}) {
        std::string file = kCompressedLetters;
        file[at] ^= 0x55;
        EXPECT_REFUSED(CodingError, "is damaged", gunzip(file)) << at;
    }
    EXPECT_REFUSED(CodingError, "has 4 further bytes behind", gunzip(kCompressedLetters + "more"));
}

TEST(Gzip, ALimitOfMemoryStopsAFileThatInflatesToMuch) {
    const std::string file = gzip(std::string(100'000'000, '\0'));
    EXPECT_LT(file.size(), 200'000u);
    const MemoryLimit limit(residentMemory() + 20'000'000);
    EXPECT_THROW(gunzip(file), MemoryError);
}

}  // namespace
}  // namespace espalier::io
