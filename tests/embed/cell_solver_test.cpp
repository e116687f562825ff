// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/cell_solver.h>
#include <espalier/embed/point_location.h>

#include <utility>

#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::embed {
namespace {

// Given the cells whose boxes contain a point, the solver alone finds the same place as the
// locator.
TEST(CellSolver, AgreesWithTheLocator) {
    for (const auto& [name, lattice] : zoo()) {
        const Refined refined(lattice, 1);
        Eigen::AlignedBox3d box;
        for (const Point3& position : refined.positions) box.extend(vec(position));
        const double size = box.diagonal().norm();
        const PointLocator locator(refined.complex(), refined.positions, 1e-6);
        const CellSolver solver(refined.complex(), refined.positions,
                                {.size = size, .tolerance = 1e-6 * size});
        auto points = pointsIn(refined, 60, 13);
        for (std::size_t v = 0; v < refined.positions.size();
             v += 1 + refined.positions.size() / 40)
            points.push_back(refined.positions[v]);
        int inCells = 0;
        const Index cellCount = refined.complex().count(3);
        const auto nearestTo = [&](const Point3& point) {
            std::pair nearest(kInfinity, Index{0});
            for (Index cell = 0; cell < cellCount; ++cell)
                nearest = std::min(nearest, {solver.distance(vec(point), CellId(cell)), cell});
            return CellId(nearest.second);
        };
        for (const Point3& point : points) {
            std::vector<Index> cells;
            for (Index cell = 0; cell < cellCount; ++cell)
                if (solver.boxOf(CellId(cell)).contains(vec(point))) cells.push_back(cell);
            const auto inside = solver.locateIn(vec(point), cells);
            inCells += inside.has_value();
            const LocatedPoint expected = locator.locate(point, true);
            LocatedPoint found{PointStatus::Outside, {}, 0, 0};
            if (inside)
                found = *inside;
            else if (!cells.empty())
                found = solver.locateInGap(vec(point), nearestTo(point));
            if (found.status == PointStatus::Outside)
                found = solver.carry(vec(point), nearestTo(point));
            ASSERT_EQ(found.status, expected.status) << name;
            ASSERT_EQ(found.distance, expected.distance) << name;
            ASSERT_EQ(found.residual, expected.residual) << name;
            ASSERT_TRUE(found.place && expected.place) << name;
            ASSERT_EQ(found.place->cell, expected.place->cell) << name;
            ASSERT_EQ(found.place->tetrahedron, expected.place->tetrahedron) << name;
            ASSERT_EQ(found.place->uvw, expected.place->uvw) << name;
            ASSERT_EQ(found.place->offset, expected.place->offset) << name;
        }
        EXPECT_GT(inCells, 40) << name;
    }
}

}  // namespace
}  // namespace espalier::embed
