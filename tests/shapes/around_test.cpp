// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/far/topology_match.h>
#include <espalier/shapes/around.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/transform.h>

#include <algorithm>
#include <cmath>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

double distance(const Point3& a, const Point3& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Points that fill the box from (0, 0, 0) to (4, 2, 1), with its corners. Its diagonal is √21.
std::vector<Point3> slab() {
    std::vector<Point3> points;
    for (int i = 0; i <= 8; ++i)
        for (int j = 0; j <= 4; ++j)
            for (int k = 0; k <= 2; ++k) points.push_back({i / 2.0, j / 2.0, k / 2.0});
    return points;
}

TEST(Around, IsTheBoxOfThePointsWithAMargin) {
    const Lattice lattice = around(slab());
    const double margin = 0.05 * std::sqrt(21);
    const Lattice expected =
        box({{4, 2, 1}, {-margin, -margin, -margin}, {4 + margin, 2 + margin, 1 + margin}});
    // The sides are 4.46, 2.46 and 1.46 long: the ratios to a quarter of the longest are 2.2
    // and 1.3.
    EXPECT_EQ(far::topologyHash(lattice.complex), far::topologyHash(expected.complex));
    for (std::size_t i = 0; i < expected.positions.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(lattice.positions[i][axis], expected.positions[i][axis], kRounding);
}

TEST(Around, TakesNumbersOfCells) {
    const auto cellsOf = [](const AroundOptions& options) {
        return around(slab(), options).complex.count(3);
    };
    EXPECT_EQ(cellsOf({.cells = {2, 3, 5}}), 30);
    EXPECT_EQ(cellsOf({.cells = {2, 3, 5}, .cellSize = 0.1, .cellsAlongLongest = 9}), 30);
    EXPECT_EQ(cellsOf({.cellsAlongLongest = 1}), 1);
    EXPECT_EQ(cellsOf({.cellsAlongLongest = 8, .margin = 0}), 8 * 4 * 2);
    EXPECT_EQ(cellsOf({.cellSize = 0.5, .margin = 0}), 8 * 4 * 2);
    // Edges of at most 0.6: 4 / 7, 2 / 4 and 1 / 2.
    EXPECT_EQ(cellsOf({.cellSize = 0.6, .cellsAlongLongest = 1, .margin = 0}), 7 * 4 * 2);
    // Not 21 cells because of the rounding of 4 / 0.2.
    EXPECT_EQ(cellsOf({.cellSize = 0.2, .margin = 0}), 20 * 10 * 5);
    EXPECT_EQ(cellsOf({.cellSize = 100}), 1);
}

TEST(Around, GivesPointsInAPlaneABoxWithVolume) {
    const std::vector<Point3> square = {{0, 0, 5}, {1, 0, 5}, {1, 1, 5}, {0, 1, 5}};
    for (const bool oriented : {false, true}) {
        const Lattice lattice = around(square, {.margin = 0.1, .oriented = oriented});
        expectValid(lattice);
        EXPECT_NEAR(lattice.positions.front()[2], 5 - 0.1 * std::sqrt(2), kRounding);
        EXPECT_NEAR(lattice.positions.back()[2], 5 + 0.1 * std::sqrt(2), kRounding);
    }
}

TEST(Around, OrientedTurnsWithThePoints) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const auto numbers = randomValues(7, seed);
        const Affine map = translation({numbers[4], numbers[5], numbers[6]}) *
                           rotation({numbers[0], numbers[1], numbers[2]}, 3 * numbers[3]);
        std::vector<Point3> points = slab();
        for (Point3& point : points) point = map(point);
        const Lattice lattice = around(points, {.margin = 0, .oriented = true});
        expectValid(lattice);
        // The cells are cubes of edge 1, whichever axis is called x.
        EXPECT_EQ(lattice.complex.count(3), 8);
        EXPECT_NEAR(distance(at(lattice, 0), at(lattice, 1)), 1, 1e-9);
        // One corner of the box is where the map takes (0, 0, 0).
        double nearest = kInfinity;
        for (const Point3& position : lattice.positions)
            nearest = std::min(nearest, distance(position, map({0, 0, 0})));
        EXPECT_LT(nearest, 1e-9);
    }
}

TEST(Around, OrientedLeavesAxesThatAreBestAsTheyAre) {
    EXPECT_TRUE(around(slab(), {.oriented = true}).positions == around(slab()).positions);
}

TEST(Around, RefusesOptionsOutOfRange) {
    const auto points = slab();
    EXPECT_REFUSED(Error, "cells[1]", around(points, {.cells = {2, 0, 2}}));
    EXPECT_REFUSED(Error, "cells[0]", around(points, {.cells = {-1, 1, 1}}));
    EXPECT_REFUSED(Error, "cellSize", around(points, {.cellSize = -1}));
    EXPECT_REFUSED(Error, "cellSize", around(points, {.cellSize = kNan}));
    EXPECT_REFUSED(Error, "cellSize", around(points, {.cellSize = 1e-300}));
    EXPECT_REFUSED(Error, "cellsAlongLongest", around(points, {.cellsAlongLongest = 0}));
    EXPECT_REFUSED(Error, "margin", around(points, {.margin = -0.1}));
    EXPECT_REFUSED(Error, "margin", around(points, {.margin = kInfinity}));
    EXPECT_REFUSED(Error, "margin", around(points, {.margin = 1e308}));
    EXPECT_REFUSED(far::TopologyError, "", around(points, {.cells = {100000, 100000, 100000}}));
}

TEST(Around, RefusesPointsWithoutABox) {
    const std::vector<Point3> same(3, {1, 2, 3}), square = {{0, 0, 5}, {1, 0, 5}, {1, 1, 5}};
    EXPECT_REFUSED(Error, "there are no points", around({}));
    EXPECT_REFUSED(Error, "all points are at", around(same));
    EXPECT_REFUSED(Error, "lie in a plane", around(square, {.margin = 0}));
    EXPECT_REFUSED(Error, "points[1]", around(std::vector<Point3>{{0, 0, 0}, {0, kNan, 0}}));
    EXPECT_REFUSED(Error, "infinite", around(std::vector<Point3>{{-1e308, 0, 0}, {1e308, 0, 0}}));
}

/// Returns the different coordinates of a lattice along an axis, ascending.
std::vector<double> coordinates(const Lattice& lattice, std::size_t axis) {
    std::vector<double> values;
    for (const Point3& position : lattice.positions) values.push_back(position[axis]);
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
    return values;
}

TEST(Around, PutsASideIntoThePlaneOfSymmetry) {
    const double margin = 0.05 * std::sqrt(21);
    const Lattice half = around(slab(), {.cells = {3, 3, 3}, .symmetry = SymmetryPlane{1, {}}});
    const auto y = coordinates(half, 1);
    ASSERT_EQ(y.size(), 4u);
    EXPECT_EQ(y.front(), 0);
    EXPECT_NEAR(y.back(), 2 + margin, kRounding);
    EXPECT_LT(coordinates(half, 0).front(), 0);
    // The points are below the plane z = 1.
    const Lattice below = around(slab(), {.cells = {3, 3, 3}, .symmetry = SymmetryPlane{2, 1.0}});
    EXPECT_EQ(coordinates(below, 2).back(), 1);
    EXPECT_NEAR(coordinates(below, 2).front(), -margin, kRounding);
}

TEST(Around, IsSymmetricAboutAPlaneInTheMiddle) {
    // From −1.1 to 0.9 in y, in three cells, which become four.
    std::vector<Point3> points = slab();
    for (Point3& point : points) point[1] -= 1.1;
    const auto y =
        coordinates(around(points, {.cells = {2, 3, 2}, .symmetry = SymmetryPlane{1, {}}}), 1);
    ASSERT_EQ(y.size(), 5u);
    EXPECT_EQ(y[2], 0);
    EXPECT_EQ(y[1], -y[3]);
    EXPECT_EQ(y[0], -y[4]);
    EXPECT_NEAR(y[4], 1.1 + 0.05 * std::sqrt(21), kRounding);
}

TEST(Around, RefusesPlanesThatThePointsDoNotReach) {
    EXPECT_REFUSED(ArgumentError, "a plane that the model reaches to, from y = 0 to 2",
                   around(slab(), {.symmetry = SymmetryPlane{1, 3.0}}));
    EXPECT_REFUSED(ArgumentError, "axis 0, 1 or 2",
                   around(slab(), {.symmetry = SymmetryPlane{3, {}}}));
    EXPECT_REFUSED(ArgumentError, "a box along the axes",
                   around(slab(), {.oriented = true, .symmetry = SymmetryPlane{1, {}}}));
}

}  // namespace
}  // namespace espalier::shapes
