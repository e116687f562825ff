// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/box_least_squares.h>
#include <espalier/embed/box_tree.h>
#include <espalier/embed/solve3.h>
#include <espalier/embed/space_curve.h>
#include <espalier/embed/trilinear.h>

#include "support/test.h"

#include "embed/simplex.h"

namespace espalier::embed {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Returns a unit cube with its corners moved by up to `amount` in each coordinate.
Trilinear::Corners shakenCube(double amount, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shake(-amount, amount);
    Trilinear::Corners corners = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(1, 1, 0),
                                  Vector3d(0, 1, 0), Vector3d(0, 0, 1), Vector3d(1, 0, 1),
                                  Vector3d(1, 1, 1), Vector3d(0, 1, 1)};
    for (Vector3d& corner : corners)
        for (Eigen::Index axis = 0; axis < 3; ++axis) corner[axis] += shake(random);
    return corners;
}

Trilinear seenFrom(Trilinear::Corners corners, const Vector3d& point) {
    for (Vector3d& corner : corners) corner -= point;
    return Trilinear(corners);
}

TEST(TrilinearMap, CornersAreAtTheirPlaces) {
    const auto corners = shakenCube(0.3, 1);
    const Trilinear map(corners);
    const Vector3d places[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                               {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(map.position(places[i]), corners[i]);
}

// MacCracken & Joy 1996, section 6, interpolate the Jacobians of the corners trilinearly. This is
// the exact derivative; the test compares it with a difference quotient.
TEST(TrilinearMap, JacobianIsTheDerivative) {
    const Trilinear map(shakenCube(0.3, 2));
    const Vector3d place(0.3, 0.8, 0.4);
    const double h = 1e-5;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const Vector3d step = h * Vector3d::Unit(axis);
        const Vector3d quotient =
            (map.position(place + step) - map.position(place - step)) / (2 * h);
        // The map is linear in each variable, so the central difference is exact up to rounding,
        // 1e-16 / h.
        EXPECT_LT((map.jacobian(place).col(axis) - quotient).norm(), 1e-10);
    }
}

TEST(TrilinearMap, FindsThePlaceOfAPosition) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (unsigned seed = 0; seed < 500; ++seed) {
        const auto corners = shakenCube(0.2, seed);
        const Vector3d place(uniform(random), uniform(random), uniform(random));
        const auto found = seenFrom(corners, Trilinear(corners).position(place)).findOrigin();
        ASSERT_TRUE(found);
        // The rounding of positions, 1e-16, times the condition number of a well-shaped cell.
        EXPECT_LT((*found - place).norm(), 1e-14);
    }
}

TEST(TrilinearMap, FlatCellIsNotSolved) {
    Trilinear::Corners corners = shakenCube(0, 0);
    for (Vector3d& corner : corners) corner[2] = 0;
    EXPECT_FALSE(seenFrom(corners, {0.3, 0.4, 0.5}).findOrigin());
    EXPECT_FALSE(seenFrom(corners, {0.3, 0.4, 0.5}).findOriginInside(1e-10));
}

// A cell twisted by 100 degrees over its height: Newton's method from the centre fails for some
// points, but the search does not.
TEST(TrilinearMap, SearchFindsPlacesInATwistedCell) {
    Trilinear::Corners corners = shakenCube(0, 0);
    const double angle = 100 * std::acos(-1.0) / 180;
    for (std::size_t i = 4; i < 8; ++i) {
        const Vector3d from = corners[i] - Vector3d(0.5, 0.5, 0);
        corners[i] = Vector3d(0.5 + std::cos(angle) * from[0] - std::sin(angle) * from[1],
                              0.5 + std::sin(angle) * from[0] + std::cos(angle) * from[1], 1);
    }
    for (int i = 0; i <= 10; ++i)
        for (int j = 0; j <= 10; ++j)
            for (int k = 0; k <= 10; ++k) {
                const Vector3d place(i / 10., j / 10., k / 10.);
                const Vector3d point = Trilinear(corners).position(place);
                const auto found = seenFrom(corners, point).findOriginInside(1e-10);
                ASSERT_TRUE(found) << place.transpose();
                EXPECT_LT((Trilinear(corners).position(*found) - point).norm(), 1e-12);
            }
}

// Cubes so strongly shaken that about one in ten folds. The search starts Newton's method at the
// centre of each part. If it starts at a part's far corner instead, it misses 58 of these points.
TEST(TrilinearMap, SearchFindsPlacesInFoldedCells) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (unsigned seed = 0; seed < 20000; ++seed) {
        const auto corners = shakenCube(0.6, seed);
        const Vector3d place(uniform(random), uniform(random), uniform(random));
        const Vector3d point = Trilinear(corners).position(place);
        const auto found = seenFrom(corners, point).findOriginInside(1e-10);
        ASSERT_TRUE(found) << seed;
        // The rounding of positions of size 2, times 8 terms, with a margin of 100.
        EXPECT_LT((Trilinear(corners).position(*found) - point).norm(), 1e-12);
    }
}

TEST(TrilinearMap, NearestPlaceOfACubeIsTheClampedPoint) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-2, 3);
    const auto corners = shakenCube(0, 0);
    for (int i = 0; i < 500; ++i) {
        const Vector3d point(uniform(random), uniform(random), uniform(random));
        const Vector3d expected = point.cwiseMax(0).cwiseMin(1);
        EXPECT_LT((seenFrom(corners, point).nearestToOrigin() - expected).norm(), 1e-12);
    }
}

TEST(TrilinearMap, NearestPlaceIsNotFartherThanAnySample) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> uniform(-1, 2);
    for (unsigned seed = 0; seed < 50; ++seed) {
        const auto corners = shakenCube(0.15, seed);
        const Vector3d point(uniform(random), uniform(random), uniform(random));
        const Trilinear map = seenFrom(corners, point);
        const double nearest = map.position(map.nearestToOrigin()).norm();
        for (int i = 0; i <= 8; ++i)
            for (int j = 0; j <= 8; ++j)
                for (int k = 0; k <= 8; ++k)
                    EXPECT_LE(nearest, map.position({i / 8., j / 8., k / 8.}).norm() + 1e-9);
    }
}

// The problem is convex: x is the nearest if and only if the distance does not decrease along a
// free axis, nor inwards along an axis at a bound. Tested for maps of any size and shear.
TEST(NearestInBox, MeetsTheConditionsOfAMinimum) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const Vector3d low(-1, 0, 2), high(1, 0.5, 2.25);
    std::array<int, 4> heldCount = {};
    for (const double size : {1e-150, 1e-9, 1.0, 1e150})
        for (const double shear : {0.0, 1.0, 50.0})
            for (int i = 0; i < 300; ++i) {
                Matrix3d map = Matrix3d::Identity();
                for (Eigen::Index row = 0; row < 3; ++row)
                    for (Eigen::Index column = row + 1; column < 3; ++column)
                        map(row, column) = shear * normal(random);
                const Vector3d middle = (low + high) / 2;
                const Vector3d x0 =
                    middle + Vector3d(normal(random), normal(random), normal(random));
                const Vector3d target = map * x0;
                const Vector3d x = nearestInBox(size * map, size * target, low, high);
                const Vector3d slope = map.transpose() * (map * x - target);
                int held = 0;
                for (Eigen::Index axis = 0; axis < 3; ++axis) {
                    ASSERT_GE(x[axis], low[axis]);
                    ASSERT_LE(x[axis], high[axis]);
                    // The rounding of a solve, relative to the terms that cancel.
                    const double zero = 1e-12 * map.col(axis).norm() * map.norm() * 10;
                    const bool mayFall = x[axis] > low[axis], mayRise = x[axis] < high[axis];
                    ASSERT_TRUE(!mayFall || slope[axis] < zero) << size << " " << shear;
                    ASSERT_TRUE(!mayRise || slope[axis] > -zero) << size << " " << shear;
                    held += x[axis] == low[axis] || x[axis] == high[axis];
                }
                ++heldCount[held];
            }
    for (const int count : heldCount) EXPECT_GT(count, 20);
}

TEST(NearestInBox, SingularMaps) {
    const Vector3d zeros = Vector3d::Zero(), ones = Vector3d::Ones();
    EXPECT_TRUE(nearestInBox(Matrix3d::Zero(), ones, zeros, ones).allFinite());
    Matrix3d flat = Matrix3d::Identity();
    flat(2, 2) = 0;
    EXPECT_LT((flat * nearestInBox(flat, {0.25, 3, 5}, zeros, ones) - Vector3d(0.25, 1, 0)).norm(),
              1e-15);
}

TEST(TrilinearMap, NearestPlaceDoesNotDependOnTheSizeOfTheCell) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform(-1, 2);
    for (unsigned seed = 0; seed < 50; ++seed) {
        auto corners = shakenCube(0.15, seed);
        const Vector3d point(uniform(random), uniform(random), uniform(random));
        const Vector3d expected = seenFrom(corners, point).nearestToOrigin();
        for (const double size : {1e-150, 1e-30, 1e-9, 1e30, 1e150}) {
            auto scaled = corners;
            for (Vector3d& corner : scaled) corner *= size;
            // The distance is at its minimum, so places this near give it to all digits.
            EXPECT_LT((seenFrom(scaled, size * point).nearestToOrigin() - expected).norm(), 1e-6)
                << size;
        }
    }
}

TEST(Solve3, AgreesWithAFactorisation) {
    std::mt19937 random(10);
    std::normal_distribution<double> normal;
    for (const double size : {1e-150, 1e-100, 1e-9, 1.0, 1e100, 1e150})
        for (const double height : {1.0, 0.1, 1e-3, 1e-6}) {
            for (int i = 0; i < 100; ++i) {
                Matrix3d map = Matrix3d::NullaryExpr([&] { return normal(random); });
                map.col(2) = map.col(0) - map.col(1) + height * map.col(2);
                const Vector3d x(normal(random), normal(random), normal(random));
                const Vector3d found = solve3(size * map, size * (map * x));
                // Rounding times the condition number of the map.
                const double condition = map.norm() * map.inverse().norm();
                ASSERT_LT((found - x).norm(), 1e-15 * condition * (1 + x.norm())) << size;
            }
        }
}

TEST(Solve3, SingularMapsGiveNonFiniteResults) {
    Matrix3d flat = Matrix3d::Identity();
    flat(2, 2) = 0;
    EXPECT_FALSE(solve3(flat, {1, 2, 3}).allFinite());
    EXPECT_FALSE(solve3(Matrix3d::Zero(), {1, 2, 3}).allFinite());
}

TEST(MortonCurve, ByHand) {
    const MortonCurve curve({Vector3d(0, 0, 0), Vector3d(8, 8, 8)});
    // The highest three bits tell which half along each axis; the next three tell which quarter.
    const auto eighth = [&](double x, double y, double z) {
        return curve.key({x, y, z}) >> (MortonCurve::kBits - 6);
    };
    EXPECT_EQ(eighth(1, 1, 1), 0b000'000u);
    EXPECT_EQ(eighth(5, 1, 1), 0b001'000u);
    EXPECT_EQ(eighth(1, 5, 1), 0b010'000u);
    EXPECT_EQ(eighth(1, 1, 5), 0b100'000u);
    EXPECT_EQ(eighth(7, 3, 5), 0b101'011u);
    // A point outside, and a NaN.
    EXPECT_EQ(eighth(9, -1, 1e300), 0b101'101u);
    EXPECT_EQ(eighth(kNan, 1, 1), 0u);
    EXPECT_EQ(curve.key({8, 8, 8}), (std::uint64_t{1} << MortonCurve::kBits) - 1);
    // A box that has no length along one axis.
    const MortonCurve flat({Vector3d(0, 0, 1), Vector3d(8, 8, 1)});
    EXPECT_EQ(flat.key({7, 7, 1}) >> (MortonCurve::kBits - 6), 0b011'011u);
}

TEST(MortonCurve, SortIsStable) {
    std::mt19937_64 random(11);
    for (const int bits : {11, 32, MortonCurve::kBits}) {
        Array<CurveItem> places;
        for (Index i = 0; i < 5000; ++i) places.push_back({random() >> (i % 2 == 0 ? 1 : 40), i});
        auto expected = places;
        const int low = MortonCurve::kBits - bits;
        std::stable_sort(
            expected.begin(), expected.end(),
            [&](const CurveItem& a, const CurveItem& b) { return a.key >> low < b.key >> low; });
        sortAlongCurve(places, bits);
        for (std::size_t i = 0; i < places.size(); ++i) ASSERT_EQ(places[i].item, expected[i].item);
    }
}

TEST(NearestOnTriangle, ByHand) {
    // In the plane z = 1: the foot of the perpendicular from the origin is inside, beyond an edge,
    // and beyond a corner.
    const auto nearest = [](Vector3d a, Vector3d b, Vector3d c) {
        return nearestToOrigin(Triangle{a, b, c});
    };
    EXPECT_LT((nearest({-1, -1, 1}, {2, -1, 1}, {-1, 2, 1}) - Vector3d(1, 1, 1) / 3).norm(), 1e-15);
    EXPECT_EQ(nearest({1, -1, 1}, {1, 1, 1}, {3, 0, 1}), Vector3d(0.5, 0.5, 0));
    EXPECT_EQ(nearest({1, 1, 1}, {2, 1, 1}, {1, 2, 1}), Vector3d(1, 0, 0));
    // Triangles without area: a segment, and a point.
    EXPECT_EQ(nearest({-1, 0, 1}, {3, 0, 1}, {1, 0, 1}), Vector3d(0.75, 0.25, 0));
    EXPECT_EQ(nearest({1, 0, 1}, {1, 0, 1}, {1, 0, 1}).sum(), 1);
}

void expectTreeMatchesBruteForce(const std::vector<BoxTree::Box>& boxes, std::mt19937& random) {
    const std::size_t count = boxes.size();
    std::uniform_real_distribution<double> at(0, 10);
    const BoxTree tree(boxes);
    for (int query = 0; query < 50; ++query) {
        const Vector3d point(at(random), at(random), at(random));
        std::vector<Index> found, expected;
        tree.findContaining(point, found);
        std::sort(found.begin(), found.end());
        for (std::size_t i = 0; i < count; ++i)
            if (boxes[i].contains(point)) expected.push_back(Index(i));
        ASSERT_EQ(found, expected);
        found.clear();
        expected.clear();
        tree.findWithin(point, 0.5, found);
        std::sort(found.begin(), found.end());
        for (std::size_t i = 0; i < count; ++i)
            if (boxes[i].exteriorDistance(point) <= 0.5) expected.push_back(Index(i));
        ASSERT_EQ(found, expected);
        if (count == 0) continue;
        const auto distance = [&](Index i) { return boxes[i].exteriorDistance(point); };
        Index best = 0;
        for (Index i = 1; i < Index(count); ++i)
            if (distance(i) < distance(best)) best = i;
        const auto nearest = tree.findNearest(point, distance);
        ASSERT_EQ(nearest.index, best);  // the lowest of several
        ASSERT_EQ(nearest.distance, distance(best));
    }
}

TEST(Boxes, SearchOfManyPointsMatchesBruteForce) {
    constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    std::mt19937 random(9);
    std::uniform_real_distribution<double> at(0, 10), size(0, 1), step(-0.05, 0.05);
    std::vector<BoxTree::Box> boxes;
    for (int i = 0; i < 3000; ++i) {
        const Vector3d low(at(random), at(random), at(random));
        boxes.emplace_back(low, low + Vector3d(size(random), size(random), size(random)));
    }
    // A hundred boxes contain one point, which is more than a search shares.
    for (int i = 0; i < 100; ++i)
        boxes.emplace_back(Vector3d::Constant(5 - 0.01 * i), Vector3d::Constant(5 + 0.01 * i));
    const BoxTree tree(boxes);

    // Points near the one before, far from it, equal to it, outside all boxes, and no points.
    std::vector<Point3> points(1000);
    Point3 last = {5, 5, 5};
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (double& x : last) x = i % 100 < 90 ? x + step(random) : at(random);
        points[i] = i % 50 == 49 ? points[i - 1] : last;
    }
    points[100] = {5, 5, 5};
    points[200] = {-100, 100, 5};
    points[300] = {kNoNumber, kNoNumber, kNoNumber};
    points[301] = {5, kNoNumber, 5};
    points[400] = {kInfinity, 5, 5};
    points[401] = {5, 5, -kInfinity};
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, points.size()}) {
        std::size_t next = 0;
        std::size_t largest = 0;
        tree.findContaining(std::span(points).first(count), [&](std::size_t i, auto found) {
            ASSERT_EQ(i, next++);  // each point once, in order
            std::vector<Index> expected;
            for (std::size_t b = 0; b < boxes.size(); ++b)
                if (boxes[b].contains(Vector3d(points[i].data()))) expected.push_back(Index(b));
            ASSERT_EQ(std::vector<Index>(found.begin(), found.end()), expected) << "point " << i;
            largest = std::max(largest, found.size());
        });
        EXPECT_EQ(next, count);
        if (count == points.size()) {
            EXPECT_GE(largest, 100u);
        }
    }
    BoxTree({}).findContaining(points, [](std::size_t, auto found) { EXPECT_TRUE(found.empty()); });
}

TEST(Boxes, TreeMatchesBruteForce) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> at(0, 10), size(0, 1);
    for (const std::size_t count : {0u, 1u, 8u, 9u, 1000u, 30000u}) {
        std::vector<BoxTree::Box> boxes;
        for (std::size_t i = 0; i < count; ++i) {
            const Vector3d low(at(random), at(random), at(random));
            boxes.emplace_back(low, low + Vector3d(size(random), size(random), size(random)));
        }
        expectTreeMatchesBruteForce(boxes, random);
    }
}

// Boxes that the curve cannot separate: all in the same place, and next to one that is far away.
TEST(Boxes, TreeOfCoincidentBoxes) {
    std::mt19937 random(12);
    std::vector<BoxTree::Box> boxes(100, {Vector3d(1, 1, 1), Vector3d(9, 9, 9)});
    expectTreeMatchesBruteForce(boxes, random);
    for (int i = 0; i < 100; ++i) {
        const Vector3d low = Vector3d::Constant(i / 10.);
        boxes.emplace_back(low, low + Vector3d::Ones());
    }
    boxes.emplace_back(Vector3d::Constant(1e9), Vector3d::Constant(2e9));
    expectTreeMatchesBruteForce(boxes, random);
}

// findNearest() computes a distance only for items whose boxes are nearer than the best distance so
// far. Eight boxes are one leaf of the tree, in the order of the line on which they stand.
TEST(BoxTree, NearestComputesNoDistanceThatABoxExcludes) {
    std::vector<BoxTree::Box> boxes;
    for (int i = 0; i < 8; ++i)
        boxes.emplace_back(Vector3d(10 * i, 0, 0), Vector3d(10 * i + 1, 1, 1));
    const BoxTree tree(boxes);
    const Vector3d point(0.5, 0.5, 0.5);
    std::vector<Index> asked;
    const auto nearest = tree.findNearest(point, [&](Index item) {
        asked.push_back(item);
        return boxes[static_cast<std::size_t>(item)].exteriorDistance(point);
    });
    EXPECT_EQ(nearest.index, 0);
    EXPECT_EQ(asked, std::vector<Index>{0});
}

}  // namespace
}  // namespace espalier::embed
