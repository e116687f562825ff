// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/utf8.h>

#include "support/test.h"

namespace espalier {
namespace {

TEST(Utf8, DecodesTheFirstCodePoint) {
    const struct {
        std::string text;
        std::uint32_t value;
        std::size_t size;
    } samples[] = {{"ab", 'a', 1},
                   {std::string(1, '\0'), 0, 1},
                   {"\xC3\xA4", 0xE4, 2},
                   {"\xE2\x82\xAC!", 0x20AC, 3},
                   {"\xEF\xBF\xBE", 0xFFFE, 3},
                   {"\xF4\x8F\xBF\xBF", 0x10FFFF, 4}};
    for (const auto& [text, value, size] : samples) {
        const CodePoint point = firstCodePoint(text);
        EXPECT_TRUE(point.isCharacter) << text;
        EXPECT_EQ(point.value, value) << text;
        EXPECT_EQ(point.size, size) << text;
    }
}

/// Tries stray and missing continuations, overlong forms, surrogates, and values beyond Unicode.
TEST(Utf8, RecognizesBytesThatAreNotUtf8) {
    for (const std::string text : {"\x80", "\xC3", "\xC3!", "\xC0\x80", "\xE0\x80\x80", "\xE2\x82",
                                   "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"}) {
        const CodePoint point = firstCodePoint(text);
        EXPECT_FALSE(point.isCharacter) << text;
        EXPECT_EQ(point.size, 1u) << text;
        EXPECT_EQ(point.value, static_cast<unsigned char>(text[0])) << text;
    }
}

}  // namespace
}  // namespace espalier
