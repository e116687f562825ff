// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/files/text_reader.h>
#include <io/model_files.h>

#include <cstdint>

#include "support/test.h"

namespace espalier::test {
namespace {

using io::TextReader;

TEST(TextReader, TracksTheLine) {
    TextReader text("f", "one two\n\n three\nrest of it\r\nlast", 10);
    EXPECT_EQ(text.token("a word"), "one");
    EXPECT_EQ(text.line(), 10u);
    EXPECT_EQ(text.restOfLine(), " two");
    EXPECT_EQ(text.token("a word"), "three");
    EXPECT_EQ(text.line(), 12u);
    text.restOfLine();
    EXPECT_EQ(text.restOfLine(), "rest of it");
    EXPECT_EQ(text.remaining(), 4u);
    EXPECT_EQ(text.token("a word"), "last");
    EXPECT_TRUE(text.atEnd());
    EXPECT_EQ(messageOf<io::FileError>([&] { text.token("a word"); }),
              "f:14: the file ends; expected a word");
}

TEST(TextReader, SkipsCommentsBetweenTokensOnly) {
    TextReader text("f", "# first\n1#one\n  # 2\n3 four # five\nsix #7\n");
    text.skipComments('#');
    EXPECT_EQ(text.number<int>("a number"), 1);
    EXPECT_EQ(text.number<int>("a number"), 3);
    EXPECT_EQ(text.line(), 4u);
    EXPECT_EQ(text.restOfLine(), " four # five");
    EXPECT_EQ(text.token("a word"), "six");
    EXPECT_TRUE(text.atEnd());
}

TEST(TextReader, WithoutACommentMarkHasNoComments) {
    TextReader text("f", "# 1");
    EXPECT_EQ(text.token("a word"), "#");
}

TEST(TextReader, RefusesMalformedNumbers) {
    for (const char* word : {"1x", "--1", "1e999", "0x10", "+"}) {
        TextReader text("f", word);
        std::string expected = "f:1: '";
        expected.append(word).append("' is not a number; expected a size");
        EXPECT_EQ(messageOf<io::FileError>([&] { text.number<double>("a size"); }), expected);
    }
    TextReader text("f", "-1");
    EXPECT_REFUSED(io::FileError, "'-1'", text.number<std::uint64_t>("a size"));
}

TEST(TextReader, RefusesCountsThatTheTextCannotHold) {
    // Three points with two bytes per number; the last one lacks its separator, so "0 0 0" has 5
    // bytes.
    const std::string points = "3\n0 0 0\n0 0 0\n0 0 0";
    TextReader text("f", points);
    EXPECT_EQ(text.count("the number of points", 6), 3u);
    std::string fourPoints = points;
    fourPoints[0] = '4';
    TextReader more("f", fourPoints);
    EXPECT_EQ(messageOf<io::FileError>([&] { more.count("the number of points", 6); }),
              "f:1: the number of points is 4, but only 18 bytes are left");
    TextReader most("f", "18446744073709551615 1 2 3");
    EXPECT_REFUSED(io::FileError, "but only", most.count("the number of points", 1));
}

TEST(TextReader, ReadsBytes) {
    TextReader text("f", std::string_view("a\n\0\n\xff"
                                          "b",
                                          6));
    text.token("a word");
    text.restOfLine();
    EXPECT_EQ(text.bytes(3, "data"), std::string_view("\0\n\xff", 3));
    EXPECT_EQ(messageOf<io::FileError>([&] { text.bytes(2, "data"); }),
              "f:2: the file ends; expected data (2 bytes, got 1)");
    EXPECT_EQ(text.token("a word"), "b");
}

TEST(ParseNumber, ReadsTinyNumbersAsZero) {
    const std::string zeros(400, '0');
    const std::string ones(400, '1');
    for (const std::string& digits :
         {std::string("1e-400"), std::string("1E-400"), std::string("2e-324"),
          std::string("9.9e-99999999999999999999"), "0." + zeros + "1", "0." + zeros + "1e+5",
          "." + zeros + "7", ones + "e-900", ones + "." + ones + "e-900",
          std::string("0012.5e-400")}) {
        for (const char* const prefix : {"", "+", "-"}) {
            const std::string sign = prefix;
            double number = 1;
            EXPECT_TRUE(io::parseNumber(sign + digits, number)) << sign + digits;
            EXPECT_EQ(number, 0) << sign + digits;
            EXPECT_EQ(std::signbit(number), sign == "-") << sign + digits;
        }
        float single = 1;
        EXPECT_TRUE(io::parseNumber(digits, single)) << digits;
        EXPECT_EQ(single, 0) << digits;
    }
    float single = 1;
    EXPECT_TRUE(io::parseNumber(std::string_view("-1e-50"), single));
    EXPECT_EQ(single, 0);
    double number = 0;
    EXPECT_TRUE(io::parseNumber(std::string_view("4e-324"), number));
    EXPECT_EQ(number, 5e-324);
    EXPECT_TRUE(io::parseNumber("0." + zeros + "1e401", number));
    EXPECT_EQ(number, 1);
}

TEST(ParseNumber, RefusesTooLargeNumbers) {
    const std::string zeros(400, '0');
    for (const std::string& text :
         {std::string("1e400"), std::string("-1E+400"), "1" + zeros, "1" + zeros + ".5",
          "1" + zeros + "e-5", "0." + zeros + "1e900", std::string("1e99999999999999999999"),
          std::string("1e-400x")}) {
        double number = 1;
        EXPECT_FALSE(io::parseNumber(text, number)) << text;
    }
    float single = 1;
    EXPECT_FALSE(io::parseNumber(std::string_view("1e39"), single));
    std::int32_t whole = 1;
    EXPECT_FALSE(io::parseNumber(std::string_view("-2147483649"), whole));
}

TEST(FormatNumber, ReadsBackAsTheSameNumber) {
    for (const double number : {0.1, 1.0 / 3, 5e-324, -0.0, 1e300, 1.0000000000000002}) {
        double got = 1;
        EXPECT_TRUE(io::parseNumber(io::formatNumber(number), got));
        EXPECT_EQ(std::signbit(got), std::signbit(number));
        EXPECT_EQ(got, number);
    }
    EXPECT_EQ(io::formatNumber(0.1f), "0.1");
}

TEST(LowerCase, ChangesAsciiLettersOnly) {
    EXPECT_EQ(io::lowerCase("AzZ_9\xc3\x84"), "azz_9\xc3\x84");
}

}  // namespace
}  // namespace espalier::test
