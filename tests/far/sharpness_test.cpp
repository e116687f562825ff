// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/marks.h>

#include "support/test.h"

namespace espalier::far {
namespace {

TEST(Sharpness, IsStoredInSinglePrecisionAndInfiniteFromTenOn) {
    EXPECT_EQ(storedSharpness(0), kSmooth);
    EXPECT_EQ(storedSharpness(0.1), 0.1F);
    EXPECT_EQ(storedSharpness(9.99), 9.99F);
    EXPECT_EQ(storedSharpness(10), kInfinitelySharp);
    EXPECT_EQ(storedSharpness(9.99999999), kInfinitelySharp) << "10 in single precision";
    EXPECT_EQ(storedSharpness(1e300), kInfinitelySharp);
    EXPECT_TRUE(isSemiSharp(9.99F));
    EXPECT_FALSE(isSemiSharp(kSmooth));
    EXPECT_FALSE(isSemiSharp(kInfinitelySharp));
}

TEST(Sharpness, LosesOneALevel) {
    EXPECT_EQ(subdivideSharpness(2.5F), 1.5F);
    EXPECT_EQ(subdivideSharpness(1.0F), 0.0F);
    EXPECT_EQ(subdivideSharpness(0.25F), 0.0F);
    EXPECT_EQ(subdivideSharpness(kSmooth), kSmooth);
    EXPECT_EQ(subdivideSharpness(kInfinitelySharp), kInfinitelySharp);
}

// Chaikin's rule: 3/4 of the edge's own sharpness, plus 1/4 of the mean of the other semi-sharp
// edges at that end, minus 1.
TEST(Sharpness, IsAveragedAroundAVertexByChaikinsRule) {
    const std::vector<float> around = {4, 2, 0, kInfinitelySharp, 1};
    const auto child = [&](float sharpness) {
        return subdivideEdgeSharpness(Creasing::Chaikin, sharpness, around);
    };
    EXPECT_EQ(child(4), 0.75F * 4 + 0.25F * 1.5F - 1);  // the other edges: 2 and 1
    EXPECT_EQ(child(2), 0.75F * 2 + 0.25F * 2.5F - 1);  // 4 and 1
    EXPECT_EQ(child(1), 0.75F * 1 + 0.25F * 3.0F - 1);  // 4 and 2
    EXPECT_EQ(child(0), 0);
    EXPECT_EQ(child(kInfinitelySharp), kInfinitelySharp);
    // An edge alone among smooth and infinitely sharp edges is not averaged.
    const std::vector<float> alone = {1.5F, 0, kInfinitelySharp};
    EXPECT_EQ(subdivideEdgeSharpness(Creasing::Chaikin, 1.5F, alone), 0.5F);
    // 0.75 · 0.5 + 0.25 · 1 − 1 is negative, and sharpness is at least 0.
    const std::vector<float> low = {0.5F, 1.0F};
    EXPECT_EQ(subdivideEdgeSharpness(Creasing::Chaikin, 0.5F, low), 0);
    // Uniform creasing ignores the other edges.
    EXPECT_EQ(subdivideEdgeSharpness(Creasing::Uniform, 4, around), 3);
}

}  // namespace
}  // namespace espalier::far
