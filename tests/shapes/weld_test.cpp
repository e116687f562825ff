// SPDX-License-Identifier: Apache-2.0
#include "shapes/weld.h"

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

/// Welds points by the definition of weld(), comparing every pair.
Welding weldSlowly(const std::vector<Point3>& points, double distance) {
    Welding welding;
    for (const Point3& point : points) {
        std::size_t best = welding.positions.size();
        double bestDistance = distance;
        for (std::size_t kept = 0; kept < welding.positions.size(); ++kept) {
            const double apart = norm(minus(welding.positions[kept], point));
            if (apart > bestDistance) continue;
            if (apart == bestDistance && best < kept) continue;
            best = kept;
            bestDistance = apart;
        }
        if (best == welding.positions.size()) welding.positions.push_back(point);
        welding.newIndex.push_back(Index(best));
    }
    return welding;
}

TEST(Weld, AgreesWithComparingAllPairs) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> wide(-1, 1);
    for (const double distance : {0.0, 1e-9, 0.01, 0.2, 3.0}) {
        std::vector<Point3> points;
        for (int i = 0; i < 300; ++i) {
            const Point3 point = {wide(random), wide(random), wide(random)};
            points.push_back(point);
            points.push_back(point);
            // A point slightly nearer or farther than the distance, in any direction.
            points.push_back({point[0] + distance * wide(random),
                              point[1] + distance * wide(random),
                              point[2] + distance * wide(random)});
        }
        const Welding fast = weld(points, distance);
        const Welding slow = weldSlowly(points, distance);
        EXPECT_EQ(fast.newIndex, slow.newIndex) << distance;
        EXPECT_EQ(fast.positions, slow.positions) << distance;
    }
}

TEST(Weld, FindsPointsOnTheBordersOfBoxes) {
    // These coordinates are on the borders of boxes, since the box size is the whole times a power
    // of two.
    std::vector<Point3> points;
    for (int i = 0; i <= 16; ++i) {
        points.push_back({i / 16.0, 0, 0});
        points.push_back({i / 16.0 - 1e-12, 0, 0});
        points.push_back({i / 16.0 + 1e-12, 0, 0});
    }
    EXPECT_EQ(weld(points, 1e-10).positions.size(), 17U);
}

TEST(Weld, AcceptsCoincidentPointsAndNoPoints) {
    const std::vector<Point3> same(5, Point3{1, 2, 3});
    EXPECT_EQ(weld(same, 0).newIndex, (std::vector<Index>(5, 0)));
    EXPECT_TRUE(weld({}, 1).positions.empty());
}

TEST(Weld, TreatsBothZerosAsEqual) {
    const std::vector<Point3> points = {{0.0, 0, 1}, {-0.0, 0, 1}, {1, 0, 0}};
    EXPECT_EQ(weld(points, 0).positions.size(), 2U);
}

}  // namespace
}  // namespace espalier::shapes
