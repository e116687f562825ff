// SPDX-License-Identifier: Apache-2.0
#include "cages/point_groups.h"

#include <espalier/base/vector3.h>
#include <gtest/gtest.h>

#include "grid_cages.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

std::vector<Point3> randomPoints(int count) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> place(-1, 1);
    std::vector<Point3> points(count);
    for (Point3& p : points) p = {place(random), place(random), place(random)};
    return points;
}

constexpr auto everyCell = [](std::optional<Index>) { return true; };

TEST(CubeGrid, ringsVisitEachCubeOnce) {
    const CubeGrid grid({0, 0, 0}, {1, 0.6, 0.3}, 0.1);
    std::vector<int> visits(grid.cubeCount(), 0);
    for (Index ring = 0; ring < 20; ++ring)
        grid.forEachInRing({3, 1, 2}, ring, [&](Index cube) { ++visits[cube]; });
    EXPECT_THAT(visits, Each(1));
}

TEST(CubeGrid, doesNotExceedItsMemory) {
    const CubeGrid grid({0, 0, 0}, {1, 1, 1}, 1e-6);
    EXPECT_LE(grid.cubeCount(), 30'000'000);
    EXPECT_GT(grid.cubeCount(), 1'000'000);
}

TEST(PointGroups, holdsEachPointOnce) {
    auto points = randomPoints(1000);
    const CubeGrid grid({-1, -1, -1}, {1, 1, 1}, 0.2);
    const PointGroups groups(test::fitPoints(points), grid);
    EXPECT_THAT(std::vector(groups.points().begin(), groups.points().end()),
                ::testing::UnorderedElementsAreArray(points));
    for (const auto& group : groups.groups())
        for (Index i = group.first; i < group.last; ++i) {
            EXPECT_EQ(grid.cubeOf(groups.points()[i]), group.cube);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                EXPECT_GE(groups.points()[i][axis], group.bounds.min[axis]);
                EXPECT_LE(groups.points()[i][axis], group.bounds.max[axis]);
            }
        }
    points.insert(points.end(), points.begin(), points.end());
    std::shuffle(points.begin(), points.end(), std::mt19937(2));
    const PointGroups again(test::fitPoints(points), grid);
    EXPECT_TRUE(std::ranges::equal(again.points(), groups.points()));
}

TEST(PointGroups, findsTheNearestGroup) {
    const PointGroups groups(test::fitPoints(randomPoints(300)),
                             CubeGrid({-1, -1, -1}, {1, 1, 1}, 0.1));
    for (const Point3& query : randomPoints(50)) {
        const Point3 place = scaled(query, 1.2);
        double least = 1e9;
        for (const auto& group : groups.groups())
            least = std::min(least, length(difference(group.centre, place)));
        Offset visits = 0;
        const auto found = groups.nearest(
            place, 30, everyCell, [](Index) { return true; }, visits);
        ASSERT_TRUE(found);
        EXPECT_EQ(length(difference(groups.groups()[*found].centre, place)), least);
    }
    const std::vector<Point3> one = {{-0.95, -0.95, -0.95}};
    const PointGroups far(test::fitPoints(one), CubeGrid({-1, -1, -1}, {1, 1, 1}, 0.1));
    Offset visits = 0;
    EXPECT_EQ(far.nearest(
                  {0.95, 0.95, 0.95}, 3, everyCell, [](Index) { return true; }, visits),
              std::nullopt);
}

// Few points in a flat grid: most cubes have no point within the rings. The search visits blocks of
// cubes, and may neither lose a group because of it, nor find one beyond the rings.
TEST(PointGroups, findsTheNearestGroupThatIsAcceptedWithinSomeRings) {
    const CubeGrid grid({-1, -1, -1}, {1, 1, -0.6}, 0.1);
    std::vector<FitPoint> points;
    for (const Point3& p : randomPoints(20)) {
        const auto number = static_cast<Index>(points.size());
        points.push_back({.position = {p[0], p[1], -0.8 + 0.2 * p[2]},
                          .cell = number % 4 == 0 ? std::nullopt : std::optional(number % 3),
                          .isInner = number % 5 == 0});
    }
    const PointGroups groups(points, grid);
    const auto isWanted = [](std::optional<Index> cell) { return cell != 1; };
    const auto isOdd = [](Index group) { return group % 2 == 1; };
    for (const Index rings : {0, 1, 4, 40})
        for (const Point3& query : randomPoints(200)) {
            const Point3 place = {1.2 * query[0], 1.2 * query[1], -0.8 + 0.5 * query[2]};
            std::optional<Index> expected;
            double least = 1e9;
            for (Index number = 1; number < std::ssize(groups.groups()); number += 2) {
                const auto& group = groups.groups()[number];
                if (group.isInner || group.cell == 1) continue;
                const auto a = grid.coordinatesOf(group.centre), b = grid.coordinatesOf(place);
                Index ring = 0;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    ring = std::max(ring, std::abs(a[axis] - b[axis]));
                const double distance = length(difference(group.centre, place));
                if (ring > rings || distance >= least) continue;
                expected = number;
                least = distance;
            }
            Offset visits = 0;
            EXPECT_EQ(groups.nearest(place, rings, isWanted, isOdd, visits), expected);
            // A group and its list; 11 * 11 * 9 blocks, with edges.
            EXPECT_LE(visits, 2 * groups.groups().size() + 1100);
            // A guess may be right, wrong, too far, or not accepted.
            for (Index guess = 0; guess < std::ssize(groups.groups()); ++guess) {
                if (groups.groups()[guess].isInner) continue;
                Offset visitsWithGuess = 0;
                EXPECT_EQ(groups.nearest(place, rings, isWanted, isOdd, visitsWithGuess, guess),
                          expected)
                    << guess;
                // The search may go by rows with a guess, and by blocks without one.
                EXPECT_LE(visitsWithGuess, 2 * groups.groups().size() + 1100) << guess;
            }
        }
}

TEST(PointGroups, findsTheFarthestPoint) {
    const std::vector<Point3> points = {{0.01, 0, 0}, {0.02, 0, 0.05}, {0.03, 0.01, 0}};
    const PointGroups groups(test::fitPoints(points), CubeGrid({0, 0, 0}, {1, 1, 1}, 1));
    ASSERT_EQ(groups.groups().size(), 1u);
    EXPECT_EQ(groups.farthest(groups.groups()[0], {1, 0, 0}), points[2]);
    EXPECT_EQ(groups.farthest(groups.groups()[0], {0, 0, 1}), points[1]);
}

TEST(PointGroups, separatesCellsAndInnerPoints) {
    const CubeGrid grid({0, 0, 0}, {1, 1, 1}, 1);
    const std::vector<FitPoint> points = {
        {.position = {0.2, 0.2, 0.2}, .normal = {0, 0, 1}, .cell = 3},
        {.position = {0.4, 0.2, 0.2}, .normal = {0, 1, 0}, .cell = 3},
        {.position = {0.4, 0.2, 0.2}, .normal = {0, 0, 1}, .cell = 5},
        {.position = {0.6, 0.2, 0.2}, .normal = {0, 0, -1}, .cell = 5},
        {.position = {0.8, 0.2, 0.2}, .cell = 5, .isInner = true}};
    const PointGroups groups(points, grid);
    ASSERT_EQ(groups.groups().size(), 3u);
    EXPECT_EQ(groups.groups()[0].cell, 3);
    // The mean of two normals at a right angle is long enough to be a direction.
    EXPECT_NEAR(groups.groups()[0].normal[1], std::sqrt(0.5), 1e-15);
    EXPECT_NEAR(groups.groups()[0].normal[2], std::sqrt(0.5), 1e-15);
    EXPECT_EQ(groups.groups()[1].cell, 5);
    EXPECT_EQ(groups.groups()[1].normal, (Point3{0, 0, 0}));  // they are opposite
    EXPECT_TRUE(groups.groups()[2].isInner);
    EXPECT_EQ(groups.groups()[2].bounds.min, (Point3{0.8, 0.2, 0.2}));
}

}  // namespace
}  // namespace espalier::cages
