// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/tensor_product.h>

#include "support/rows.h"
#include "support/skew_boxes.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::embed {
namespace {

/// Returns the row of one point in a unit grid.
Row rowOfPoint(const Cells& cells, Basis basis, const Point3& point,
               OutsidePolicy outside = OutsidePolicy::Error) {
    const TensorLattice lattice(test::grid(cells), gridPositions(cells), basis);
    return rowOf(tableOf(lattice, {point}, {.outside = outside}), 0);
}

// Degree 1 is trilinear: the eight vertices of a cube have the weights (x or 1 − x) (y or 1 − y) (z
// or 1 − z).
TEST(TensorProduct, BezierLatticeOfOneCellIsTrilinear) {
    const double x = 0.25, y = 0.5, z = 0.875;
    expectRow(rowOfPoint({1, 1, 1}, Basis::Bezier, {x, y, z}), {{0, (1 - x) * (1 - y) * (1 - z)},
                                                                {1, x * (1 - y) * (1 - z)},
                                                                {2, (1 - x) * y * (1 - z)},
                                                                {3, x * y * (1 - z)},
                                                                {4, (1 - x) * (1 - y) * z},
                                                                {5, x * (1 - y) * z},
                                                                {6, (1 - x) * y * z},
                                                                {7, x * y * z}});
}

// Degree 2 in the middle of x gives (1/4, 1/2, 1/4), times 1/2 and 1/2 for y and z. At an end of y
// and z, these factors are 1 and 0: an outermost edge depends on its own vertices only.
TEST(TensorProduct, BezierRowsByHand) {
    std::map<Index, double> expected;
    for (Index v = 0; v < 12; ++v) expected[v] = v % 3 == 1 ? 1. / 8 : 1. / 16;
    expectRow(rowOfPoint({2, 1, 1}, Basis::Bezier, {1, 0.5, 0.5}), expected);
    expectRow(rowOfPoint({2, 1, 1}, Basis::Bezier, {1, 0, 0}), {{0, 0.25}, {1, 0.5}, {2, 0.25}});
}

// Bézier lattices interpolate their corners.
TEST(TensorProduct, BezierLatticesInterpolateTheirCorners) {
    const Cells n = {3, 2, 4};
    for (const Index i : {0, n[0]})
        for (const Index j : {0, n[1]})
            for (const Index k : {0, n[2]})
                expectRow(rowOfPoint(n, Basis::Bezier, {double(i), double(j), double(k)}),
                          {{gridVertex(n, i, j, k), 1}});
}

// At a knot, the weights of a cubic B-spline are 1/6, 4/6, 1/6.
TEST(TensorProduct, BSplineRowsByHand) {
    const Cells n = {4, 4, 4};
    const std::array<double, 3> knot = {1. / 6, 4. / 6, 1. / 6};
    std::map<Index, double> expected;
    for (Index i = 0; i < 3; ++i)
        for (Index j = 0; j < 3; ++j)
            for (Index k = 0; k < 3; ++k)
                expected[gridVertex(n, i + 1, j + 1, k)] = knot[i] * knot[j] * knot[k];
    expectRow(rowOfPoint(n, Basis::BSpline, {2, 2, 1}), expected);
}

// Rows are products of the rows of the axes, which have their own tests.
TEST(TensorProduct, RowsAreProductsOfTheAxes) {
    const Cells n = {3, 4, 5};
    for (const Basis basis : {Basis::Bezier, Basis::BSpline})
        for (const Point3& point : randomPoints(n, 1, 20, 3)) {
            std::map<Index, double> expected;
            const auto x = axisFunctions(basis, n[0], point[0]);
            const auto y = axisFunctions(basis, n[1], point[1]);
            const auto z = axisFunctions(basis, n[2], point[2]);
            for (std::size_t i = 0; i < x.values.size(); ++i)
                for (std::size_t j = 0; j < y.values.size(); ++j)
                    for (std::size_t k = 0; k < z.values.size(); ++k)
                        expected[gridVertex(n, x.first + Index(i), y.first + Index(j),
                                            z.first + Index(k))] =
                            x.values[i] * y.values[j] * z.values[k];
            expectRow(rowOfPoint(n, basis, point), expected);
        }
}

TEST(TensorProduct, RowsSumToOne) {
    const Cells n = {4, 3, 6};
    for (const Basis basis : {Basis::Bezier, Basis::BSpline}) {
        const TensorLattice lattice(test::grid(n), Skew()(gridPositions(n)), basis);
        // Includes points up to a cell outside along each axis. Their weights sum to at most 7 in
        // absolute value; points farther outside may have no row.
        const auto points = Skew()(randomPoints(n, -1, 300, 5));
        const auto table = tableOf(lattice, points, {.outside = OutsidePolicy::Nearest});
        expectRowsSumToOne(table);
        if (basis == Basis::Bezier) continue;
        for (Index row = 0; row < table.rowCount(); ++row)
            EXPECT_LE(table.columns(row).size(), 64u);
    }
}

// Both bases have linear precision, and so has the tangent outside: at rest, every point stays.
TEST(TensorProduct, RestPoseReproducesEveryPoint) {
    for (const Cells& n : {Cells{3, 3, 3}, {4, 3, 7}, {12, 3, 3}})
        for (const Basis basis : {Basis::Bezier, Basis::BSpline}) {
            const auto rest = Skew()(gridPositions(n));
            const TensorLattice lattice(test::grid(n), rest, basis);
            const auto points = Skew()(randomPoints(n, -1, 500, 7));
            const auto embedding =
                embedPoints(lattice, points, {.outside = OutsidePolicy::Nearest});
            EXPECT_GT(embedding.count(PointStatus::Inside), 0);
            EXPECT_GT(embedding.count(PointStatus::Outside), 0);
            const auto table = buildDeformationTable(lattice, embedding);
            const double off = largestDistance(times(table, rest), asMatrix(points));
            // The project promises 1e-12 of the size of the lattice, which is at least 4.
            EXPECT_LT(off, 4e-12);
            EXPECT_NEAR(embedding.largestResidual(), off, 1e-13);
        }
}

// Bézier coefficients reproduce a polynomial of the lattice's degrees in x, y and z. For xᵃ, with x
// from 0 to 1 and degree n, they are C(i, a) / C(n, a).
TEST(TensorProduct, BezierLatticesHaveThePrecisionOfTheirDegrees) {
    const Cells n = {3, 2, 4};
    const auto choose = [](Index from, Index count) {
        double value = 1;
        for (Index k = 0; k < count; ++k) value *= double(from - k) / (k + 1);
        return value;
    };
    const auto factors = randomValues(4 * 3 * 5, 8);
    const auto points = randomPoints(n, 0, 100, 9);
    const TensorLattice lattice(test::grid(n), gridPositions(n), Basis::Bezier);
    std::vector<Point3> pose(4 * 3 * 5, Point3{});
    std::vector<double> expected(points.size(), 0);
    std::size_t next = 0;
    for (Index a = 0; a <= n[0]; ++a)
        for (Index b = 0; b <= n[1]; ++b)
            for (Index c = 0; c <= n[2]; ++c) {
                const double factor = factors[next++];
                for (Index k = 0; k <= n[2]; ++k)
                    for (Index j = 0; j <= n[1]; ++j)
                        for (Index i = 0; i <= n[0]; ++i)
                            pose[gridVertex(n, i, j, k)][0] +=
                                factor * choose(i, a) / choose(n[0], a) * choose(j, b) /
                                choose(n[1], b) * choose(k, c) / choose(n[2], c);
                for (std::size_t p = 0; p < points.size(); ++p)
                    expected[p] += factor * std::pow(points[p][0] / n[0], a) *
                                   std::pow(points[p][1] / n[1], b) *
                                   std::pow(points[p][2] / n[2], c);
            }
    const Positions got = times(tableOf(lattice, points), pose);
    for (std::size_t p = 0; p < points.size(); ++p)
        // Sums of sixty terms of at most 1.
        EXPECT_NEAR(got(Eigen::Index(p), 0), expected[p], 1e-14);
}

// B-spline coefficients reproduce a product of cubics. They are polar forms at (x − 1, x, x + 1),
// which for 1, x, x² and x³ are 1, x, x² − 1/3 and x³ − x.
TEST(TensorProduct, BSplineLatticesHaveCubicPrecision) {
    const Cells n = {4, 3, 5};
    const std::array<std::array<double, 4>, 3> cubics = {
        {{0.3, -1.1, 0.7, 0.4}, {1.2, 0.5, -0.6, 0.2}, {-0.8, 0.9, 0.3, -0.1}}};
    const auto product = [&](const Point3& at, bool isCoefficient) {
        double value = 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto& [a, b, c, d] = cubics[axis];
            const double x = at[axis];
            value *= isCoefficient ? a + b * x + c * (x * x - 1. / 3) + d * (x * x * x - x)
                                   : a + x * (b + x * (c + x * d));
        }
        return value;
    };
    const auto rest = gridPositions(n);
    std::vector<Point3> pose;
    for (const Point3& at : rest) pose.push_back({product(at, true), 0, 0});
    const auto points = randomPoints(n, 1, 200, 10);
    const TensorLattice lattice(test::grid(n), rest, Basis::BSpline);
    const Positions got = times(tableOf(lattice, points), pose);
    for (std::size_t p = 0; p < points.size(); ++p)
        // 64 products of numbers that reach about 2000 at the far corner.
        EXPECT_NEAR(got(Eigen::Index(p), 0), product(points[p], false), 1e-11);
}

// The numbering of vertices and cells does not matter: columns are renumbered with the vertices.
TEST(TensorProduct, RelabellingRenamesTheColumns) {
    const Cells n = {3, 5, 4};
    const auto rest = Skew()(gridPositions(n));
    const auto pose = shaken(rest, 11);
    const auto points = Skew()(randomPoints(n, -1, 300, 12));
    const auto names = shuffledIndices(Index(rest.size()), 13);
    auto restThere = rest, poseThere = pose;
    for (std::size_t v = 0; v < names.size(); ++v) {
        restThere[names[v]] = rest[v];
        poseThere[names[v]] = pose[v];
    }
    const CellComplex there = relabelled(test::grid(n), names, 14);
    for (const Basis basis : {Basis::Bezier, Basis::BSpline}) {
        const EmbeddingOptions options = {.outside = OutsidePolicy::Nearest};
        const auto here = tableOf(TensorLattice(test::grid(n), rest, basis), points, options);
        const auto other = tableOf(TensorLattice(there, restThere, basis), points, options);
        // The fit sums in a different order. The map of the pose is a few times steeper than the
        // rest map, outside too.
        EXPECT_LT(largestDistance(times(here, pose), times(other, poseThere)), 1e-12);
    }
}

// The row continues along the tangent. Degree 2 at the end of x has the values (0, 0, 1) and the
// derivatives (0, −1, 1) by the coordinate, so half a cell outside they are (0, −1/2, 3/2); y and z
// are 0.
TEST(TensorProduct, PointsOutsideFollowTheTangent) {
    expectRow(rowOfPoint({2, 1, 1}, Basis::Bezier, {2.5, 0, 0}, OutsidePolicy::Nearest),
              {{1, -0.5}, {2, 1.5}});
    // 1/2 outside along x, where (0, 1) has the derivatives (−1, 1), and 1 outside along y
    // likewise: the tangent has no product of the two.
    expectRow(rowOfPoint({1, 1, 1}, Basis::Bezier, {1.5, -1, 0}, OutsidePolicy::Nearest),
              {{0, -0.5}, {1, 1 + 0.5 + 1}, {3, -1}});
}

}  // namespace
}  // namespace espalier::embed
