// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/io/files/text_reader.h>
#include <espalier/io/model.h>
#include <io/model_files.h>

#include <cmath>
#include <string>
#include <string_view>

#include "io/models/obj_statements.h"

namespace espalier::io {
namespace {

/// A text with everything that an OBJ may contain around its points, with "\n" as line end.
const std::string kFullText =
    "# exported to C:\\models\\\n"
    "mtllib a.mtl\n"
    "\n"
    "  v\t0.50  -1e-3   +2  0.25 # a weight\n"
    "v 1 2 3 0.1 0.2 0.3\n"
    "vn 0 0 1\n"
    "vt 0 1\n"
    "vp 0.5\n"
    "g a \\\n"
    "v b\n"
    "v 1.0 \\\n"
    " 2.0\\\n"
    "3.0# no space\n"
    "f 1/1/1 \\\n"
    " 2/1/1 3/1/1\n"
    "usemtl v 1 2 3\n"
    "v 1e2 0.5 7";  // the last line has no end

TEST(Obj, ReadsThePoints) {
    for (const char* end : {"\n", "\r\n"}) {
        const auto model = readModel("a.obj", withLineEnds(kFullText, end));
        EXPECT_THAT(model->positions(), ElementsAre(Point3{0.5, -1e-3, 2}, Point3{1, 2, 3},
                                                    Point3{1, 2, 3}, Point3{100, 0.5, 7}));
    }
}

/// nextNumber() gives the word of next() and the number of parseNumber(), and goes as far.
TEST(ObjWords, AsNumbersAreTheWordsOfNext) {
    for (const std::string word : {"",      "1",       "-0",  "+2",  "-1.5e3",
                                   "1e400", "-1e-400", "5.",  ".5",  "0.1234567890123456789",
                                   "inf",   "nan",     "x",   "1x",  "0x10",
                                   "1e",    "1e+",     "--1", "+-1", "1,5",
                                   "1/2",   "1\\2",    "1\\"})
        for (const std::string before : {"", " \t", "\\\n", "\\\r\n "})
            for (const std::string after : {"", " 7", "#7", "\\\n7", "\\\r\n7", "\r", "\\ 7"}) {
                const std::string text = before + word + after;
                ObjWords words(text), expectedWords(text);
                double number = 0, expected = 0;
                const std::string_view found = words.nextNumber(number);
                const std::string_view next = expectedWords.next();
                EXPECT_EQ(found, next) << text;
                EXPECT_EQ(found.data(), next.data()) << text;
                EXPECT_EQ(words.next(), expectedWords.next()) << text;
                EXPECT_EQ(!std::isnan(number), parseNumber(next, expected) && !std::isnan(expected))
                    << text;
                if (std::isnan(number)) continue;
                EXPECT_EQ(number, expected) << text;
                EXPECT_EQ(std::signbit(number), std::signbit(expected)) << text;
            }
}

/// The memory for all points is known before they are read: here 48 MB.
TEST(Obj, ChecksTheMemoryOfItsPointsFirst) {
    std::string text;
    for (int i = 0; i < 1'000'000; ++i) text += "v 0 0 0\n";
    const MemoryLimit limit(residentMemory() + (20 << 20));
    EXPECT_REFUSED(MemoryError, "a.obj: a list of its points takes about 48.0 MB",
                   readModel("a.obj", text));
}

TEST(Obj, IsUnchangedIfNoPointMoves) {
    for (const char* end : {"\n", "\r\n"}) {
        const std::string text = withLineEnds(kFullText, end);
        const auto model = readModel("a.obj", text);
        EXPECT_EQ(written(*model, model->positions()), text);
    }
}

TEST(Obj, ReplacesOnlyChangedCoordinates) {
    for (const std::string end : {"\n", "\r\n"}) {
        const auto model = readModel("a.obj", withLineEnds(kFullText, end));
        auto moved = copyOf(model->positions());
        moved[0] = {0.1, -1e-3, 1e-7};
        moved[2] = {-1, -2, -3.5};
        moved[3] = {1.0 / 3, 1e22, 0};
        std::string expected = kFullText;
        const auto replace = [&](const std::string& from, const std::string& to) {
            expected.replace(expected.find(from), from.size(), to);
        };
        replace("0.50  -1e-3   +2 ", "0.1  -1e-3   1e-07 ");
        replace("1.0 \\\n 2.0\\\n3.0#", "-1 \\\n -2\\\n-3.5#");
        // 1/3 needs 16 digits; to_chars uses the shorter of the two notations.
        replace("1e2 0.5 7", "0.3333333333333333 1e+22 0");
        EXPECT_EQ(written(*model, moved), withLineEnds(expected, end));
    }
}

TEST(Obj, WritesTheSameDoubles) {
    const auto model = readModel("a.obj", "v 0 0 0\nv 0 0 0\n");
    const std::vector<Point3> moved = {{0.1 + 0.2, 5e-324, -1.7976931348623157e308},
                                       {1 / 3.0, 1e-300, 123456789.123456789}};
    const auto again = readModel("b.obj", written(*model, moved));
    EXPECT_EQ(copyOf(again->positions()), moved);
}

TEST(Obj, SkipsAByteOrderMark) {
    const std::string text = "\xEF\xBB\xBFv 1 2 3\n";
    const auto model = readModel("a.obj", text);
    EXPECT_THAT(model->positions(), ElementsAre(Point3{1, 2, 3}));
    EXPECT_EQ(written(*model, std::vector<Point3>{{1, 2, 4}}), "\xEF\xBB\xBFv 1 2 4\n");
}

TEST(Obj, ReadsTinyCoordinatesAsZero) {
    const auto model = readModel("a.obj", "v 1e-400 -1e-400 1 1e-999\n");
    EXPECT_THAT(model->positions(), ElementsAre(Point3{0, -0.0, 1}));
}

TEST(Obj, RefusesAMalformedVertexWithItsLineAndTheCause) {
    const auto refused = [](const std::string& line, const std::string& why) {
        EXPECT_THAT([&] { readModel("a.obj", "# one\nv 0 0 0\n" + line + "\nv 1 1 1\nf 1 2 3\n"); },
                    ThrowsMessage<FileError>(AllOf(HasSubstr("a.obj:3: "), HasSubstr(why))))
            << line;
    };
    refused("v", "the line ends; expected x");
    refused("v 1 2", "the line ends; expected z");
    refused("v 1 2 # 3", "the line ends; expected z");
    refused("v 1 two 3", "'two' is not a number; expected y");
    refused("v 1,5 2 3", "'1,5' is not a number; expected x");
    refused("v 1 2 3v 4 5", "'3v' is not a number; expected z");
    refused("v 1 2 3 v 4 5 6", "'v' is not a number; expected w or a colour");
    refused("v nan 0 0", "'nan' is not finite; expected x");
    refused("v 0 0 -inf", "'-inf' is not finite; expected z");
    refused("v 0 1e999 0", "'1e999' is not a number; expected y");
    refused("v 1 \\", "'v' is not a number; expected y");
}

TEST(Obj, RefusesUnknownKeywordsWithTheirLine) {
    using namespace std::string_literals;
    const std::vector<std::pair<std::string, std::string>> samples = {{"V 1 2 3", "'V'"},
                                                                      {"\0v 1 2 3"s, "'\\x00v'"},
                                                                      {"\xC2\xA0v 1 2 3", "v'"},
                                                                      {"1 2 3", "'1'"},
                                                                      {"foo \1", "'foo'"}};
    for (const auto& sample : samples) {
        const std::string text = "# one\nv 0 0 0\n" + sample.first + "\n";
        EXPECT_THAT(
            [&] { readModel("a.obj", text); },
            ThrowsMessage<FileError>(AllOf(HasSubstr("a.obj:3: "),
                                           HasSubstr(sample.second + " is not a keyword of OBJ"))))
            << sample.first;
    }
}

/// Some exporters add statements of their own.
TEST(Obj, KeepsLinesThatItDoesNotKnow) {
    const std::string text = "v 0 0 0\nfoo 1 \xFF\nv 1 0 0\nv 0 1 0\n$bar\nf 1 2 3\n";
    const auto model = readModel("a.obj", text);
    EXPECT_THAT(model->notes(),
                ElementsAre("kept 2 lines whose first word no OBJ has ('foo' in line 2)"));
    EXPECT_EQ(model->readSurface().faces.count(), 1u);
    EXPECT_EQ(written(*model, std::vector<Point3>{{0, 0, 2}, {1, 0, 0}, {0, 1, 0}}),
              "v 0 0 2" + text.substr(7));
    EXPECT_TRUE(readModel("a.obj", kFullText)->notes().empty());
    // A file without any point is no OBJ.
    EXPECT_REFUSED(FileError, "a.obj:1: 'solid' is not a keyword of OBJ files",
                   readModel("a.obj", "solid a\nfacet normal 0 0 1\nendsolid a\n"));
}

TEST(Obj, CountsTheLinesOfContinuedStatements) {
    EXPECT_REFUSED(FileError, "a.obj:4: ", readModel("a.obj", "g a \\\n b \\\r\n c\nv 1 \\\n 2\n"));
}

TEST(Obj, TruncatedFilesAreReadOrRefused) {
    std::size_t readCount = 0;
    for (std::size_t i = 0; i < 20; ++i) {
        const std::string part = kFullText.substr(0, kFullText.size() * i / 20);
        try {
            const auto model = readModel("a.obj", part);
            EXPECT_EQ(written(*model, model->positions()), part);
            ++readCount;
        } catch (const FileError&) {
            // This part ends within a vertex or a keyword, or before the first vertex.
        }
    }
    EXPECT_GE(readCount, 10u);  // half of the ends are neither within a vertex nor a keyword
}

}  // namespace
}  // namespace espalier::io
