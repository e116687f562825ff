// SPDX-License-Identifier: Apache-2.0
#include "cages/grid_cells.h"

#include <espalier/base/vector3.h>
#include <gtest/gtest.h>

#include "face_models.h"
#include "lattice_measures.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

using test::FaceModel, test::SolidTopology;

/// The cells of a model, in units of cells.
struct Cells {
    ModelSurface surface;
    ModelVoxels voxels;
    GridCells cells;

    Cells(const FaceModel& model, double cellSize, double joinDistance, double reach = 0.4,
          const std::array<Index, 3>& offset = {0, 0, 0})
        : surface(model),
          voxels(surface, surface.points(), {.size = cellSize / 8, .gap = cellSize / 2}),
          cells(voxels, {.voxelsPerEdge = 8,
                         .offset = offset,
                         .joinDistance = 8 * joinDistance,
                         .reach = 8 * reach}) {}
};

SolidTopology topologyOf(const Cells& made) {
    EXPECT_TRUE(made.cells.isManifold());
    const Lattice lattice = made.cells.build();
    EXPECT_EQ(lattice.complex.count(0), made.cells.vertexCount());
    EXPECT_EQ(lattice.complex.count(3), made.cells.cellCount());
    EXPECT_EQ(lattice.positions.size(), static_cast<std::size_t>(made.cells.vertexCount()));
    return test::topologyOf(lattice.complex);
}

TEST(GridCells, haveTheTopologyOfTheModel) {
    for (const double size : {0.25, 0.4, 0.6}) {
        EXPECT_EQ(topologyOf({test::ballModel(3), size, 0.75}), (SolidTopology{1, 0, 0}));
        EXPECT_EQ(topologyOf({test::ringModel(1, 0.3), size, 0.75}), (SolidTopology{1, 1, 0}));
        EXPECT_EQ(topologyOf(
                      {test::joined({test::ballModel(3), test::ballModel(3, {1, 1, 1}, {4, 0, 0})}),
                       size, 0.75}),
                  (SolidTopology{2, 0, 0}));
    }
    const FaceModel hollow =
        test::joined({test::ballModel(4), test::reversed(test::ballModel(4, {0.7, 0.7, 0.7}))});
    EXPECT_EQ(topologyOf({hollow, 0.3, 0.75}), (SolidTopology{1, 0, 1}));
}

TEST(GridCells, keepPartsInOneCubeApart) {
    // Two balls with a gap of 0.3 cells; a ring whose two sides pass through one cube.
    const FaceModel balls =
        test::joined({test::ballModel(3), test::ballModel(3, {1, 1, 1}, {2.15, 0, 0})});
    EXPECT_EQ(topologyOf({balls, 0.5, 0.125}), (SolidTopology{2, 0, 0}));
    EXPECT_EQ(topologyOf({balls, 0.5, 0.75}).components, 1);
}

TEST(GridCells, placePointsInTheirCells) {
    const FaceModel balls =
        test::joined({test::ballModel(3), test::ballModel(3, {1, 1, 1}, {2.15, 0, 0})});
    const Cells made(balls, 0.5, 0.125, 0);
    const Lattice lattice = made.cells.build();
    for (const Point3& p : balls.points) {
        const auto found = made.cells.cellOf(p);
        ASSERT_TRUE(found);
        const Index cell = *found;
        // Without left out cells, the point is in the cube of its cell.
        for (std::size_t axis = 0; axis < 3; ++axis) {
            double low = 1e9, high = -1e9;
            for (const Index vertex : lattice.complex.relation(3, 0)[cell]) {
                low = std::min(low, lattice.positions[vertex][axis]);
                high = std::max(high, lattice.positions[vertex][axis]);
            }
            EXPECT_GE(p[axis], low - 1e-12);
            EXPECT_LE(p[axis], high + 1e-12);
        }
    }
}

TEST(GridCells, leaveOutCellsThatTheModelHardlyReaches) {
    const Cells all(test::ballModel(3), 0.5, 0.75, 0), fewer(test::ballModel(3), 0.5, 0.75, 0.4);
    EXPECT_LT(fewer.cells.cellCount(), all.cells.cellCount());
    EXPECT_EQ(topologyOf(fewer), topologyOf(all));
}

TEST(GridCells, resolveContacts) {
    // Random small balls make cubes that touch in edges and vertices only.
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-1, 1);
    for (int round = 0; round < 40; ++round) {
        std::vector<FaceModel> balls;
        for (int i = 0; i < 12; ++i)
            balls.push_back(
                test::ballModel(1, {0.2, 0.2, 0.2}, {place(random), place(random), place(random)}));
        for (const double join : {0.125, 0.75, 2.0}) {
            const Cells made(test::joined(balls), 0.4, join);
            EXPECT_TRUE(topologyOf(made).isManifold) << "round " << round << ", " << join;
        }
    }
}

}  // namespace
}  // namespace espalier::cages
