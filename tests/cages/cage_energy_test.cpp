// SPDX-License-Identifier: Apache-2.0
#include "cages/cage_energy.h"

#include <espalier/far/standard_cells.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <gtest/gtest.h>

#include "grid_cages.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

struct Cage {
    Lattice lattice = test::gridCage(test::brick(), 0.7);
    far::TopologyRefiner refiner{lattice.complex, refinerOptions(lattice)};
    Cage() {
        refiner.refineUniform(CellShapes::kLevel);
        for (Point3& p : lattice.positions)
            p = {p[0] + 0.1 * std::sin(3 * p[1]), p[1] + 0.1 * std::sin(3 * p[2]), p[2]};
    }
};

/// Checks the gradient of an energy by central differences.
void expectGradient(const Energy& energy, std::vector<Point3> positions) {
    std::vector<Point3> gradient(positions.size()), ignored(positions.size());
    energy(positions, gradient);
    double largest = 0;
    for (const Point3& slope : gradient) largest = std::max(largest, length(slope));
    ASSERT_GT(largest, 0);
    const double step = 1e-5;
    for (std::size_t vertex = 0; vertex < positions.size(); vertex += 7)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double place = positions[vertex][axis];
            positions[vertex][axis] = place + step;
            const double after = energy(positions, ignored);
            positions[vertex][axis] = place - step;
            const double before = energy(positions, ignored);
            positions[vertex][axis] = place;
            // The error of central differences is of the order of the squared step, 1e-10, and of
            // rounding over the step, 1e-16 · 1e2 / 1e-5.
            EXPECT_NEAR((after - before) / (2 * step), gradient[vertex][axis], 1e-6 * largest);
        }
}

TEST(CellShapes, hasTheGradientOfItsEnergy) {
    const Cage cage;
    CellShapes shapes(cage.refiner);
    const Energy energy = [&](std::span<const Point3> positions, std::span<Point3> gradient) {
        return shapes.evaluate(positions, gradient);
    };
    expectGradient(energy, cage.lattice.positions);
    shapes.scaleWeight(0, 3);
    const std::vector<Index> examined = {0, 1};
    shapes.examine(examined);
    expectGradient(energy, cage.lattice.positions);
}

TEST(CellShapes, isSmallestForCubesAndOfNoScale) {
    const Cage cage;
    const CellShapes shapes(cage.refiner);
    std::vector<Point3> ignored(cage.lattice.positions.size());
    const double bent = shapes.evaluate(cage.lattice.positions, ignored);
    std::vector<Point3> larger = cage.lattice.positions;
    for (Point3& p : larger) p = scaled(p, 10);
    EXPECT_NEAR(shapes.evaluate(larger, ignored), bent, 1e-9 * bent);  // rounding of sums
    const Lattice straight = test::gridCage(test::brick(), 0.7);
    EXPECT_LT(shapes.evaluate(straight.positions, ignored), bent);
}

TEST(CellShapes, measuresScaledJacobians) {
    const Cage cage;
    CellShapes shapes(cage.refiner);
    auto positions = cage.lattice.positions;
    for (const double value : shapes.leastJacobians(positions)) {
        EXPECT_GT(value, 0.1);
        EXPECT_LE(value, 1);
    }
    // Turned inside out.
    for (Point3& p : positions) p[0] = -p[0];
    for (const double value : shapes.leastJacobians(positions)) EXPECT_LT(value, 0);
}

// CellShapes takes the limits of vertices that stay from the level before.
TEST(CellShapes, measuresEachLevelAtItsLimits) {
    const Cage cage;
    std::vector<double> expected(cage.lattice.complex.count(3), 1.0);
    for (int level = 0; level <= CellShapes::kLevel; ++level) {
        const std::vector<Point3> vertices =
            level == 0 ? cage.lattice.positions
                       : stencils::applyLevelTable(limit::buildVertexLimits(cage.refiner, level),
                                                   cage.lattice.positions);
        const far::CellComplex& complex = cage.refiner.level(level).complex;
        for (Index cell = 0; cell < complex.count(3); ++cell) {
            Index base = cell;
            for (int k = level; k > 0; --k)
                base = cage.refiner.refinement(k).parentOf({3, base}).upper.index;
            const auto corners = *far::hexahedronVertices(complex, CellId(cell));
            for (std::size_t corner = 0; corner < 8; ++corner) {
                std::array<Point3, 3> ways;
                for (std::size_t i = 0; i < 3; ++i)
                    ways[i] = normalised(
                        difference(vertices[corners[far::kHexahedronNeighbours[corner][i]]],
                                   vertices[corners[corner]]));
                expected[base] = std::min(expected[base], dot(ways[0], cross(ways[1], ways[2])));
            }
        }
    }
    const auto found = CellShapes(cage.refiner).leastJacobians(cage.lattice.positions);
    ASSERT_EQ(found.size(), expected.size());
    // The weights of limits on two levels differ by rounding.
    for (std::size_t cell = 0; cell < found.size(); ++cell)
        EXPECT_NEAR(found[cell], expected[cell], 1e-12);
}

TEST(EvaluatePlanes, hasTheGradientOfItsEnergy) {
    const Cage cage;
    const auto table = stencils::buildStencils(cage.refiner, 1);
    std::vector<PlaneTerm> terms;
    for (Index row = 0; row < table.rowCount(); row += 2)
        terms.push_back({row, normalised({1, 0.1 * (row % 7), -0.2 * (row % 5)}),
                         0.1 * (row % 9) - 0.4, 3, 1, 0.2});
    expectGradient(
        [&](std::span<const Point3> positions, std::span<Point3> gradient) {
            return evaluatePlanes(table, terms, positions, gradient);
        },
        cage.lattice.positions);
}

TEST(Minimise, findsTheMinimumOfAQuadratic) {
    const std::vector<Point3> target = {{1, 2, 3}, {-1, 0, 5}};
    const Energy energy = [&](std::span<const Point3> positions, std::span<Point3> gradient) {
        double total = 0;
        for (std::size_t i = 0; i < 2; ++i) {
            const double weight = i == 0 ? 1 : 50;
            const Point3 way = difference(positions[i], target[i]);
            total += weight * dot(way, way);
            gradient[i] = sum(gradient[i], scaled(way, 2 * weight));
        }
        return total;
    };
    const auto found = minimise(energy, {{0, 0, 0}, {0, 0, 0}}, 60, 0.5);
    for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(found[i][axis], target[i][axis], 1e-6);  // 60 steps of superlinear descent
    // No iteration moves a vertex further than the longest step.
    const auto first = minimise(energy, {{0, 0, 0}, {0, 0, 0}}, 1, 0.01);
    for (const Point3& p : first) EXPECT_LE(length(p), 0.01 + 1e-12);
}

}  // namespace
}  // namespace espalier::cages
