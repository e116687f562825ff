// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/cell_bounds.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>

#include "support/complexes.h"
#include "support/random_lattices.h"
#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::embed {
namespace {

using Eigen::Vector3d;

/// The edges of a cell that is oblique to the coordinate axes.
const Eigen::Matrix3d kOblique{{3, 1, -2}, {-1, 2, 1}, {1, 0.5, 4}};

// The drift along each axis of the grid is a sixth of the second difference, and there are three.
// The test finds second differences by the numbers of the grid points. They are exact, since the
// coordinates are small integers.
TEST(CellBounds, DriftIsHalfTheLargestSecondDifferenceAround) {
    const std::array<Index, 3> n = {5, 4, 2};
    const TopologyRefiner refiner(grid(n));
    std::mt19937 random(1);
    for (int trial = 0; trial < 20; ++trial) {
        std::vector<Point3> positions = gridPositions(n);
        for (Point3& position : positions)
            for (double& coordinate : position)
                coordinate = 1000 * coordinate + double(random() % 1000);
        const auto at = [&](const std::array<Index, 3>& point) {
            return vec(positions[gridVertex(n, point[0], point[1], point[2])]);
        };
        CellBounds bounds(refiner.level(0), positions, far::Creasing::Uniform);
        for (Index cell = 0; cell < refiner.level(0).complex.count(3); ++cell) {
            // The grid points of the cells around the cell.
            const std::array<Index, 3> place = {cell % n[0], cell / n[0] % n[1],
                                                cell / n[0] / n[1]};
            std::array<Index, 3> low = {}, high = {};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                low[axis] = std::max(place[axis], 1) - 1;
                high[axis] = std::min(place[axis] + 2, n[axis]);
            }
            Vector3d largest = Vector3d::Zero();
            for (Index k = low[2]; k <= high[2]; ++k)
                for (Index j = low[1]; j <= high[1]; ++j)
                    for (Index i = low[0]; i <= high[0]; ++i)
                        for (std::size_t axis = 0; axis < 3; ++axis) {
                            std::array<Index, 3> before = {i, j, k}, after = {i, j, k};
                            if (--before[axis] < low[axis] || ++after[axis] > high[axis]) continue;
                            const Vector3d difference = at(before) - 2 * at({i, j, k}) + at(after);
                            largest = largest.cwiseMax(difference.cwiseAbs());
                        }
            const auto bound = bounds.boundOf(cell, std::nullopt);
            ASSERT_TRUE(bound && bound->drift);
            EXPECT_EQ(*bound->drift, largest / 2) << cell;
        }
    }
}

TEST(CellBounds, DriftFallsToAQuarterWithEachLevel) {
    const Lattice box = shapes::box();
    const TopologyRefiner refiner(box.complex);
    CellBounds bounds(refiner.level(0), box.positions, far::Creasing::Uniform);
    const auto bound = bounds.boundOf(0, Vector3d(4, 8, 12));
    ASSERT_TRUE(bound && bound->drift);
    EXPECT_EQ(*bound->drift, Vector3d(1, 2, 3));
    EXPECT_EQ(bound->box.min(), Vector3d(-1, -2, -3));
    EXPECT_EQ(bound->box.max(), Vector3d(2, 3, 4));
}

TEST(CellBounds, ContainTheVerticesOfAllDescendants) {
    std::vector<NamedLattice> lattices = zoo();
    for (NamedLattice& named : featureLattices()) lattices.push_back(std::move(named));
    constexpr int kLevels = 3;
    int boundCount = 0;
    for (const auto& [name, lattice] : lattices) {
        SCOPED_TRACE(name);
        TopologyRefiner refiner(lattice.complex, refinerOptions(lattice));
        refiner.refineUniform(kLevels);
        const std::vector<Point3> rest = shaken(lattice.positions, 2, 0.2);
        // The bounds of the ancestors of each cell of the level above, the nearest first.
        std::vector<std::vector<std::optional<CellBound>>> ofParents;
        for (int level = 0; level <= kLevels; ++level) {
            const CellComplex& complex = refiner.level(level).complex;
            const std::vector<Point3> positions = stencils::refinePositions(refiner, level, rest);
            CellBounds bounds(refiner.level(level), positions, refiner.options().creasing);
            std::vector<std::vector<std::optional<CellBound>>> ofCells;
            for (Index cell = 0; cell < complex.count(3); ++cell) {
                auto& lines = ofCells.emplace_back();
                std::optional<Vector3d> inherited;
                if (level > 0) {
                    lines = ofParents[refiner.refinement(level).parentOf({3, cell}).upper.index];
                    if (lines.front()) inherited = lines.front()->drift;
                }
                lines.insert(lines.begin(), bounds.boundOf(cell, inherited));
                for (const auto& bound : lines) {
                    if (!bound) continue;
                    ++boundCount;
                    for (const Index vertex : complex.relation(3, 0)[cell])
                        // The rounding of positions of about 1.
                        ASSERT_LT(bound->box.exteriorDistance(vec(positions[vertex])), 1e-14)
                            << "level " << level << ", cell " << cell;
                }
            }
            ofParents = std::move(ofCells);
        }
    }
    EXPECT_GT(boundCount, 10000);
}

TEST(CellBounds, OwnBoxIsWidenedByAFractionOfTheDiagonal) {
    const Lattice box = shapes::box({.max = {1, 2, 2}});
    const TopologyRefiner refiner(box.complex);
    const CellBounds bounds(refiner.level(0), box.positions, far::Creasing::Uniform);
    EXPECT_EQ(bounds.ownBox(0).box.min(), Vector3d(0, 0, 0));
    EXPECT_EQ(bounds.ownBox(0).box.max(), Vector3d(1, 2, 2));
    const CellBound wide = bounds.ownBox(0, 0.25);
    EXPECT_EQ(wide.box.min(), Vector3d(-0.75, -0.75, -0.75));
    EXPECT_EQ(wide.box.max(), Vector3d(1.75, 2.75, 2.75));
    EXPECT_EQ(*wide.drift, Vector3d::Constant(0.75));
}

// Refinement moves points out of a cell, so its hull must contain points beside the cell, up to the
// margin. They are given by their coordinates along the edges of the cell.
TEST(CellBounds, OwnHullIsWidenedByAFractionOfTheEdges) {
    const Lattice tetrahedron{singleCell(far::StandardCell::Tetrahedron),
                              {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                              {},
                              {}};
    for (const Lattice& lattice : {shapes::box(), tetrahedron}) {
        std::vector<Point3> positions = lattice.positions;
        for (Point3& position : positions) position = toPoint(kOblique * vec(position));
        const TopologyRefiner refiner(lattice.complex);
        const CellBounds bounds(refiner.level(0), positions, far::Creasing::Uniform);
        const AffineHull exact = bounds.ownHull(0, 0), wide = bounds.ownHull(0, 0.25);
        for (Eigen::Index axis = 0; axis < 3; ++axis)
            for (const double side : {-1, 1}) {
                const auto beyond = [&](double distance) -> Vector3d {
                    return kOblique * (Vector3d::Constant(0.5) +
                                       side * (0.5 + distance) * Vector3d::Unit(axis));
                };
                EXPECT_TRUE(exact.contains(beyond(-0.01)));
                EXPECT_FALSE(exact.contains(beyond(0.01)));
                EXPECT_TRUE(wide.contains(beyond(0.24)));
                EXPECT_FALSE(wide.contains(beyond(0.26)));
            }
    }
}

}  // namespace
}  // namespace espalier::embed
