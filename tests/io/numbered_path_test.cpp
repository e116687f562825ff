// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/numbered_path.h>

#include "support/test.h"

namespace espalier::io {
namespace {

TEST(NumberedPath, OnePoseGetsThePatternItself) {
    EXPECT_EQ(numberedPath("out.obj", 0, 1), "out.obj");
    EXPECT_EQ(numberedPath("/a/b.c/out", 0, 1), "/a/b.c/out");
}

TEST(NumberedPath, SeveralPosesGetTheNumberBeforeTheExtension) {
    EXPECT_EQ(numberedPath("out.obj", 0, 2), "out.0000.obj");
    EXPECT_EQ(numberedPath("out.obj", 12, 20), "out.0012.obj");
    EXPECT_EQ(numberedPath("out.obj", 12345, 20000), "out.12345.obj");
    EXPECT_EQ(numberedPath("/a/b.c/out", 1, 2), "/a/b.c/out.0001");
    EXPECT_EQ(numberedPath("a.tar.gz", 1, 2), "a.tar.0001.gz");
    EXPECT_EQ(numberedPath("../out.ply", 1, 2), "../out.0001.ply");
    EXPECT_EQ(numberedPath("a/case/", 0, 1).string(), "a/case/");
    EXPECT_EQ(numberedPath("a/case/", 1, 2).string(), "a/case.0001/");
}

TEST(NumberedPath, PercentDGivesTheNumberItsPlace) {
    EXPECT_EQ(numberedPath("out%d.obj", 7, 1), "out7.obj");
    EXPECT_EQ(numberedPath("out%04d.obj", 7, 1), "out0007.obj");
    EXPECT_EQ(numberedPath("out%04d.obj", 7, 100), "out0007.obj");
    EXPECT_EQ(numberedPath("out%02d.obj", 123, 200), "out123.obj");
    EXPECT_EQ(numberedPath("%012d", 7, 100), "000000000007");
    EXPECT_EQ(numberedPath("poses/%03d/out.obj", 7, 100), "poses/007/out.obj");
}

TEST(NumberedPath, OtherPercentSignsAreRefused) {
    for (const char* pattern :
         {"%", "out%", "100%.obj", "%s.obj", "%n.obj", "%4d.obj", "%-4d.obj", "%0d.obj", "%00d.obj",
          "%0100d.obj", "%04", "%04x.obj", "%%.obj", "%ld.obj", "% d.obj"})
        for (const int count : {1, 2})
            EXPECT_THAT([&] { numberedPath(pattern, 0, count); },
                        ThrowsMessage<Error>(AllOf(HasSubstr(pattern), HasSubstr("%04d"))));
    EXPECT_REFUSED(Error, "more than one %", numberedPath("%d_%d.obj", 0, 2));
    EXPECT_REFUSED(Error, "more than one %", numberedPath("%d100%.obj", 0, 2));
}

TEST(NumberedPath, RefusesNegativeNumbersAndMissingFileNames) {
    EXPECT_THROW(numberedPath("", 0, 2), Error);
    EXPECT_THROW(numberedPath("/", 0, 2), Error);
    EXPECT_THROW(numberedPath("out.obj", -1, 2), Error);
}

}  // namespace
}  // namespace espalier::io
