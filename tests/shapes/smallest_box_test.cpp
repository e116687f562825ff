// SPDX-License-Identifier: Apache-2.0
#include "shapes/smallest_box.h"

#include <espalier/shapes/transform.h>

#include <cmath>
#include <numbers>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

double volumeAlong(const Axes& axes, const std::vector<Point3>& points) {
    const Point3 size = boxAlong(axes, points).size();
    return size[0] * size[1] * size[2];
}

Axes turned(const Affine& map) {
    return {map({1, 0, 0}), map({0, 1, 0}), map({0, 0, 1})};
}

/// Returns the smallest volume over a grid of orientations, about 6° apart: 1,350 directions of an
/// axis (its opposite gives the same box), and 30 angles around each (a quarter turn gives the same
/// box).
double smallestOfManyOrientations(const std::vector<Point3>& points) {
    constexpr int kDirections = 1350, kAngles = 30;
    double smallest = kInfinity;
    for (int i = 0; i < kDirections; ++i) {
        const double z = (i + 0.5) / kDirections, radius = std::sqrt(1 - z * z);
        const double around = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
        const Point3 direction = {radius * std::cos(around), radius * std::sin(around), z};
        const Affine tilt = rotationBetween({0, 0, 1}, direction);
        for (int k = 0; k < kAngles; ++k) {
            const Affine spin = rotation({0, 0, 1}, k * std::numbers::pi / 2 / kAngles);
            smallest = std::min(smallest, volumeAlong(turned(tilt * spin), points));
        }
    }
    return smallest;
}

/// Returns 60 points in a random ellipsoid, or near the edges of a random tetrahedron.
std::vector<Point3> randomCloud(unsigned seed) {
    const auto numbers = randomValues(200, seed);
    std::vector<Point3> points;
    if (seed % 2 == 0) {
        const Affine map = rotation({numbers[180], numbers[181], numbers[182]}, 3) *
                           scaling({1, 1.5 + numbers[183], 2.5 + numbers[184]});
        for (std::size_t i = 0; i < 60; ++i)
            points.push_back(map({numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]}));
    } else {
        for (std::size_t i = 0; i < 4; ++i)
            points.push_back({numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]});
    }
    return points;
}

// The bound that around.h states. Where the search is better than the grid, the ratio is below 1.
TEST(SmallestBox, IsAtMostOnePercentLargerThanTheBestOfManyOrientations) {
    for (unsigned seed = 0; seed < 24; ++seed) {
        const auto points = randomCloud(seed);
        EXPECT_LE(volumeAlong(smallestBox(points, 0), points),
                  1.01 * smallestOfManyOrientations(points))
            << "seed " << seed;
    }
}

TEST(SmallestBox, FindsATurnedBox) {
    for (unsigned seed = 0; seed < 100; ++seed) {
        const auto numbers = randomValues(4, seed);
        const Affine map = rotation({numbers[0], numbers[1], numbers[2]}, 3 * numbers[3]);
        std::vector<Point3> corners;
        for (int i = 0; i < 8; ++i)
            corners.push_back(map({1.0 * (i & 1), 2.0 * (i >> 1 & 1), 3.0 * (i >> 2)}));
        EXPECT_NEAR(volumeAlong(smallestBox(corners, 0), corners), 6, 1e-8) << "seed " << seed;
    }
}

TEST(SmallestBox, HasPerpendicularAxesNearTheCoordinateAxes) {
    for (unsigned seed = 0; seed < 24; ++seed) {
        const Axes axes = smallestBox(randomCloud(seed), 0);
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) {
                double product = 0;
                for (std::size_t k = 0; k < 3; ++k) product += axes[i][k] * axes[j][k];
                EXPECT_NEAR(product, i == j ? 1 : 0, kRounding);
            }
        EXPECT_NEAR(triple(axes[0], axes[1], axes[2]), 1, kRounding) << "right-handed";
        // The sum of the diagonal is 1 + 2 cos of the angle to the coordinate axes. The largest
        // angle of the nearest of 24 orientations of a cube is 62.8 degrees.
        EXPECT_GE(axes[0][0] + axes[1][1] + axes[2][2], 1 + 2 * std::cos(62.8 / 57.2957795));
    }
}

// Of the boxes around points in a plane, which all have no volume, the padding chooses the one with
// the smallest area.
TEST(SmallestBox, PaddingChoosesAmongFlatBoxes) {
    const Affine map = rotation({1, 2, 3}, 0.7);
    std::vector<Point3> square;
    for (int i = 0; i < 4; ++i) square.push_back(map({1.0 * (i & 1), 1.0 * (i >> 1), 0}));
    Point3 sizes = boxAlong(smallestBox(square, 0.1), square).size();
    std::ranges::sort(sizes);
    EXPECT_NEAR(sizes[0], 0, 1e-9);
    EXPECT_NEAR(sizes[1], 1, 1e-9);
    EXPECT_NEAR(sizes[2], 1, 1e-9);
}

TEST(SmallestBox, AcceptsOnePointAndPointsOnALine) {
    const std::vector<Point3> one = {{1, 2, 3}}, line = {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}};
    EXPECT_EQ(volumeAlong(smallestBox(one, 0), one), 0);
    EXPECT_NEAR(volumeAlong(smallestBox(line, 0.1), line), 0, kRounding);
}

}  // namespace
}  // namespace espalier::shapes
