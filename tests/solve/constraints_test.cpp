// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/shapes/inventory.h>
#include <espalier/solve/constraints.h>
#include <espalier/solve/design_variables.h>

#include <cmath>
#include <functional>

#include "support/test.h"

namespace espalier::solve {
namespace {

using testing::ElementsAre;
using Triangle = std::array<Index, 3>;
using Points = std::vector<Point3>;

/// A tetrahedron with the corner of a cube, whose triangles run anticlockwise seen from outside.
const Points kCorner = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
const std::vector<Triangle> kCornerFaces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

/// Returns points that are in no special position.
Points cloud(std::size_t count, unsigned seed) {
    const auto numbers = randomValues(3 * count, seed);
    Points points(count);
    for (std::size_t i = 0; i < count; ++i)
        points[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    return points;
}

/// Checks the derivatives of measures against differences of fourth order. With steps of 1e-3 their
/// error is 1e-12 times a fifth derivative, and the rounding of values near 1 is 1e-13.
void expectDerivatives(const std::function<Measures(const Points&)>& measure, const Points& points,
                       double bound = 1e-9) {
    const Measures measures = measure(points);
    ASSERT_EQ(measures.derivatives.rowCount(), std::ssize(measures.values));
    ASSERT_EQ(measures.derivatives.columnCount(), 3 * std::ssize(points));
    constexpr double h = 1e-3;
    for (Index column = 0; column < 3 * std::ssize(points); ++column) {
        const auto at = [&](double step) {
            Points moved = points;
            moved[column / 3][column % 3] += step;
            return measure(moved).values;
        };
        const auto a = at(-2 * h), b = at(-h), c = at(h), d = at(2 * h);
        for (Index row = 0; row < measures.derivatives.rowCount(); ++row) {
            double derivative = 0;
            const auto columns = measures.derivatives.columns(row);
            for (std::size_t k = 0; k < columns.size(); ++k)
                if (columns[k] == column) derivative = measures.derivatives.weights(row)[k];
            EXPECT_NEAR(derivative, (a[row] - 8 * b[row] + 8 * c[row] - d[row]) / (12 * h), bound)
                << "measure " << row << ", coordinate " << column;
        }
    }
}

TEST(Constraints, Distances) {
    const std::vector<std::array<Index, 2>> pairs = {{1, 2}, {3, 0}};
    EXPECT_THAT(measureDistances(kCorner, pairs).values, ElementsAre(std::sqrt(5.0), 3));
    expectDerivatives([&](const Points& points) { return measureDistances(points, pairs); },
                      cloud(4, 1));
    const auto at = [](Index a, Index b) {
        const std::vector<std::array<Index, 2>> wrong = {{0, 1}, {a, b}};
        measureDistances(kCorner, wrong);
    };
    EXPECT_MESSAGE("pair 1: there is no point 4; there are 4, numbered from 0", at(0, 4));
    EXPECT_MESSAGE(
        "pair 1: points 2 and 2 are at the same place, where their distance has no derivative",
        at(2, 2));
}

/// A box of 2 × 2 × 2 from (−1, −1, −1), whose vertex i has its coordinates in the bits of i.
Points box() {
    Points points;
    for (int i = 0; i < 8; ++i)
        points.push_back({2.0 * (i & 1) - 1, 1.0 * (i & 2) - 1, 0.5 * (i & 4) - 1});
    return points;
}
const std::vector<Triangle> kBoxFaces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                         {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                         {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};

TEST(Constraints, ThicknessesFollowTheSurface) {
    // Lines along z, along (1, 0, 1) from the middle, and along y through a corner of triangles.
    const std::vector<Line> lines = {
        {{0.5, 0.25, 0.3}, {0, 0, 10}}, {{0, 0, 0}, {1, 0, 0.5}}, {{1, 0, 1}, {0, -1e-3, 0}}};
    const auto crossings = findCrossings(box(), kBoxFaces, lines);
    ASSERT_EQ(crossings.rowCount(), 6);
    const auto thickness = measureThicknesses(box(), crossings);
    EXPECT_NEAR(thickness.values[0], 2, 1e-15);
    EXPECT_NEAR(thickness.values[1], std::sqrt(5.0), 1e-15);
    EXPECT_NEAR(thickness.values[2], 2, 1e-15);
    for (Index row = 0; row < 6; ++row) {
        Point3 place = {0, 0, 0};
        double total = 0;
        for (std::size_t k = 0; k < crossings.columns(row).size(); ++k)
            for (std::size_t c = 0; c < 3; ++c) {
                place[c] += crossings.weights(row)[k] * box()[crossings.columns(row)[k]][c];
                total += crossings.weights(row)[k] / 3;
            }
        EXPECT_NEAR(total, 1, 1e-15);
        const Line& line = lines[row / 2];
        // Even rows are ahead, odd rows behind.
        double along = 0;
        for (std::size_t c = 0; c < 3; ++c) along += (place[c] - line.point[c]) * line.direction[c];
        EXPECT_TRUE(row % 2 == 0 ? along > 0 : along < 0);
    }
    // Twice as high, the places follow.
    Points high = box();
    for (Point3& point : high) point[2] *= 2;
    EXPECT_NEAR(measureThicknesses(high, crossings).values[0], 4, 1e-15);
    Points bent = box();
    const Points shift = cloud(8, 2);
    for (std::size_t i = 0; i < 8; ++i)
        for (std::size_t c = 0; c < 3; ++c) bent[i][c] += 0.2 * shift[i][c];
    expectDerivatives([&](const Points& points) { return measureThicknesses(points, crossings); },
                      bent);
}

TEST(Constraints, LinesThatDoNotCrossAreNamed) {
    const auto with = [](const Point3& point, const Point3& direction) {
        const std::vector<Line> lines = {{{0, 0, 0}, {0, 0, 1}}, {point, direction}};
        return findCrossings(box(), kBoxFaces, lines);
    };
    EXPECT_REFUSED(Error, "line 1 does not meet the surface in its direction; give a point between",
                   with({0, 0, 1.5}, {0, 0, 1}));
    EXPECT_REFUSED(Error, "line 1 does not meet the surface in the opposite direction",
                   with({0, 0, -1.5}, {0, 0, 1}));
    EXPECT_REFUSED(Error, "line 1: its point is on the surface", with({0.1, 0, 1}, {0, 0, 1}));
    EXPECT_REFUSED(Error, "lines[1].direction", with({0, 0, 0}, {0, 0, 0}));
    EXPECT_REFUSED(Error, "line 1 is not finite", with({NAN, 0, 0}, {0, 0, 1}));
    const auto crossings = with({0, 0, 0}, {1, 0, 0});
    EXPECT_REFUSED(Error, "expected two rows for each line, and 4 columns",
                   measureThicknesses(kCorner, crossings));
    EXPECT_REFUSED(Error, "line 0: the two sides are at the same place",
                   measureThicknesses(Points(8, Point3{1, 2, 3}), crossings));
}

TEST(Constraints, VolumeOfAClosedSurface) {
    EXPECT_THAT(measureVolume(kCorner, kCornerFaces).values, ElementsAre(1));
    EXPECT_NEAR(measureVolume(box(), kBoxFaces).values[0], 8, 1e-14);
    Points far = box();
    for (Point3& point : far) point[0] += 1e6;
    EXPECT_NEAR(measureVolume(far, kBoxFaces).values[0], 8, 1e-14);
    expectDerivatives([&](const Points& points) { return measureVolume(points, kBoxFaces); },
                      cloud(8, 3));
    EXPECT_MESSAGE(
        "the surface is not closed: the triangles at the edge from point 1 to point 2 are not "
        "pairs that run along it in opposite directions",
        measureVolume(kCorner, std::span(kCornerFaces).first(3)));
    auto turned = kCornerFaces;
    std::swap(turned[3][0], turned[3][1]);
    EXPECT_REFUSED(Error, "the surface is not closed", measureVolume(kCorner, turned));
    EXPECT_REFUSED(Error, "triangle 0: there is no point 2",
                   measureVolume(std::span(kCorner).first(2), kCornerFaces));
}

TEST(Constraints, Area) {
    // Three right triangles, and the one whose legs are the edges from (1, 0, 0).
    const double slanted = std::sqrt(36.0 + 9 + 4) / 2;
    EXPECT_NEAR(measureArea(kCorner, kCornerFaces).values[0], 1 + 1.5 + 3 + slanted, 1e-15);
    expectDerivatives([&](const Points& points) { return measureArea(points, kBoxFaces); },
                      cloud(8, 4));
    const std::vector<Triangle> flat = {{0, 1, 1}};
    const Measures none = measureArea(kCorner, flat);
    EXPECT_THAT(none.values, ElementsAre(0));
    EXPECT_EQ(none.derivatives.entryCount(), 0);
}

TEST(Constraints, CurvaturesOfALine) {
    Points circle;
    std::vector<Index> line;
    for (int i = 0; i < 5; ++i) {
        circle.push_back({3 + 2 * std::cos(0.3 * i * i), 2 * std::sin(0.3 * i * i), 1});
        line.push_back(i);
    }
    for (const double curvature : measureCurvatures(circle, line).values)
        EXPECT_NEAR(curvature, 0.5, 1e-14);
    // Neighbours that are one apart: the fifth derivatives are some thousands.
    expectDerivatives([&](const Points& points) { return measureCurvatures(points, line); },
                      {{0, 0, 0}, {1, 0.3, 0}, {2, 0, 0.4}, {3, 0.2, 1}, {3.5, 1, 1}});
    const Measures straight =
        measureCurvatures(Points{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}}, std::vector<Index>{0, 1, 2});
    EXPECT_THAT(straight.values, ElementsAre(0));
    EXPECT_EQ(straight.derivatives.entryCount(), 0);
    EXPECT_REFUSED(Error, "the line has 2 points; expected three or more",
                   measureCurvatures(circle, std::vector<Index>{0, 1}));
    EXPECT_REFUSED(Error, "points 1 and 1 of the line are at the same place",
                   measureCurvatures(circle, std::vector<Index>{0, 1, 1}));
    EXPECT_REFUSED(Error, "points 0 and 0 of the line are at the same place",
                   measureCurvatures(circle, std::vector<Index>{0, 1, 0}));
    EXPECT_REFUSED(Error, "there is no point -1",
                   measureCurvatures(circle, std::vector<Index>{-1}));
}

TEST(Constraints, PlanarityIsTheMeanSquaredDistance) {
    const std::vector<Index> all = {0, 1, 2, 3, 4};
    // Four corners of a square at ±h: the best plane is z = 0.
    const double h = 0.1;
    const Points saddle = {{1, 1, h}, {-1, 1, -h}, {-1, -1, h}, {1, -1, -h}, {0, 0, 0}};
    EXPECT_NEAR(measurePlanarity(saddle, all).values[0], 4 * h * h / 5, 1e-15);
    Points flat = saddle;
    for (Point3& point : flat) point = {point[0], point[1], 2 * point[0] - point[1] + 7};
    EXPECT_NEAR(measurePlanarity(flat, all).values[0], 0, 1e-30);
    expectDerivatives([&](const Points& points) { return measurePlanarity(points, all); },
                      {{1, 1, 0.2}, {-1, 2, -0.1}, {-1, -1, 0.3}, {1.5, -1, -0.4}, {0.2, 0, 0}});
    EXPECT_REFUSED(Error, "there are 2 points; expected three or more",
                   measurePlanarity(saddle, std::vector<Index>{0, 1}));
    EXPECT_REFUSED(Error, "the position of point 1 is not finite",
                   measurePlanarity(Points{{0, 0, 0}, {0, INFINITY, 0}}, all));
}

// The derivatives by the vertices and by the variables, against measures of deformed points.
TEST(Constraints, DerivativesReachTheLattice) {
    const Lattice lattice =
        shapes::box({.cells = {2, 2, 2}, .min = {-2, -2, -2}, .max = {2, 2, 2}});
    const far::TopologyRefiner refiner(lattice.complex);
    const auto deformation =
        embed::bindPoints({refiner, lattice.positions}, box(), {.level = 2}).table;
    const auto measured = [&](const Points& vertices) {
        Points points(8, Point3{0, 0, 0});
        for (Index i = 0; i < 8; ++i)
            for (std::size_t k = 0; k < deformation.columns(i).size(); ++k)
                for (std::size_t c = 0; c < 3; ++c)
                    points[i][c] +=
                        deformation.weights(i)[k] * vertices[deformation.columns(i)[k]][c];
        return measureVolume(points, kBoxFaces);
    };
    Points posed = lattice.positions;
    const Points shift = cloud(posed.size(), 5);
    for (std::size_t v = 0; v < posed.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) posed[v][c] += 0.3 * shift[v][c];
    expectDerivatives(
        [&](const Points& vertices) {
            Measures measures = measured(vertices);
            measures.derivatives = byVertices(measures.derivatives, deformation);
            return measures;
        },
        posed);
    // One variable for each coordinate: the same derivatives.
    const auto jacobian =
        buildJacobian(deformation, DesignVariables(deformation.columnCount()).matrix());
    const auto points = measured(posed).derivatives;
    const auto vertices = byVertices(points, deformation),
               variables = byVariables(points, jacobian);
    ASSERT_EQ(vertices.entryCount(), variables.entryCount());
    for (Offset k = 0; k < vertices.entryCount(); ++k) {
        EXPECT_EQ(vertices.columns()[k], variables.columns()[k]);
        EXPECT_NEAR(vertices.weights()[k], variables.weights()[k], 1e-14);
    }
    EXPECT_REFUSED(Error, "expected three for each of 8 points", byVertices(vertices, deformation));
    EXPECT_REFUSED(Error, "expected 24, one for each row of the Jacobian",
                   byVariables(vertices, jacobian));
}

TEST(Constraints, MeasuresThatAreNotFiniteAreRefused) {
    std::vector<Point3> points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}};
    const std::vector<Index> line = {0, 1, 2}, all = {0, 1, 2, 3};
    for (Point3& point : points) point = scaled(point, 1e-170);
    EXPECT_REFUSED(Error, "measure 0 is not finite", measureCurvatures(points, line));
    for (Point3& point : points) point = scaled(scaled(point, 1e170), 1e200);
    EXPECT_REFUSED(Error, "measure 0 is not finite", measurePlanarity(points, all));
}

}  // namespace
}  // namespace espalier::solve
