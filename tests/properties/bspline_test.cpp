// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/composition.h>

#include "support/refined_lattice.h"
#include "support/rows.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::stencils {
namespace {

using GridPoint = std::array<Index, 3>;

/// Returns a row of the univariate cubic B-spline refined once, over the points 0 to n of a
/// polygon, for point h = 0 to 2n of the refined polygon (h/2 in old units). Odd h are edge points,
/// even h vertex points: the rows (4 4 0 0)/8 and (1 6 1 0)/8 of the splitting matrix (Joy, bicubic
/// refinement, "H₁"). The ends interpolate.
Row splitRow(Index n, Index h) {
    if (h % 2 == 1) return {{{(h - 1) / 2, 0.5}, {(h + 1) / 2, 0.5}}};
    if (h == 0 || h == 2 * n) return test::point(h / 2);
    return {{{h / 2 - 1, 0.125}, {h / 2, 0.75}, {h / 2 + 1, 0.125}}};
}

/// A refined grid: its number of cells along each axis, and the grid point of each vertex.
struct RefinedGrid {
    std::array<Index, 3> cells;
    std::vector<GridPoint> points;
};

RefinedGrid baseGrid(const std::array<Index, 3>& n) {
    RefinedGrid grid{n, {}};
    for (Index k = 0; k <= n[2]; ++k)
        for (Index j = 0; j <= n[1]; ++j)
            for (Index i = 0; i <= n[0]; ++i) grid.points.push_back({i, j, k});
    return grid;
}

/// Returns the position of a child vertex in half units of the parent: twice the middle of its
/// parent entity.
GridPoint halfPoint(const TopologyRefiner& refiner, const RefinedGrid& parent, int level,
                    Index vertex) {
    const Entity entity = refiner.refinement(level).parentOf({0, vertex}).upper;
    const auto vertices =
        refiner.level(level - 1).complex.relation(entity.dimension, 0)[entity.index];
    GridPoint half = {};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Index low = parent.cells[axis], high = 0;
        for (const Index v : vertices) {
            const Index at = parent.points[v][axis];
            low = std::min(low, at);
            high = std::max(high, at);
        }
        half[axis] = low + high;
    }
    return half;
}

/// Compares R_1 … R_level of a box with the tensor products of the univariate rows.
void expectTensorProduct(const std::array<Index, 3>& n, Boundary boundary, int levels,
                         Rules rules) {
    TopologyRefiner refiner =
        test::refined(test::grid(n), levels, {.rules = rules, .boundary = boundary});
    // Without boundary control, the outermost points of the refined grid, h = 0 and 2n, do not
    // exist.
    const Index margin = boundary == Boundary::Open ? 1 : 0;
    RefinedGrid grid = baseGrid(n);
    for (int level = 1; level <= levels; ++level) {
        const auto table = buildLevelTable(refiner, level);
        std::map<GridPoint, Index> parentVertex;
        for (std::size_t v = 0; v < grid.points.size(); ++v)
            parentVertex[grid.points[v]] = Index(v);
        RefinedGrid next;
        for (std::size_t axis = 0; axis < 3; ++axis)
            next.cells[axis] = 2 * (grid.cells[axis] - margin);
        for (Index vertex = 0; vertex < table.rowCount(); ++vertex) {
            const GridPoint half = halfPoint(refiner, grid, level, vertex);
            Row expected;
            for (const auto& [i, a] : splitRow(grid.cells[0], half[0]).weights)
                for (const auto& [j, b] : splitRow(grid.cells[1], half[1]).weights)
                    for (const auto& [k, c] : splitRow(grid.cells[2], half[2]).weights)
                        expected.weights[parentVertex.at({i, j, k})] = a * b * c;
            const Row got = rowOf(table, vertex);
            ASSERT_EQ(got.weights.size(), expected.weights.size())
                << "level " << level << " vertex " << vertex;
            // The accuracy that the project promises.
            ASSERT_LE(difference(got, expected), 1e-13) << "level " << level;
            next.points.push_back({half[0] - margin, half[1] - margin, half[2] - margin});
        }
        grid = next;
    }
}

// CSE-96-1 section 5: without boundary control, an i×j×k lattice is the tricubic uniform B-spline.
TEST(BSpline, OpenGridIsTheTricubicSpline) {
    for (const Rules rules : kLatticeRules) {
        expectTensorProduct({3, 3, 3}, Boundary::Open, 2, rules);
        expectTensorProduct({3, 4, 5}, Boundary::Open, 2, rules);
        expectTensorProduct({2, 3, 4}, Boundary::Open, 1, rules);
    }
}

// With SharpEdges::SingleCell, a box lattice of any size is the tricubic B-spline with a phantom
// layer 2P₀ − P₁ around it: with P₋ = 2P₀ − P₁, (P₋ + 6P₀ + P₁)/8 = P₀, which is the row of the
// end.
TEST(BSpline, SharpBoxIsTheSplineWithAPhantomLayer) {
    for (const Rules rules : kLatticeRules) {
        expectTensorProduct({1, 1, 1}, Boundary::Sharp, 3, rules);
        expectTensorProduct({4, 1, 2}, Boundary::Sharp, 2, rules);
        expectTensorProduct({3, 3, 3}, Boundary::Sharp, 2, rules);
    }
}

/// Returns the B-spline coefficient, for knots with spacing h, of a cubic a + bx + cx² + dx³ at the
/// point x: its polar form at (x − h, x, x + h).
double coefficient(const std::array<double, 4>& cubic, double x, double h) {
    return cubic[0] + cubic[1] * x + cubic[2] * (x * x - h * h / 3) +
           cubic[3] * (x * x * x - h * h * x);
}

// A cubic polynomial, given by its B-spline coefficients, stays the same polynomial. This test is
// stricter than affine invariance: rules with wrong second moments fail only here.
TEST(BSpline, CubicPolynomialsStayExact) {
    const std::array<Index, 3> n = {4, 3, 5};
    const std::array<std::array<double, 4>, 3> cubics = {
        {{0.3, -1.1, 0.7, 0.4}, {1.2, 0.5, -0.6, 0.2}, {-0.8, 0.9, 0.3, -0.1}}};
    const int levels = 2;
    TopologyRefiner refiner = test::refined(test::grid(n), levels, {.boundary = Boundary::Open});
    RefinedGrid grid = baseGrid(n);
    std::array<double, 3> origin = {};
    double spacing = 1;
    const auto valueAt = [&](const GridPoint& point) {
        double product = 1;
        for (std::size_t axis = 0; axis < 3; ++axis)
            product *= coefficient(cubics[axis], origin[axis] + spacing * point[axis], spacing);
        return product;
    };
    std::vector<double> values;
    for (const GridPoint& point : grid.points) values.push_back(valueAt(point));
    for (int level = 1; level <= levels; ++level) {
        RefinedGrid next{
            {2 * (grid.cells[0] - 1), 2 * (grid.cells[1] - 1), 2 * (grid.cells[2] - 1)}, {}};
        for (Index v = 0; v < refiner.level(level).complex.count(0); ++v) {
            const GridPoint half = halfPoint(refiner, grid, level, v);
            next.points.push_back({half[0] - 1, half[1] - 1, half[2] - 1});
        }
        grid = next;
        spacing /= 2;
        for (double& x : origin) x += spacing;
        for (const Rules rules : kLatticeRules) {
            const auto refined = refineValues(withRules(refiner, rules), level, values, 1);
            for (std::size_t v = 0; v < grid.points.size(); ++v)
                // Values reach about 2000 at the far corner: 64 products of that size.
                ASSERT_NEAR(refined[v], valueAt(grid.points[v]), 2e-11) << "level " << level;
        }
    }
}

}  // namespace
}  // namespace espalier::stencils
