// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/place_points.h>
#include <espalier/embed/point_descent.h>
#include <espalier/shapes/inventory.h>

#include <random>

#include "support/complexes.h"
#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::embed {
namespace {

/// Returns a descent to cells of a lattice, with a tolerance of 0.
PointDescent descentInto(const TopologyRefiner& base, const std::vector<Point3>& positions) {
    return {{base, positions}, CellSolver::scaleOf(positions, 0)};
}

// The point is beyond one end of a row of unit cells, which refinement does not move: its distance
// from the first cell is 3, from the nearest vertex √9.5, and from the second cell 4.
TEST(PointDescent, KeepsTheCellsThatMayBeNearest) {
    const std::array<Index, 3> n = {8, 1, 1};
    const TopologyRefiner base(grid(n));
    const std::vector<Point3> positions = gridPositions(n);
    const PointDescent descent = descentInto(base, positions);
    const std::vector<Point3> points = {{-3, 0.5, 0.5}};
    EXPECT_THAT(descent.begin(points, SoughtCells::Nearest).candidates.cells, ElementsAre(0));

    // Of all cells, the same one is kept.
    Descent found{stencils::Levels(base, positions), {}, {}, descent.rounding()};
    CellBounds bounds(base.level(0), positions, far::Creasing::Uniform);
    for (Index cell = 0; cell < n[0]; ++cell) {
        found.candidates.points.push_back(0);
        found.candidates.endCell(cell, bounds.boundOf(cell, std::nullopt));
    }
    std::vector<double> nearest = {kInfinity};
    descent.keepNearest(found, points, nearest);
    EXPECT_THAT(found.candidates.cells, ElementsAre(0));
    EXPECT_DOUBLE_EQ(nearest[0], std::sqrt(9.5));
}

// Level 0 of a descent has the cell that may contain the point and the 26 cells around it.
TEST(PointDescent, BeginsWithTheBaseCellsAroundThePoints) {
    const std::array<Index, 3> n = {6, 6, 6};
    const TopologyRefiner base(grid(n));
    const std::vector<Point3> positions = gridPositions(n);
    const std::vector<Point3> points = {{2.5, 3.5, 1.5}};
    const Descent found = descentInto(base, positions).begin(points, SoughtCells::Containing);
    const far::CellComplex& complex = found.levels.finestLevel().complex;
    EXPECT_EQ(complex.count(3), 27);
    ASSERT_THAT(found.candidates.cells, ElementsAre(13));
    ASSERT_EQ(found.baseVertices.size(), 64U);
    for (const Index corner : complex.relation(3, 0)[13]) {
        const Point3& position = positions[found.baseVertices[corner]];
        EXPECT_EQ(position, found.levels.finestPositions()[corner]);
        EXPECT_LT((vec(position) - vec(points[0])).norm(), 1);
    }
}

// Level 0 of a descent gives the same rows around the candidates as the whole lattice, with
// semi-sharp edges too.
TEST(PointDescent, RefinesThePartAsTheWhole) {
    const std::array<Index, 3> n = {12, 4, 4};
    const auto vertexAt = [&](Index i) { return gridVertex(n, i, 2, 2); };
    for (const far::Creasing creasing : {far::Creasing::Uniform, far::Creasing::Chaikin}) {
        TopologyRefiner whole(grid(n), {.creasing = creasing,
                                        .marks = {.edges = {{{vertexAt(1), vertexAt(2)}, 1.5F},
                                                            {{vertexAt(2), vertexAt(3)}, 0.5F},
                                                            {{vertexAt(3), vertexAt(4)}, 2.5F}}}});
        const std::vector<Point3> positions = gridPositions(n);
        const std::vector<Point3> points = {{1.5, 1.5, 1.5}};
        Descent found = descentInto(whole, positions).begin(points, SoughtCells::Containing);
        const far::CellComplex complex = found.levels.finestLevel().complex;
        EXPECT_LT(complex.count(3), whole.level(0).complex.count(3));
        std::vector<Index> corners;
        for (const Index cell : found.candidates.cells)
            for (const Index vertex : complex.relation(3, 0)[cell]) corners.push_back(vertex);
        found.levels.refineAround(found.candidates.cells);
        whole.refineUniform(1);
        const auto rows = stencils::buildStencils(whole, 1);
        const stencils::StencilTable<double>& part = found.levels.tables().front();
        const far::Refinement& refinement = found.levels.refiner().refinement(1);
        for (const Index corner : corners) {
            const Index there = found.baseVertices[corner];
            for (int d = 0; d <= 3; ++d) {
                const auto entities = complex.relation(0, d)[corner];
                const auto inWhole = whole.level(0).complex.relation(0, d)[there];
                ASSERT_EQ(entities.size(), inWhole.size());
                for (std::size_t i = 0; i < entities.size(); ++i) {
                    const Entity here{d, entities[i]}, original{d, inWhole[i]};
                    const Index row = refinement.childOf({here, here})->index;
                    const Index same = whole.refinement(1).childOf({original, original})->index;
                    std::vector<Index> columns;
                    for (const Index column : part.columns(row))
                        columns.push_back(found.baseVertices[column]);
                    EXPECT_TRUE(std::ranges::equal(columns, rows.columns(same)));
                    EXPECT_TRUE(std::ranges::equal(part.weights(row), rows.weights(same)));
                }
            }
        }
    }
}

// At once, the levels of these points would have 50,000 cells: points share no cells from level 3
// on, and then each needs up to 64 cells on each level.
TEST(PointDescent, DividesPointsThatShareNoCells) {
    const std::array<Index, 3> n = {4, 4, 4};
    const TopologyRefiner base(grid(n));
    const std::vector<Point3> positions = gridPositions(n);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> inside(0.1, 3.9);
    std::vector<Point3> points(400);
    for (Point3& point : points) point = {inside(random), inside(random), inside(random)};
    points = chosenPoints(points, alongCurve(points));
    Offset next = 0, partCount = 0;
    descentInto(base, positions)
        .descend(points, 5, SoughtCells::Containing, Extent::Cells,
                 [&](Offset first, std::span<const Point3> part, std::optional<Descent>& found) {
                     EXPECT_EQ(first, next);
                     EXPECT_EQ(part.data(), points.data() + first);
                     ASSERT_TRUE(found);
                     ASSERT_EQ(found->levels.finest(), 5);
                     Offset cellCount = 0;
                     for (int k = 0; k <= 5; ++k)
                         cellCount += found->levels.refiner().level(k).complex.count(3);
                     EXPECT_LT(cellCount, 20'000);
                     next += std::ssize(part);
                     ++partCount;
                 });
    EXPECT_EQ(next, std::ssize(points));
    EXPECT_GT(partCount, 1);
}

// A block with a row of cells at one corner. Without boundary control the row vanishes, since all
// its vertices are on the boundary. The nearest cell is then in the block, though the row is
// nearer.
TEST(PointDescent, CellsThatVanishAreNotNearest) {
    const Lattice lattice = carvedGrid(
        {6, 2, 2}, [](Index i, Index j, Index k) { return i < 2 || (j == 0 && k == 0); });
    const TopologyRefiner base(lattice.complex, {.boundary = Boundary::Open});
    const PointDescent descent = descentInto(base, lattice.positions);
    const std::vector<Point3> points = {{7, 0.5, 0.5}};
    const Descent found = descent.begin(points, SoughtCells::Nearest);
    EXPECT_THAT(found.candidates.cells, Not(IsEmpty()));
}

// Coordinates are rounded by 1e-16 of their size, even if the lattice is small.
TEST(PointDescent, RoundingGrowsWithTheDistanceFromTheOrigin) {
    const Lattice box = shapes::box();
    const TopologyRefiner base(box.complex);
    const double atOrigin = descentInto(base, box.positions).rounding();
    std::vector<Point3> far = box.positions;
    for (Point3& position : far) position[1] -= 1e6;
    EXPECT_LT(atOrigin, 1e-11);
    EXPECT_GT(descentInto(base, far).rounding(), 1e5 * atOrigin);
}

}  // namespace
}  // namespace espalier::embed
