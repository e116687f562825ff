// SPDX-License-Identifier: Apache-2.0
#include "cages/oriented_box.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/test.h"

namespace espalier::cages {
namespace {

Point3 randomPoint(std::mt19937& random, double size) {
    std::uniform_real_distribution<double> place(-size, size);
    return {place(random), place(random), place(random)};
}

TEST(OrientedBox, isApartOnlyFromBoxesWithoutNearPoints) {
    std::mt19937 random(4);
    const auto randomBox = [&] {
        const Point3 normal = randomPoint(random, 1), centre = randomPoint(random, 1);
        const auto axes = axesAround(normal, cross(normal, randomPoint(random, 1)));
        std::vector<Point3> points;
        for (int i = 0; i < 20; ++i) points.push_back(sum(centre, randomPoint(random, 0.5)));
        return OrientedBox(axes, points);
    };
    // Points of a box: a regular grid of 5 x 5 x 5.
    const auto pointIn = [](const OrientedBox& box, int number) {
        Point3 point = box.middle;
        for (std::size_t axis = 0; axis < 3; ++axis, number /= 5)
            point = sum(point, scaled(box.axes[axis], box.half[axis] * (number % 5 - 2) / 2));
        return point;
    };
    int apart = 0, near = 0;
    for (int pair = 0; pair < 300; ++pair) {
        const OrientedBox a = randomBox(), b = randomBox();
        const double margin = 0.05 * (pair % 4);
        bool hasNear = false;
        for (int number = 0; number < 125; ++number)
            hasNear |= a.isNear(pointIn(b, number), margin);
        // Points of the own box are in it; the tolerance covers rounding.
        ASSERT_TRUE(a.isNear(pointIn(a, pair % 125), 1e-12));
        near += hasNear;
        if (!a.isApart(b, margin) && !b.isApart(a, margin)) continue;
        ++apart;
        EXPECT_FALSE(hasNear) << "pair " << pair;
    }
    EXPECT_GE(near, 50);
    // Most boxes that do not meet are apart along an axis of one of them.
    EXPECT_GE(apart, 50);
}

TEST(OrientedBox, hasTheAxesOfTheCoordinatesWithoutANormal) {
    const std::vector<Point3> points = {{1, 2, 3}, {2, 4, 3}};
    const OrientedBox box(axesAround({0, 0, 0}, {0, 0, 0}), points);
    EXPECT_EQ(box.low, points[0]);
    EXPECT_EQ(box.high, points[1]);
    EXPECT_EQ(box.middle, (Point3{1.5, 3, 3}));
    EXPECT_EQ(box.half, (Point3{0.5, 1, 0}));
}

}  // namespace
}  // namespace espalier::cages
