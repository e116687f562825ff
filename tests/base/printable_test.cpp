// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/printable.h>

#include <utility>

#include "support/test.h"

namespace espalier {
namespace {

TEST(Printable, KeepsOrdinaryText) {
    for (const std::string text :
         {"", "a b.vtu", "größe", "\xE2\x82\xAC", "\xE7\xB6\xB2", "\xF0\x9F\x8C\xB2", R"(C:\x\n)"})
        EXPECT_EQ(printable(text), text);
}

TEST(Printable, EscapesTerminalControls) {
    const std::vector<std::pair<std::string, std::string>> samples = {
        {"\x1B[2J\r\n", R"(\x1B[2J\x0D\x0A)"},
        {std::string("a\0b\x7F", 4), R"(a\x00b\x7F)"},
        {"\xC2\x80 \xC2\x9B \xC2\x9F \xC2\xA0", "\\u0080 \\u009B \\u009F \xC2\xA0"},
        {"\xD8\x9C", R"(\u061C)"},
        {"\xE2\x80\x8E\xE2\x80\x8F", R"(\u200E\u200F)"},
        {"\xE2\x80\xA8 \xE2\x80\xA9", R"(\u2028 \u2029)"},
        {"\xE2\x80\xAA \xE2\x80\xAE", R"(\u202A \u202E)"},
        {"\xE2\x81\xA6 \xE2\x81\xA9", R"(\u2066 \u2069)"},
        {"\xEF\xBB\xBF", R"(\uFEFF)"},
        {"\xEF\xBF\xBE \xEF\xBF\xBF", R"(\uFFFE \uFFFF)"},
        {"\xF3\xA0\x81\x81", R"(\U000E0041)"}};
    for (const auto& [text, shown] : samples) EXPECT_EQ(printable(text), shown);
}

TEST(Printable, EscapesBytesThatAreNotUtf8) {
    const std::vector<std::pair<std::string, std::string>> samples = {
        {"\x80 \x9B \xFF", R"(\x80 \x9B \xFF)"},
        {"gr\xF6\xDF"
         "e",
         R"(gr\xF6\xDFe)"},   // Latin-1
        {"\xC3", R"(\xC3)"},  // cut off
        {"\xC3(", R"(\xC3()"},
        {"\xC1\x81", R"(\xC1\x81)"},  // longer than needed
        {"\xE0\x82\x9B", R"(\xE0\x82\x9B)"},
        {"\xED\xA0\x80", R"(\xED\xA0\x80)"},           // half of a pair of UTF-16
        {"\xF4\x90\x80\x80", R"(\xF4\x90\x80\x80)"}};  // above U+10FFFF
    for (const auto& [text, shown] : samples) EXPECT_EQ(printable(text), shown);
}

TEST(Printable, KeepsBothEndsOfALongText) {
    const std::string path = "/begin" + std::string(12000, 'x') + "/end.vtu";
    const std::string shown = printable(path);
    EXPECT_EQ(shown.size(), kMaxShownBytes + 3);
    EXPECT_TRUE(shown.starts_with("/beginxxx"));
    EXPECT_TRUE(shown.ends_with("xxx/end.vtu"));
    EXPECT_EQ(printable("123456", 6), "123456");
    EXPECT_EQ(printable("1234567", 6), "123...567");
}

TEST(Printable, CutsBetweenCharacters) {
    std::string text;
    for (int i = 0; i < 100; ++i) text += "\xE2\x82\xAC";
    for (std::size_t maxBytes = 0; maxBytes < 30; ++maxBytes)
        EXPECT_EQ(printable(text, maxBytes).find('\\'), std::string::npos) << maxBytes;
}

TEST(Printable, EscapingTwiceChangesNothing) {
    std::string all;
    for (int byte = 0; byte < 256; ++byte) all += char(byte);
    const std::string once = printable(all);
    EXPECT_EQ(printable(once, once.size()), once);
    for (const char c : once) EXPECT_TRUE(c >= ' ' && c <= '~') << int{c};
}

}  // namespace
}  // namespace espalier
