// SPDX-License-Identifier: Apache-2.0
#include "cages/surface_samples.h"

#include <espalier/base/vector3.h>
#include <gtest/gtest.h>

#include "support/test.h"

namespace espalier::cages {
namespace {

TEST(ForEachSample, visitsCornersMiddlesAndCentroids) {
    const std::vector<Point3> points = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}};
    const std::vector<Triangle> triangles = {{0, 1, 2}, {1, 1, 1}};
    std::vector<std::pair<Point3, std::size_t>> visited;
    forEachSample(triangles, points, 10,
                  [&](const Point3& point, std::size_t t) { visited.emplace_back(point, t); });
    const auto at = [](double x, double y, std::size_t t) { return std::pair(Point3{x, y, 0}, t); };
    EXPECT_THAT(visited, ::testing::UnorderedElementsAre(
                             at(0, 0, 0), at(3, 0, 0), at(0, 3, 0), at(1.5, 0, 0), at(1.5, 1.5, 0),
                             at(0, 1.5, 0), at(1, 1, 0), at(3, 0, 1), at(3, 0, 1), at(3, 0, 1)));
}

TEST(ForEachSample, leavesNoPointOfATriangleFarFromASample) {
    const std::vector<Point3> points = {{0, 0, 0}, {3, 0.2, 0}, {0.4, 1, 2}};
    const std::vector<Triangle> triangles = {{0, 1, 2}};
    constexpr double kSpacing = 0.1;
    std::vector<Point3> samples;
    forEachSample(triangles, points, kSpacing,
                  [&](const Point3& point, std::size_t) { samples.push_back(point); });
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < 200; ++i) {
        double u = uniform(random), v = uniform(random);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const Point3 p = sum(scaled(points[1], u), scaled(points[2], v));
        double least = 9;
        for (const Point3& sample : samples) least = std::min(least, length(difference(sample, p)));
        // No side of a part is longer than the spacing, so that a corner is at most this far away.
        EXPECT_LE(least, kSpacing / std::sqrt(3));
    }
}

}  // namespace
}  // namespace espalier::cages
