// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/point_descent.h>
#include <espalier/shapes/inventory.h>

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
    EXPECT_THAT(descent.begin(points, Sought::Nearest).candidates.cells, ElementsAre(0));

    // Of all cells, the same one is kept.
    Descent found = descent.begin(points, Sought::Nearest);
    found.candidates = {};
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

// A block with a row of cells at one corner. Without boundary control the row vanishes, since all
// its vertices are on the boundary. The nearest cell is then in the block, though the row is
// nearer.
TEST(PointDescent, CellsThatVanishAreNotNearest) {
    const Lattice lattice = carvedGrid(
        {6, 2, 2}, [](Index i, Index j, Index k) { return i < 2 || (j == 0 && k == 0); });
    const TopologyRefiner base(lattice.complex, {.boundary = Boundary::Open});
    const PointDescent descent = descentInto(base, lattice.positions);
    const std::vector<Point3> points = {{7, 0.5, 0.5}};
    const Descent found = descent.begin(points, Sought::Nearest);
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
