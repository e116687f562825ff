// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/merge.h>

#include "cages/collar_proof.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

using Kind = CollarProof::FailureKind;

/// A small cube below a large block, with a gap of 1, and a layer of each that goes into the gap.
struct Gap {
    Lattice lattice;
    CollarCells cells;

    /// \param smallReach thickness of the layer on the cube
    Gap(bool isCubeFirst, double smallReach, double largeReach) {
        const Lattice cube = shapes::box({{1, 1, 1}, {1.4, 1.4, 0}, {2, 2, 1}});
        const Lattice block = shapes::box({{1, 1, 1}, {0, 0, 2}, {4, 4, 3}});
        lattice = isCubeFirst ? shapes::merge(cube, block) : shapes::merge(block, cube);
        const Index cubeTop = isCubeFirst ? 4 : 12, blockBottom = isCubeFirst ? 8 : 0;
        if (!isCubeFirst) add({blockBottom, 0, 2, 3, 1}, -largeReach);
        add({cubeTop, 0, 1, 3, 2}, smallReach);
        if (isCubeFirst) add({blockBottom, 0, 2, 3, 1}, -largeReach);
    }

    /// Adds a layer over a vertex plus each of four numbers, anticlockwise seen from the top.
    void add(const std::array<Index, 5>& face, double rise) {
        CollarPrism prism;
        for (const Index corner : {face[1], face[2], face[3], face[4]}) {
            const Index over = face[0] + corner;
            Point3 position = lattice.positions[std::size_t(over)];
            position[2] += rise;
            prism.bottom.push_back(over);
            prism.top.push_back(
                static_cast<Index>(lattice.positions.size() + cells.vertices.size()));
            cells.vertices.push_back({over, 1, position});
        }
        cells.prisms.push_back(prism);
    }

    std::optional<CollarProof::Failure> failure() const {
        return CollarProof(lattice).failure(joined(lattice, cells), cells);
    }
};

TEST(CollarProof, FindsOverlapsInCellsOfHigherAndLowerNumbers) {
    for (const bool isCubeFirst : {true, false}) {
        EXPECT_FALSE(Gap(isCubeFirst, 0.4, 0.4).failure());
        // The outer vertices of the cube are in the layer of the block; no vertex of that layer,
        // not even the middle of its outer face, is in the layer of the cube.
        const auto failure = Gap(isCubeFirst, 0.7, 0.7).failure();
        ASSERT_TRUE(failure);
        EXPECT_EQ(failure->kind, Kind::Overlap);
        EXPECT_STREQ(failure->text(), "overlap");
    }
}

TEST(CollarProof, FindsVerticesOfTheLatticeInTheCollar) {
    // The layer of the block goes through the open top of the cube.
    for (const bool isCubeFirst : {true, false}) {
        Gap gap(isCubeFirst, 0.1, 1.5);
        const auto failure = gap.failure();
        ASSERT_TRUE(failure);
        EXPECT_EQ(failure->kind, Kind::Overlap);
    }
}

TEST(CollarProof, NamesTheVertexOfMostCells) {
    CollarProof::Failure failure;
    failure.vertices = {9, 4, 7, 7, 2, 4, 7};
    EXPECT_EQ(failure.mostFrequent(), 7);
    failure.vertices = {9, 4, 4, 9};
    EXPECT_EQ(failure.mostFrequent(), 4);
}

TEST(CollarProof, LeavesOutCellsThatFoldedBefore) {
    Lattice lattice = shapes::box({{2, 2, 2}, {0, 0, 0}, {2, 2, 2}});
    const CollarCells none;
    EXPECT_FALSE(CollarProof(lattice).failure(lattice, none));
    const CollarProof right(lattice);
    lattice.positions[13] = {2.5, 2.5, 2.5};
    EXPECT_FALSE(CollarProof(lattice).failure(lattice, none));
    const auto failure = right.failure(lattice, none);
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, Kind::Fold);
}

}  // namespace
}  // namespace espalier::cages
