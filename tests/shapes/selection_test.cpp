// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/selection.h>

#include <cmath>

#include "support/test.h"

namespace espalier::shapes {
namespace {

/// The points 0, 0.1, …, 1 of the x axis.
std::vector<Point3> ruler() {
    std::vector<Point3> points;
    for (int i = 0; i <= 10; ++i) points.push_back({0.1 * i, 0, 0});
    return points;
}

void expectWeights(const std::vector<double>& weights, const std::vector<double>& expected) {
    ASSERT_EQ(weights.size(), expected.size());
    for (std::size_t i = 0; i < weights.size(); ++i)
        EXPECT_NEAR(weights[i], expected[i], 1e-14) << "position " << i;  // some roundings of 0.1
}

// The bound 0.3 of a region includes the position 0.1 · 3, which is larger by a rounding.
TEST(Selection, RegionsIncludeTheirBounds) {
    const auto points = ruler();
    ASSERT_GT(points[3][0], 0.3);
    const std::vector<double> first = {1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0};
    expectWeights(selectBox(points, {-1, -1, -1}, {0.3, 1, 1}), first);
    expectWeights(selectBox(points, {0.3, 1, 1}, {-1, -1, -1}), first);
    expectWeights(selectBall(points, {0, 0, 0}, 0.3), first);
    expectWeights(selectHalfSpace(points, {0.3, 5, 7}, {-2, 0, 0}), first);
    expectWeights(selectNumbers(points, std::vector<Index>{3, 0, 1, 2, 1}), first);
    expectWeights(selectEnd(points, {-1, 0, 0}), {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    expectWeights(selectEnd(points, {3, 0, 0}), {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1});
}

TEST(Selection, FalloffsDecreaseWithTheDistance) {
    const auto points = ruler();
    const Falloff linear{Falloff::Profile::Linear, 0.4}, smooth{Falloff::Profile::Smooth, 0.4};
    const std::vector<double> line = {1, 1, 1, 1, 0.75, 0.5, 0.25, 0, 0, 0, 0};
    // 1 − 3u² + 2u³ at u = 1/4, 1/2 and 3/4.
    const std::vector<double> curve = {1, 1, 1, 1, 27.0 / 32, 0.5, 5.0 / 32, 0, 0, 0, 0};
    expectWeights(selectBox(points, {-1, -1, -1}, {0.3, 1, 1}, linear), line);
    expectWeights(selectBox(points, {-1, -1, -1}, {0.3, 1, 1}, smooth), curve);
    expectWeights(selectBall(points, {0, 0, 0}, 0.3, linear), line);
    expectWeights(selectBall(points, {0, 0, 0}, 0.3, smooth), curve);
    expectWeights(selectHalfSpace(points, {0.3, 0, 0}, {-1, 0, 0}, smooth), curve);
    expectWeights(selectNumbers(points, std::vector<Index>{0, 1, 2, 3}, linear), line);
    expectWeights(selectEnd(points, {1, 0, 0}, {Falloff::Profile::Linear, 0.2}),
                  {0, 0, 0, 0, 0, 0, 0, 0, 0.05, 0.55, 1});  // 0.19 and 0.09 from the last 1 %
}

// The distance from a box is to its nearest corner, edge or side.
TEST(Selection, DistancesAreEuclidean) {
    const std::vector<Point3> points = {{1 + 3, 1 + 4, 1}, {0.5, 0.5, 3}, {9, 9, 9}};
    const Falloff linear{Falloff::Profile::Linear, 10};
    const auto weights = selectBox(points, {0, 0, 0}, {1, 1, 1}, linear);
    EXPECT_NEAR(weights[0], 0.5, 1e-15);
    EXPECT_NEAR(weights[1], 0.8, 1e-15);
    EXPECT_EQ(weights[2], 0);
}

TEST(Selection, TheEndOfABoxIsItsLastLayer) {
    const Lattice lattice = box({.cells = {2, 3, 50}});
    const auto weights = selectEnd(lattice.positions, {0, 0, 1});
    for (std::size_t i = 0; i < weights.size(); ++i)
        EXPECT_EQ(weights[i], lattice.positions[i][2] == 1 ? 1 : 0);
}

TEST(Selection, RefusesArgumentsOutOfRange) {
    const auto points = ruler();
    EXPECT_REFUSED(Error, "selectBox: corner: expected finite numbers, got (nan, 0, 0)",
                   selectBox(points, {kNan, 0, 0}, {1, 1, 1}));
    EXPECT_REFUSED(Error, "selectBall: radius: expected a finite number of 0 or more, got -1",
                   selectBall(points, {0, 0, 0}, -1));
    EXPECT_REFUSED(Error, "selectHalfSpace: normal: expected a vector other than 0, got (0, 0, 0)",
                   selectHalfSpace(points, {0, 0, 0}, {0, 0, 0}));
    EXPECT_REFUSED(Error, "there are no positions", selectEnd({}, {1, 0, 0}));
    EXPECT_REFUSED(Error, "selectNumbers: numbers[1]: expected 0 to 10, got 11",
                   selectNumbers(points, std::vector<Index>{0, 11}));
    EXPECT_REFUSED(Error, "numbers[0]: expected 0 to 10, got -1",
                   selectNumbers(points, std::vector<Index>{-1}));
    EXPECT_REFUSED(Error,
                   "selectBall: falloff.radius: expected a finite number of 0 or more, got -2",
                   selectBall(points, {0, 0, 0}, 1, {Falloff::Profile::Linear, -2}));
    EXPECT_REFUSED(Error, "positions[0]",
                   selectBall(std::vector<Point3>{{kInfinity, 0, 0}}, {0, 0, 0}, 1));
    EXPECT_TRUE(selectBall({}, {0, 0, 0}, 1).empty());
}

// The distances overflow: the weights would be NaN, or all positions would count as selected.
TEST(Selection, RefusesPositionsThatAreInfinitelyFarApart) {
    const std::vector<Point3> apart = {{-1e308, 0, 0}, {1e308, 0, 0}}, far = {{-1e308, 0, 0}};
    EXPECT_MESSAGE("the positions are so far apart that their distance is infinite",
                   selectBall(apart, {0, 0, 0}, 1));
    EXPECT_MESSAGE(
        "positions[0] is (-1e+308, 0, 0), so far away that its distance is not a "
        "number",
        selectHalfSpace(far, {1e308, 0, 0}, {0, 1, 0}));
}

}  // namespace
}  // namespace espalier::shapes
