// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/attach.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/remove_cells.h>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

/// A row of four cubes along x: vertex (i, j, k) has the number i + 5 (j + 2 k).
Lattice row() {
    return box({{4, 1, 1}, {0, 0, 0}, {4, 1, 1}});
}

TEST(RemoveCells, UndoesAttach) {
    Lattice before = cylinder({6, {2}, 2});
    before.marks.vertices = {{3, 1.5}};
    before.attributes = {{"heat", 2, {}}};
    for (std::size_t i = 0; i < 2 * before.positions.size(); ++i)
        before.attributes[0].values.push_back(double(i));
    before.integers = {{"part", 1, IntegerType::Int32, {}}};
    for (std::size_t i = 0; i < before.positions.size(); ++i)
        before.integers[0].values.push_back(std::int64_t(i));
    Index boundary = 0;
    while (before.complex.relation(2, 3)[boundary].size() != 1) ++boundary;
    const Lattice grown = attachPyramid(before, FaceId(boundary), {0.3, 0.1, -1});
    const Lattice after = removeCells(grown, std::vector{grown.complex.count(3) - 1});
    EXPECT_EQ(countsOf(after.complex), countsOf(before.complex));
    EXPECT_EQ(after.positions, before.positions);
    EXPECT_EQ(after.marks, before.marks);
    EXPECT_EQ(after.attributes[0].values, before.attributes[0].values);
    EXPECT_EQ(after.integers[0].values, before.integers[0].values);
    expectValid(after);
}

// Without the second cube of four: cubes 0, 2 and 3, in two pieces. No vertex is lost, since a
// neighbour has each vertex of the second cube, too. The four edges of this cube along x are lost.
TEST(RemoveCells, LeavesTwoPieces) {
    Lattice lattice = row();
    lattice.marks.edges = {{{1, 2}, 2.0}, {{2, 3}, 3.0}, {{1, 6}, 4.0}};
    const Lattice rest = removeCells(lattice, std::vector<Index>{1, 1});
    EXPECT_EQ(countsOf(rest.complex), (Counts{20, 32, 17, 3}));
    EXPECT_EQ(rest.complex.eulerCharacteristic(), 2);
    EXPECT_EQ(rest.positions, lattice.positions);
    const std::vector<far::Marks::Edge> marks = {{{2, 3}, 3.0}, {{1, 6}, 4.0}};
    EXPECT_EQ(rest.marks.edges, marks);
    expectValid(rest);
}

// Without the first cube, its four vertices at x = 0 go, and vertex v becomes v − 1 − ⌊v / 5⌋.
TEST(RemoveCells, RenumbersTheVerticesThatRemain) {
    Lattice lattice = row();
    lattice.marks.edges = {{{0, 1}, 2.0}, {{6, 7}, 3.0}};
    lattice.marks.vertices = {{0, 1.0}, {19, 2.0}};
    const Lattice rest = removeCells(lattice, std::vector<Index>{0});
    ASSERT_EQ(rest.positions.size(), 16u);
    EXPECT_EQ(rest.positions[0], (Point3{1, 0, 0}));
    EXPECT_EQ(rest.positions[15], (Point3{4, 1, 1}));
    const std::vector<far::Marks::Edge> edges = {{{4, 5}, 3.0}};
    EXPECT_EQ(rest.marks.edges, edges);
    const std::vector<far::Marks::Vertex> vertices = {{15, 2.0}};
    EXPECT_EQ(rest.marks.vertices, vertices);
}

TEST(RemoveCells, RefusesWrongCells) {
    const Lattice lattice = row();
    const std::vector<Index> none = {}, high = {2, 4}, low = {-1}, all = {0, 1, 2, 3};
    EXPECT_EQ(countsOf(removeCells(lattice, none).complex), countsOf(lattice.complex));
    EXPECT_REFUSED(Error, "removeCells: cells: expected 0 to 3, got 4", removeCells(lattice, high));
    EXPECT_REFUSED(Error, "removeCells: cells: expected 0 to 3, got -1", removeCells(lattice, low));
    EXPECT_REFUSED(Error, "no cell would remain", removeCells(lattice, all));
}

}  // namespace
}  // namespace espalier::shapes
