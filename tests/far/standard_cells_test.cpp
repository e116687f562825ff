// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/standard_cells.h>
#include <espalier/far/topology_refiner.h>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

CellComplex cellOf(const Loops& loops, Index vertexCount) {
    return lattice(vertexCount, {loops});
}

/// Rotates each loop to start at its smallest vertex, and sorts the loops.
Loops canonical(Loops loops) {
    for (auto& loop : loops)
        std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    std::sort(loops.begin(), loops.end());
    return loops;
}

/// Returns the faces of a recognised standard cell.
Loops facesOf(const StandardCellVertices& cell) {
    Loops loops = faceLoops(cell.kind);
    for (auto& loop : loops)
        for (Index& vertex : loop) vertex = cell.vertices[vertex];
    return canonical(loops);
}

Loops facesOf(const CellComplex& complex, Index cell) {
    return canonical(outwardLoops(complex, CellId(cell)));
}

/// A cell is recognised for any order of its faces, any start of its loops and any numbering of its
/// vertices, and the faces that it returns are the faces of the complex, with their orientation.
TEST(StandardCells, AreRecognisedByTheirFaces) {
    for (const StandardCell kind : {StandardCell::Tetrahedron, StandardCell::Pyramid,
                                    StandardCell::Wedge, StandardCell::Hexahedron}) {
        const Index count = vertexCount(kind);
        for (Index turn = 0; turn < count; ++turn) {
            Loops loops = faceLoops(kind);
            for (auto& loop : loops) {
                // 7 has no factor in common with 4, 5, 6 or 8: this is a permutation.
                for (Index& vertex : loop) vertex = (7 * vertex + turn) % count;
                std::rotate(loop.begin(), loop.begin() + turn % 3, loop.end());
            }
            std::rotate(loops.begin(), loops.begin() + turn % 4, loops.end());
            const CellComplex complex = cellOf(loops, count);
            const auto cell = asStandardCell(complex, CellId(0));
            ASSERT_TRUE(cell);
            EXPECT_EQ(cell->kind, kind);
            EXPECT_EQ(facesOf(*cell), facesOf(complex, 0));
            // Files keep the order of the vertices: it begins with the cell's first face, or with
            // the first that has as many corners as the first face of the standard cell.
            std::vector<Index> first;
            for (const Index place : faceLoops(kind)[0]) first.push_back(cell->vertices[place]);
            const auto outward = outwardLoops(complex, CellId(0));
            EXPECT_EQ(first, *std::find_if(outward.begin(), outward.end(), [&](const auto& loop) {
                          return loop.size() == first.size();
                      }));
        }
    }
}

TEST(StandardCells, FollowTheOrientationOfTheComplex) {
    Loops loops = faceLoops(StandardCell::Wedge);
    for (auto& loop : loops) std::reverse(loop.begin(), loop.end());
    const CellComplex complex = cellOf(loops, 6);
    const auto cell = asStandardCell(complex, CellId(0));
    ASSERT_TRUE(cell);
    EXPECT_EQ(cell->kind, StandardCell::Wedge);
    EXPECT_EQ(facesOf(*cell), facesOf(complex, 0));
}

/// Two cells that share a face see it from opposite sides.
TEST(StandardCells, AreRecognisedOnBothSidesOfAFace) {
    const CellComplex complex = mixedCells();
    const StandardCell kinds[] = {StandardCell::Hexahedron, StandardCell::Pyramid,
                                  StandardCell::Wedge, StandardCell::Tetrahedron};
    for (Index c = 0; c < 4; ++c) {
        const auto cell = asStandardCell(complex, CellId(c));
        ASSERT_TRUE(cell) << c;
        EXPECT_EQ(cell->kind, kinds[c]);
        EXPECT_EQ(facesOf(*cell), facesOf(complex, c));
    }
}

/// A pyramid with a vertex in the middle of an edge between two triangles: it has two triangles and
/// three quadrilaterals, as a wedge has, but is not a wedge.
TEST(StandardCells, AreNotRecognisedByTheSizesOfTheirFacesAlone) {
    const CellComplex complex =
        cellOf({{0, 3, 2, 1}, {0, 1, 5, 4}, {1, 2, 4, 5}, {2, 3, 4}, {3, 0, 4}}, 6);
    EXPECT_FALSE(asStandardCell(complex, CellId(0)));

    // Two tetrahedra glued along a triangle, with a vertex in each edge of the triangle: six
    // quadrilaterals and eight vertices, as a hexahedron has.
    const CellComplex six = cellOf(
        {{0, 5, 1, 3}, {1, 6, 2, 3}, {2, 7, 0, 3}, {1, 5, 0, 4}, {2, 6, 1, 4}, {0, 7, 2, 4}}, 8);
    EXPECT_FALSE(asStandardCell(six, CellId(0)));

    EXPECT_FALSE(asStandardCell(bipyramid(5), CellId(0)));
}

TEST(HexahedronVertices, AreInVtkOrder) {
    // The first face of the standard cell, (0 4 7 3) from outside, is (0 3 7 4) from inside.
    EXPECT_EQ(hexahedronVertices(singleCell(StandardCell::Hexahedron), CellId(0)),
              (std::array<Index, 8>{0, 3, 7, 4, 1, 2, 6, 5}));
    for (const auto other : {StandardCell::Tetrahedron, StandardCell::Pyramid, StandardCell::Wedge})
        EXPECT_EQ(hexahedronVertices(singleCell(other), CellId(0)), std::nullopt);
}

TEST(HexahedronVertices, SixQuadrilateralsNeedNotBeAHexahedron) {
    // Vertices 0 and 1 have valence 4, 6 and 7 valence 2.
    const CellComplex solid = lattice(
        8, {{{0, 2, 1, 3}, {0, 3, 6, 4}, {6, 3, 1, 4}, {0, 4, 1, 5}, {0, 5, 7, 2}, {7, 5, 1, 2}}});
    EXPECT_EQ(solid.count(2), 6);
    EXPECT_EQ(solid.count(0), 8);
    EXPECT_EQ(hexahedronVertices(solid, CellId(0)), std::nullopt);
}

/// Reorders the loops, and starts each from another vertex.
Loops permuted(const Loops& loops, const std::array<std::size_t, 6>& order) {
    Loops result;
    for (std::size_t i = 0; i < 6; ++i) {
        result.push_back(loops[order[i]]);
        std::rotate(result[i].begin(), result[i].begin() + int((i + order[0]) % 4),
                    result[i].end());
    }
    return result;
}

// Tests the middle one of three cells: it sees the face that it shares with the cell before from
// the other side.
TEST(HexahedronVertices, DoNotDependOnTheOrderOfFaces) {
    const CellComplex row = grid({3, 1, 1});
    for (const bool insideOut : {false, true}) {
        std::vector<Loops> cells;
        for (Index cell = 0; cell < 3; ++cell) {
            cells.push_back(outwardLoops(row, CellId(cell)));
            for (auto& loop : cells.back())
                if (insideOut) std::reverse(loop.begin(), loop.end());
        }
        std::array<std::size_t, 6> order = {0, 1, 2, 3, 4, 5};
        std::array<int, 2> signCount = {};
        do {
            const CellComplex complex =
                lattice(row.count(0), {cells[0], permuted(cells[1], order), cells[2]});
            const auto vertices = hexahedronVertices(complex, CellId(1));
            ASSERT_TRUE(vertices);
            const Index base = complex.relation(3, 2)[1][0];
            EXPECT_TRUE(std::is_permutation(vertices->begin(), vertices->begin() + 4,
                                            complex.relation(2, 0)[base].begin()));
            EXPECT_EQ(vertices->front(), complex.relation(2, 0)[base].front());
            EXPECT_EQ(facesOf({StandardCell::Hexahedron, {vertices->begin(), vertices->end()}}),
                      facesOf(complex, 1));
            ++signCount[complex.boundary(3).signs(1)[0] > 0];
        } while (std::next_permutation(order.begin(), order.end()));
        EXPECT_GT(signCount[0], 0);
        EXPECT_GT(signCount[1], 0);
    }
}

// Six quadrilaterals and eight vertices, of valence 2, 3 and 4.
TEST(HexahedronVertices, OtherSolidsAreRefusedForAnyOrderOfFaces) {
    const Loops solids[] = {
        {{0, 2, 1, 3}, {0, 3, 6, 4}, {6, 3, 1, 4}, {0, 4, 1, 5}, {0, 5, 7, 2}, {7, 5, 1, 2}},
        {{0, 5, 1, 3}, {1, 6, 2, 3}, {2, 7, 0, 3}, {1, 5, 0, 4}, {2, 6, 1, 4}, {0, 7, 2, 4}}};
    for (const Loops& solid : solids) {
        std::array<std::size_t, 6> order = {0, 1, 2, 3, 4, 5};
        do {
            const CellComplex complex = lattice(8, {permuted(solid, order)});
            ASSERT_EQ(hexahedronVertices(complex, CellId(0)), std::nullopt);
        } while (std::next_permutation(order.begin(), order.end()));
    }
}

// The fast function and the general one find the same cells, but may start at different corners.
TEST(HexahedronVertices, AgreeWithAsStandardCell) {
    for (const CellComplex& complex : {grid({2, 2, 1}), mixedCells()})
        for (Index cell = 0; cell < complex.count(3); ++cell) {
            const auto general = asStandardCell(complex, CellId(cell));
            const auto quick = hexahedronVertices(complex, CellId(cell));
            ASSERT_TRUE(general);
            ASSERT_EQ(quick.has_value(), general->kind == StandardCell::Hexahedron);
            if (!quick) continue;
            EXPECT_EQ(facesOf({StandardCell::Hexahedron, {quick->begin(), quick->end()}}),
                      facesOf(complex, cell));
        }
}

// In a refined lattice the corners follow from the order of the faces. A complex with the same
// boundaries that does not know that it is refined has the same corners.
TEST(HexahedronVertices, RefinedCellsAgreeWithOtherCells) {
    for (const CellComplex& base : {grid({2, 2, 1}), mixedCells()}) {
        TopologyRefiner refiner(base);
        refiner.refineUniform(2);
        for (int level = 1; level <= 2; ++level) {
            const CellComplex& refined = refiner.level(level).complex;
            const CellComplex other(
                3, refined.count(0),
                {refined.boundary(1), refined.boundary(2), refined.boundary(3)});
            ASSERT_TRUE(refined.isRefined() && !other.isRefined());
            for (Index cell = 0; cell < refined.count(3); ++cell)
                ASSERT_EQ(hexahedronVertices(refined, CellId(cell)),
                          hexahedronVertices(other, CellId(cell)));
        }
    }
}

}  // namespace
}  // namespace espalier::far
