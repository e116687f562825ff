// SPDX-License-Identifier: Apache-2.0
#include "support/test.h"

namespace espalier {
namespace {

TEST(InQuotes, KeepsOrdinaryText) {
    EXPECT_EQ(inQuotes(""), "''");
    EXPECT_EQ(inQuotes("a b"), "'a b'");
    EXPECT_EQ(inQuotes("größe"), "'größe'");
}

// A text from a file must not move the cursor, or forge a second line in a log.
TEST(InQuotes, EscapesTerminalControls) {
    EXPECT_EQ(inQuotes(std::string_view("\x1B[2J\r\n\0\x7F", 8)), "'\\x1B[2J\\x0D\\x0A\\x00\\x7F'");
}

TEST(InQuotes, ShortensLongTexts) {
    EXPECT_EQ(inQuotes(std::string(40, 'x')), "'" + std::string(40, 'x') + "'");
    const std::string half(20, 'x');
    EXPECT_EQ(inQuotes(half + "y" + half), "'" + half + "..." + half + "'");
}

TEST(Listed, ShowsTheFirstItems) {
    EXPECT_EQ(listed(std::vector<int>{}), "");
    EXPECT_EQ(listed(std::vector{4}), "4");
    EXPECT_EQ(listed(std::vector{4, 7, 9}, 3), "4, 7, 9");
    EXPECT_EQ(listed(std::vector{4, 7, 9}, 2), "4, 7, ...");
    EXPECT_EQ(listed(std::vector<std::string>{"a", "b"}), "a, b");
}

}  // namespace
}  // namespace espalier
