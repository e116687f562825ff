// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/box_grid.h>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

/// Returns the error for a complex that is not a box.
TopologyError refusalOf(const CellComplex& complex) {
    try {
        asBoxGrid(complex);
    } catch (const TopologyError& error) {
        return error;
    }
    ADD_FAILURE() << "accepted";
    return {TopologyCause::NotABox, {}, ""};
}

/// Builds cells of a grid. name(vertex, i, j, k) renames a vertex of cell (i, j, k); the new names
/// are then numbered in the order of their first appearance.
template <class IsThere, class Name>
CellComplex cellsOfGrid(const std::array<Index, 3>& n, IsThere isThere, Name name) {
    ComplexBuilder builder(3);
    std::map<Index, Index> vertices;
    for (Index k = 0; k < n[2]; ++k)
        for (Index j = 0; j < n[1]; ++j)
            for (Index i = 0; i < n[0]; ++i) {
                if (!isThere(i, j, k)) continue;
                auto cell = gridCell(n, i, j, k);
                for (Index& vertex : cell) {
                    vertex = name(vertex, i, j, k);
                    if (vertices.count(vertex) == 0) vertices[vertex] = builder.addVertex();
                    vertex = vertices[vertex];
                }
                builder.addCell(StandardCell::Hexahedron, cell);
            }
    return builder.build();
}

const auto kAll = [](Index, Index, Index) { return true; };
const auto kSame = [](Index vertex, Index, Index, Index) { return vertex; };

const std::vector<std::array<Index, 3>> kSizes = {
    {1, 1, 1}, {4, 1, 1}, {1, 3, 2}, {2, 2, 2}, {3, 4, 5}};

TEST(BoxGrid, NumberedGridKeepsItsNumbering) {
    for (const auto& n : kSizes) {
        const BoxGrid grid = asBoxGrid(test::grid(n));
        EXPECT_EQ(grid.cells, n);
        for (Index k = 0; k <= n[2]; ++k)
            for (Index j = 0; j <= n[1]; ++j)
                for (Index i = 0; i <= n[0]; ++i)
                    EXPECT_EQ(grid.vertexAt({i, j, k}), gridVertex(n, i, j, k));
    }
}

/// Returns true if an edge of the complex joins two vertices.
bool isEdge(const CellComplex& complex, Index a, Index b) {
    for (const Index edge : complex.relation(0, 1)[a])
        if (contains(complex.relation(1, 0)[edge], b)) return true;
    return false;
}

// For any numbering, neighbours in the grid are neighbours in the lattice, and the first corner and
// the axes are as asBoxGrid() documents.
TEST(BoxGrid, RelabelledGridsAreFoundFromTheLowestCorner) {
    for (const auto& n : kSizes)
        for (const unsigned seed : {1u, 2u, 3u}) {
            const CellComplex plain = test::grid(n);
            const auto names = shuffledIndices(plain.count(0), seed);
            const CellComplex complex = relabelled(plain, names, seed);
            const BoxGrid grid = asBoxGrid(complex);
            auto sizes = grid.cells, expected = n;
            std::sort(sizes.begin(), sizes.end());
            std::sort(expected.begin(), expected.end());
            EXPECT_EQ(sizes, expected);

            Index lowest = complex.count(0);
            for (const Index i : {0, n[0]})
                for (const Index j : {0, n[1]})
                    for (const Index k : {0, n[2]})
                        lowest = std::min(lowest, names[gridVertex(n, i, j, k)]);
            EXPECT_EQ(grid.vertexAt({0, 0, 0}), lowest);
            EXPECT_LT(grid.vertexAt({1, 0, 0}), grid.vertexAt({0, 1, 0}));
            EXPECT_LT(grid.vertexAt({0, 1, 0}), grid.vertexAt({0, 0, 1}));

            const std::set<Index> all(grid.vertices.begin(), grid.vertices.end());
            EXPECT_EQ(all.size(), std::size_t(complex.count(0)));
            EXPECT_EQ(grid.vertices.size(), all.size());
            const auto& m = grid.cells;
            for (Index k = 0; k <= m[2]; ++k)
                for (Index j = 0; j <= m[1]; ++j)
                    for (Index i = 0; i <= m[0]; ++i) {
                        const Index at = grid.vertexAt({i, j, k});
                        if (i < m[0]) {
                            EXPECT_TRUE(isEdge(complex, at, grid.vertexAt({i + 1, j, k})));
                        }
                        if (j < m[1]) {
                            EXPECT_TRUE(isEdge(complex, at, grid.vertexAt({i, j + 1, k})));
                        }
                        if (k < m[2]) {
                            EXPECT_TRUE(isEdge(complex, at, grid.vertexAt({i, j, k + 1})));
                        }
                    }
        }
}

TEST(BoxGrid, OnlyLatticesAreBoxes) {
    const TopologyError mesh = refusalOf(gridMesh(2, 2));
    EXPECT_EQ(mesh.cause(), TopologyCause::WrongDimension);
    EXPECT_THAT(mesh.what(), HasSubstr("dimension 2"));
    EXPECT_EQ(refusalOf(CellComplex()).cause(), TopologyCause::WrongDimension);
}

TEST(BoxGrid, ErrorNamesTheFirstCellThatIsNotAHexahedron) {
    const TopologyError tetrahedron = refusalOf(singleCell(StandardCell::Tetrahedron));
    EXPECT_EQ(tetrahedron.cause(), TopologyCause::NotABox);
    EXPECT_EQ(tetrahedron.entity(), Entity(CellId(0)));
    // Its first cell is a hexahedron, followed by a pyramid and a wedge.
    const TopologyError mixed = refusalOf(mixedCells());
    EXPECT_EQ(mixed.entity(), Entity(CellId(1)));
    EXPECT_THAT(mixed.what(), HasSubstr("cell 1 is not a hexahedron"));
    // Six quadrilaterals are not enough: with two vertices of valence 4, the cell is not a
    // hexahedron.
    EXPECT_EQ(refusalOf(bipyramid(4)).entity(), Entity(CellId(0)));
}

// A ring of eight hexahedra, and a ring of four, which has no corner.
TEST(BoxGrid, ARingIsRefused) {
    const std::array<Index, 3> n = {3, 3, 1};
    const auto isRing = [](Index i, Index j, Index) { return i != 1 || j != 1; };
    // Four cells of the square ring have a corner of their own, so walking straight from one of
    // them finds 3 × 3 × 1 cells, and then the hole.
    const TopologyError square = refusalOf(cellsOfGrid(n, isRing, kSame));
    EXPECT_EQ(square.cause(), TopologyCause::NotABox);
    EXPECT_THAT(square.what(), HasSubstr("a box of 3 × 3 × 1 cells goes on there"));
    // Four cells; the last one ends where the first begins.
    const std::array<Index, 3> bar = {4, 1, 1};
    const auto closed = [&](Index vertex, Index, Index, Index) {
        return vertex % 5 == 4 ? vertex - 4 : vertex;
    };
    const TopologyError round = refusalOf(cellsOfGrid(bar, kAll, closed));
    EXPECT_EQ(round.entity(), Entity(CellId(0)));
    EXPECT_THAT(round.what(), HasSubstr("there is no corner"));
}

TEST(BoxGrid, AMissingCellIsRefused) {
    const std::array<Index, 3> n = {3, 3, 3};
    for (const std::array<Index, 3>& hole :
         {std::array<Index, 3>{1, 1, 1}, {2, 2, 2}, {0, 1, 0}, {1, 0, 2}}) {
        const TopologyError error = refusalOf(cellsOfGrid(
            n,
            [&](Index i, Index j, Index k) {
                return std::array<Index, 3>{i, j, k} != hole;
            },
            kSame));
        EXPECT_EQ(error.cause(), TopologyCause::NotABox) << error.what();
    }
    // With a hole in the middle, the error names a face at the hole: of cell (0, 1, 1), since rows
    // are walked along axis 0 first.
    const CellComplex hollow = cellsOfGrid(
        n, [](Index i, Index j, Index k) { return i != 1 || j != 1 || k != 1; }, kSame);
    const TopologyError error = refusalOf(hollow);
    EXPECT_EQ(error.entity().dimension, 2);
    EXPECT_THAT(error.what(),
                HasSubstr("of cell 12 is on the boundary, but a box of 3 × 3 × 3 cells"));
    EXPECT_TRUE(contains(hollow.relation(3, 2)[12], error.entity().index));
}

// Cells that the walk from the corner does not reach: another box, or one row longer than the
// others.
TEST(BoxGrid, CellsOutsideTheBoxAreRefused) {
    std::vector<Loops> cells = cellLoops(test::grid({2, 1, 1}));
    for (auto loops : cellLoops(test::grid({1, 1, 1}))) {
        for (auto& loop : loops)
            for (Index& vertex : loop) vertex += 12;
        cells.push_back(loops);
    }
    const TopologyError two = refusalOf(test::lattice(20, cells));
    EXPECT_EQ(two.entity(), Entity(CellId(2)));
    EXPECT_THAT(
        two.what(),
        HasSubstr("cell 2 is not part of the box of 2 × 1 × 1 cells with its corner at vertex 0"));
    const CellComplex hook = cellsOfGrid(
        {2, 3, 1}, [](Index i, Index j, Index) { return i == 0 || j == 1; }, kSame);
    EXPECT_EQ(refusalOf(hook).cause(), TopologyCause::NotABox);
}

// A slit: in a grid of 2 × 2 cells, the two cells on the left share a face across the slit, and the
// two cells on the right do not. The vertices on the right of the slit are there twice.
TEST(BoxGrid, ASlitBetweenVerticesIsRefused) {
    const std::array<Index, 3> n = {2, 2, 1};
    const auto split = [](Index vertex, Index i, Index j, Index) {
        return i == 1 && j == 1 && (vertex == 5 || vertex == 14) ? vertex + 100 : vertex;
    };
    const TopologyError error = refusalOf(cellsOfGrid(n, kAll, split));
    EXPECT_EQ(error.entity().dimension, 0);
    EXPECT_THAT(error.what(), HasSubstr("would have the same place in the box, (2, 1, 0)"));
}

// Two cells have four vertices in common, but each has a separate face between them. Only files
// that list faces can describe this.
TEST(BoxGrid, ASlitBetweenFacesIsRefused) {
    const CellComplex box = test::grid({2, 2, 1});
    Rows<Signed> faces, cells;
    const auto copyRow = [](const SignedIncidence& from, Index row, Rows<Signed>& to) {
        for (std::size_t i = 0; i < from[row].size(); ++i)
            to.values.push_back({from[row][i], from.signs(row)[i]});
        to.offsets.push_back(Offset(to.values.size()));
    };
    // The slit is between cells 1 and 3. Between cells 0 and 2, which the walk crosses, it would be
    // found earlier.
    Index shared = 0;
    while (!contains(box.relation(2, 3)[shared], 1) || !contains(box.relation(2, 3)[shared], 3))
        ++shared;
    for (Index face = 0; face < box.count(2); ++face) copyRow(box.boundary(2), face, faces);
    copyRow(box.boundary(2), shared, faces);
    for (Index cell = 0; cell < box.count(3); ++cell) copyRow(box.boundary(3), cell, cells);
    for (std::size_t i = 0; i < 6; ++i) {
        Signed& side = cells.values[6 * 3 + i];
        if (side.index == shared) side.index = box.count(2);
    }
    const CellComplex slit(3, box.count(0),
                           {box.boundary(1), SignedIncidence(faces), SignedIncidence(cells)});
    validate(slit);
    const TopologyError error = refusalOf(slit);
    EXPECT_EQ(error.cause(), TopologyCause::NotABox);
    EXPECT_EQ(error.entity(), Entity(FaceId(shared)));
    EXPECT_THAT(error.what(), HasSubstr("is inside the box, but lies in one cell only"));
}

// A hexagonal prism, cut into three hexahedra around its axis. Along both axes from a corner there
// are two cells, but the second step leads to the third cell, which the other axis has already
// reached.
TEST(BoxGrid, CellReachedTwiceIsRefused) {
    ComplexBuilder builder(3, 14);
    for (const auto& [a, b, c] : {std::array{1, 2, 3}, {3, 4, 5}, {5, 6, 1}})
        builder.addCell(StandardCell::Hexahedron, {0, a, b, c, 7, a + 7, b + 7, c + 7});
    const TopologyError error = refusalOf(builder.build());
    EXPECT_EQ(error.entity().dimension, 0);
    EXPECT_THAT(error.what(), HasSubstr("would have two places in the box"));
}

}  // namespace
}  // namespace espalier::far
