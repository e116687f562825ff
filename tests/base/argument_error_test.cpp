// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>

#include "support/test.h"

namespace espalier {
namespace {

constexpr auto withUnderscores = [](const std::string& name) { return separated(name, '_'); };

TEST(ArgumentError, NamesTheFunctionAndTheField) {
    const ArgumentError error("torus", "gridCells", "0", "1 or more");
    EXPECT_STREQ(error.what(), "torus: gridCells: expected 1 or more, got 0");
    EXPECT_EQ(error.field(), "gridCells");
}

TEST(ArgumentError, HasNoFunctionIfSeveralShareTheCheck) {
    EXPECT_STREQ(ArgumentError("", "level", "0", "1 to 10").what(),
                 "level: expected 1 to 10, got 0");
}

TEST(ArgumentError, NamesTheOtherFieldAsTheFrontEndDoes) {
    const ArgumentError below("torus", "minorRadius", "3", "a number below", {"majorRadius", "1"});
    EXPECT_STREQ(below.what(),
                 "torus: minorRadius: expected a number below majorRadius (1), got 3");
    EXPECT_EQ(below.message(withUnderscores),
              "torus: minor_radius: expected a number below major_radius (1), got 3");
    EXPECT_EQ(below.messageOfField(withUnderscores),
              "minor_radius: expected a number below major_radius (1), got 3");
    const ArgumentError other("cylinder", "to", "(0, 0, 0)", "a point other than", {"from", ""});
    EXPECT_EQ(other.messageOfField(withUnderscores),
              "to: expected a point other than from, got (0, 0, 0)");
}

TEST(ArgumentError, LeavesItsOwnWordsAsTheyAre) {
    // "from" and "aB" are words of the library here, and names of fields elsewhere.
    const ArgumentError error("f", "aB", "aB", "from aB");
    EXPECT_EQ(error.message([](const std::string&) { return std::string("X"); }),
              "X: X: expected from aB, got aB");
}

TEST(Separated, BeginsAWordAtEachCapitalAfterALetter) {
    EXPECT_EQ(separated("minorRadius", '-'), "minor-radius");
    EXPECT_EQ(separated("cellsAlongLongest", '_'), "cells_along_longest");
    EXPECT_EQ(separated("joints[1].position", '_'), "joints[1].position");
    EXPECT_EQ(separated("", '_'), "");
}

}  // namespace
}  // namespace espalier
