// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/shared_points.h"
#include <limits>
#include "support/test.h"

namespace espalier::io {
namespace {

using Points = std::vector<Point3>;

SharedPoints find(const std::vector<Points>& parts) {
    std::vector<std::span<const Point3>> spans(parts.begin(), parts.end());
    return findSharedPoints(spans);
}

TEST(SharedPoints, EqualCoordinatesInTwoPartsAreOnePoint) {
    const auto shared = find({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}},
                              {{2, 0, 0}, {3, 0, 0}, {1, 0, 0}},
                              {{4, 0, 0}, {1, 0, 0}}});
    EXPECT_EQ(shared.count, 5);
    EXPECT_THAT(shared.numbers,
                ElementsAre(ElementsAre(0, 1, 2), ElementsAre(2, 3, 1), ElementsAre(4, 1)));
}

TEST(SharedPoints, TheNextNumberIsAnotherPoint) {
    const double next = std::nextafter(1.0, 2.0);
    EXPECT_EQ(find({{{1, 2, 3}}, {{next, 2, 3}}, {{1, 2, 3}}}).count, 2);
    // Zero has two signs.
    EXPECT_EQ(find({{{0, -0.0, 3}}, {{-0.0, 0, 3}}}).count, 1);
}

// A baffle has two points at one place, and a part may have both or one of them.
TEST(SharedPoints, SeveralPointsOfAPartAtOnePlaceStaySeveral) {
    const Point3 p = {1, 2, 3}, q = {0, 5, 9};
    const auto shared = find({{p, q, p}, {p, p, p}, {p}});
    EXPECT_EQ(shared.count, 4);
    EXPECT_THAT(shared.numbers,
                ElementsAre(ElementsAre(0, 1, 2), ElementsAre(0, 2, 3), ElementsAre(0)));
    EXPECT_EQ(find({{p, p}}).count, 2);
    EXPECT_EQ(find({}).count, 0);
    EXPECT_EQ(find({{}, {p}, {}}).count, 1);
}

TEST(SharedPoints, NumbersThatAreNotFiniteAreOrdered) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinite = std::numeric_limits<double>::infinity();
    const auto shared = find({{{nan, 0, 0}, {1, 0, 0}}, {{1, 0, 0}, {infinite, 0, 0}}});
    EXPECT_THAT(shared.numbers, ElementsAre(ElementsAre(0, 1), ElementsAre(1, 0)));
}

}  // namespace
}  // namespace espalier::io
