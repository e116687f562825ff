// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_match.h>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

TEST(TopologyMatch, OrderOfCellsAndWindingDoNotMatter) {
    const CellComplex box = grid({3, 2, 2});
    std::vector<Index> names(box.count(0));
    std::iota(names.begin(), names.end(), 0);
    for (unsigned seed = 1; seed <= 5; ++seed) {
        const CellComplex other = relabelled(box, names, seed);
        EXPECT_EQ(topologyDifference(box, other), std::nullopt);
        EXPECT_EQ(topologyHash(box), topologyHash(other));
    }
}

TEST(TopologyMatch, ReportsTheDifference) {
    const CellComplex box = grid({3, 2, 2});
    EXPECT_THAT(*topologyDifference(box, grid({3, 2, 1})),
                HasSubstr("numbers of vertices differ: the first has 36, the second 24"));
    EXPECT_THAT(*topologyDifference(box, gridMesh(3, 2)),
                HasSubstr("the dimensions differ: the first has 3, the second 2"));
    // The number of vertices and cells is the same, but a pair of vertices is swapped.
    std::vector<Index> names(box.count(0));
    std::iota(names.begin(), names.end(), 0);
    std::swap(names[0], names[5]);
    const CellComplex swapped = relabelled(box, names, 1);
    EXPECT_THAT(*topologyDifference(box, swapped), HasSubstr("has no counterpart"));
    EXPECT_NE(topologyHash(box), topologyHash(swapped));
    EXPECT_NE(topologyHash(box), topologyHash(grid({2, 3, 2})));
}

// One edge has two vertices of valence 2, in either order: the faces have the same vertices, but
// different edges.
TEST(TopologyMatch, OrderOfVerticesInAFaceMatters) {
    const auto solid = [](Index first, Index second) {
        // A tetrahedron whose edge (0, 1) has two vertices in it.
        return lattice(
            6, {{{0, first, second, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1, second, first}}});
    };
    const CellComplex one = solid(4, 5), other = solid(5, 4);
    EXPECT_TRUE(topologyDifference(one, other));
    EXPECT_NE(topologyHash(one), topologyHash(other));
    EXPECT_EQ(topologyDifference(one, solid(4, 5)), std::nullopt);
}

// The hash is stored in files, so it must never change. The reference value was computed by an
// independent implementation of FNV-1a over the numbers 3, 4 (dimension, vertices), 16 (length),
// and the sides 3 0 1 2, 3 0 1 3, 3 0 2 3, 3 1 2 3 as 64-bit little-endian integers.
TEST(TopologyMatch, HashOfATetrahedronIsFixed) {
    EXPECT_EQ(topologyHash(singleCell(StandardCell::Tetrahedron)), 0x32adc01d0b64ecf2u);
}

}  // namespace
}  // namespace espalier::far
