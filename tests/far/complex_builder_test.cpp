// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_match.h>

#include <map>
#include <optional>
#include <set>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

struct Counts {
    Index vertices, edges, faces, cells;
    friend bool operator==(const Counts&, const Counts&) = default;
};
Counts countsOf(const CellComplex& c) {
    return {c.count(0), c.count(1), c.count(2), c.count(3)};
}

TEST(ComplexBuilder, StandardCellsHaveTheirCounts) {
    EXPECT_EQ(countsOf(singleCell(StandardCell::Tetrahedron)), (Counts{4, 6, 4, 1}));
    EXPECT_EQ(countsOf(singleCell(StandardCell::Pyramid)), (Counts{5, 8, 5, 1}));
    EXPECT_EQ(countsOf(singleCell(StandardCell::Wedge)), (Counts{6, 9, 5, 1}));
    EXPECT_EQ(countsOf(singleCell(StandardCell::Hexahedron)), (Counts{8, 12, 6, 1}));
}

// (i+1)(j+1)(k+1) vertices; i(j+1)(k+1) edges along x, and so on; (i+1)jk faces across x, and so
// on.
TEST(ComplexBuilder, GridSharesFacesAndEdges) {
    EXPECT_EQ(countsOf(grid({2, 3, 4})), (Counts{3 * 4 * 5, 2 * 4 * 5 + 3 * 3 * 5 + 3 * 4 * 4,
                                                 3 * 3 * 4 + 2 * 4 * 4 + 2 * 3 * 5, 2 * 3 * 4}));
}

// Any direction and starting point of each loop gives the same faces and a coherent orientation.
TEST(ComplexBuilder, LoopStartsAndDirectionsDoNotMatter) {
    const CellComplex original = grid({2, 2, 2});
    std::vector<Index> names(27);
    for (Index i = 0; i < 27; ++i) names[i] = i;
    for (unsigned seed = 0; seed < 20; ++seed) {
        const CellComplex shuffled = relabelled(original, names, seed);
        EXPECT_EQ(countsOf(shuffled), countsOf(original));
        // validate() ran in build(): ∂∂ = 0 and opposite signs at shared faces.
        for (Index face = 0; face < shuffled.count(2); ++face)
            EXPECT_LE(shuffled.relation(2, 3)[face].size(), 2u);
    }
}

/// Returns the vertices of a loop in an order that is the same for all ways of writing one face.
std::vector<Index> canonical(std::vector<Index> loop) {
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    if (loop[1] > loop.back()) std::reverse(loop.begin() + 1, loop.end());
    return loop;
}

// The slow reference: maps from the vertices of faces and edges to their numbers.
TEST(ComplexBuilder, NumbersEntitiesInTheOrderOfTheirFirstAppearance) {
    for (const CellComplex& original : {mixedCells(), grid({3, 2, 4}), bipyramid(9)})
        for (unsigned seed = 0; seed < 20; ++seed) {
            const auto names = shuffledIndices(original.count(0), seed);
            const auto cells = cellLoops(relabelled(original, names, seed));
            const CellComplex built = lattice(original.count(0), cells);
            std::map<std::vector<Index>, Index> faces;
            std::map<std::array<Index, 2>, Index> edges;
            for (std::size_t cell = 0; cell < cells.size(); ++cell)
                for (std::size_t f = 0; f < cells[cell].size(); ++f) {
                    const auto& loop = cells[cell][f];
                    const auto [at, isNewFace] =
                        faces.try_emplace(canonical(loop), Index(faces.size()));
                    const Index face = at->second;
                    EXPECT_EQ(built.relation(3, 2)[Index(cell)][f], face);
                    if (isNewFace) {
                        const auto vertices = built.relation(2, 0)[face];
                        EXPECT_EQ(std::vector<Index>(vertices.begin(), vertices.end()), loop);
                    }
                    for (std::size_t i = 0; i < loop.size(); ++i) {
                        const Index a = loop[i], b = loop[(i + 1) % loop.size()];
                        const auto [edge, isNewEdge] = edges.try_emplace(
                            {std::min(a, b), std::max(a, b)}, Index(edges.size()));
                        const auto ends = built.relation(1, 0)[edge->second];
                        if (isNewEdge) {
                            EXPECT_EQ(ends[0], a);
                        }
                        EXPECT_EQ(ends[0] + ends[1], a + b);
                        if (isNewFace) {
                            EXPECT_EQ(built.relation(2, 1)[face][i], edge->second);
                        }
                    }
                }
            EXPECT_EQ(built.count(2), Index(faces.size()));
            EXPECT_EQ(built.count(1), Index(edges.size()));
        }
}

// A cell directed inwards among cells directed outwards is reversed: the majority decides.
TEST(ComplexBuilder, MajorityOfLoopsDecidesTheOutside) {
    ComplexBuilder builder(3, 12);
    const auto first = gridCell({2, 1, 1}, 0, 0, 0), second = gridCell({2, 1, 1}, 1, 0, 0);
    builder.addCell(StandardCell::Hexahedron, first);
    Loops loops = faceLoops(StandardCell::Hexahedron);
    for (std::size_t f = 0; f < loops.size(); ++f) {
        for (Index& vertex : loops[f]) vertex = second[vertex];
        if (f < 5) std::reverse(loops[f].begin(), loops[f].end());
    }
    builder.addCell(loops);
    // 6 + 1 loops agree, and 5 are opposite.
    const auto oriented = cellLoops(builder.build());
    const auto expected = cellLoops(grid({2, 1, 1}));
    const auto contains = [](const Loops& all, std::vector<Index> loop) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            std::rotate(loop.begin(), loop.begin() + 1, loop.end());
            if (std::find(all.begin(), all.end(), loop) != all.end()) return true;
        }
        return false;
    };
    for (std::size_t cell = 0; cell < 2; ++cell)
        for (const auto& loop : expected[cell]) EXPECT_TRUE(contains(oriented[cell], loop));
}

TEST(ComplexBuilder, RelationsOfAHexahedron) {
    const CellComplex cube = singleCell(StandardCell::Hexahedron);
    EXPECT_THAT(cube.relation(3, 0)[0], ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
    EXPECT_THAT(cube.relation(2, 0)[0], ElementsAre(0, 4, 7, 3));  // loop order
    EXPECT_EQ(cube.relation(0, 1)[0].size(), 3u);
    EXPECT_EQ(cube.relation(0, 2)[0].size(), 3u);
    EXPECT_EQ(cube.relation(1, 2)[0].size(), 2u);
    EXPECT_THAT(cube.relation(0, 3)[6], ElementsAre(0));
    EXPECT_EQ(cube.eulerCharacteristic(), 1);
}

TEST(ComplexBuilder, SeparatePiecesAreAllowed) {
    ComplexBuilder builder(3, 16);
    builder.addCell(StandardCell::Hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
    builder.addCell(StandardCell::Hexahedron, {8, 9, 10, 11, 12, 13, 14, 15});
    EXPECT_EQ(builder.build().eulerCharacteristic(), 2);
}

TEST(ComplexBuilder, CurvesAndMeshes) {
    const CellComplex closed = buildCurve(5, true), open = buildCurve(5, false);
    EXPECT_EQ(closed.count(1), 5);
    EXPECT_EQ(open.count(1), 4);
    const CellComplex mesh = gridMesh(3, 2);
    EXPECT_EQ(mesh.count(0), 12);
    EXPECT_EQ(mesh.count(1), 3 * 3 + 4 * 2);
    EXPECT_EQ(mesh.count(2), 6);
    // Two quadrilaterals back to back are two faces.
    EXPECT_EQ(buildMesh(4, Loops{{0, 1, 2, 3}, {3, 2, 1, 0}}).count(2), 2);
}

template <class Call>
void expectRefused(TopologyCause cause, Entity entity, const std::string& text, Call call) {
    const TopologyError error = topologyErrorOf(call);
    EXPECT_EQ(error.cause(), cause) << error.what();
    EXPECT_EQ(error.entity(), entity) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(text));
}

/// Returns the loops of a hexahedron on vertices 0 to 7.
Loops cube() {
    return faceLoops(StandardCell::Hexahedron);
}

Loops shifted(Loops loops, Index by) {
    for (auto& loop : loops)
        for (Index& vertex : loop) vertex += by;
    return loops;
}

TEST(ComplexBuilderRefuses, OpenCell) {
    Loops open = cube();
    open.pop_back();
    expectRefused(TopologyCause::OpenCell, {3, 0}, "edge (4, 7)", [&] { lattice(8, {open}); });
}

TEST(ComplexBuilderRefuses, EdgeWithThreeFacesOfOneCell) {
    // A wall across the diagonal of the cube: its four edges have three faces each.
    Loops walled = cube();
    walled.push_back({0, 2, 6, 4});
    expectRefused(TopologyCause::CrowdedEdge, {3, 0}, "3 faces", [&] { lattice(8, {walled}); });
}

TEST(ComplexBuilderRefuses, FaceOfThreeCells) {
    // Three pyramids on the same quadrilateral.
    ComplexBuilder builder(3, 7);
    for (const Index apex : {4, 5, 6}) builder.addCell(StandardCell::Pyramid, {0, 1, 2, 3, apex});
    expectRefused(TopologyCause::CrowdedFace, {2, 0}, "3 cells (0, 1, 2)",
                  [&] { builder.build(); });
}

TEST(ComplexBuilderRefuses, BadLoops) {
    ComplexBuilder builder(3, 8);
    expectRefused(TopologyCause::RepeatedVertex, {3, 0}, "(0, 1, 1) names vertex 1 twice", [&] {
        builder.addCell(Loops{{0, 1, 1}});
    });
    expectRefused(TopologyCause::TooFewVertices, {3, 0}, "(0, 1) has fewer than 3", [&] {
        builder.addCell(Loops{{0, 1}});
    });
    expectRefused(TopologyCause::VertexOutOfRange, {3, 0}, "vertex 8; there are 8", [&] {
        builder.addCell(Loops{{0, 1, 8}});
    });
    expectRefused(TopologyCause::VertexOutOfRange, {3, 0}, "vertex -1", [&] {
        builder.addCell(Loops{{0, 1, -1}});
    });
    expectRefused(TopologyCause::TooFewVertices, {3, 0}, "7 vertices; expected 8", [&] {
        builder.addCell(StandardCell::Hexahedron, {0, 1, 2, 3, 4, 5, 6});
    });
    // The builder kept nothing of the refused cells.
    builder.addCell(StandardCell::Hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
    EXPECT_EQ(builder.build().count(3), 1);
}

TEST(ComplexBuilderRefuses, CellInTwoPieces) {
    // Two tetrahedra that share vertex 0, taken as one cell: no edge joins their surfaces.
    Loops pieces = faceLoops(StandardCell::Tetrahedron);
    for (auto loop : faceLoops(StandardCell::Tetrahedron)) {
        for (Index& vertex : loop)
            if (vertex != 0) vertex += 3;
        pieces.push_back(loop);
    }
    expectRefused(TopologyCause::NotASphere, {3, 0}, "2 pieces", [&] { lattice(7, {pieces}); });
}

TEST(ComplexBuilderRefuses, CellWithTwoFansAtAVertex) {
    // A prism over the hexagon 0 to 5, bent so that the top vertex above 3 coincides with
    // vertex 0.
    const std::vector<Index> bottom = {0, 1, 2, 3, 4, 5}, top = {6, 7, 8, 0, 9, 10};
    Loops prism = {{bottom.rbegin(), bottom.rend()}, top};
    for (std::size_t i = 0; i < 6; ++i) {
        const std::size_t next = (i + 1) % 6;
        prism.push_back({bottom[i], bottom[next], top[next], top[i]});
    }
    expectRefused(TopologyCause::PinchedCell, {3, 0}, "vertex 0 form more than one fan",
                  [&] { lattice(11, {prism}); });
}

TEST(ComplexBuilderRefuses, CellWithAHandle) {
    // The surface of a square ring of 8 cubes: a torus of 32 quadrilaterals, as one cell.
    const std::array<Index, 3> n = {3, 3, 1};
    ComplexBuilder ring(3, 32);
    for (Index j = 0; j < 3; ++j)
        for (Index i = 0; i < 3; ++i)
            if (i != 1 || j != 1) ring.addCell(StandardCell::Hexahedron, gridCell(n, i, j, 0));
    const CellComplex cubes = ring.build();
    Loops surface;
    for (Index face = 0; face < cubes.count(2); ++face)
        if (cubes.relation(2, 3)[face].size() == 1) {
            const auto loop = cubes.relation(2, 0)[face];
            surface.emplace_back(loop.begin(), loop.end());
        }
    ASSERT_EQ(surface.size(), 32u);
    expectRefused(TopologyCause::NotASphere, {3, 0}, "Euler characteristic is 0; expected 2",
                  [&] { lattice(32, {surface}); });
}

// The Euler characteristics of a sphere and a torus have the sum 2, as for one sphere.
TEST(ComplexBuilderRefuses, CellOfASphereAndATorus) {
    Loops loops = faceLoops(StandardCell::Tetrahedron);
    for (Index i = 0; i < 3; ++i) {  // The torus is a ring of three boxes.
        const Index a = 4 + 4 * i, b = 4 + 4 * ((i + 1) % 3);
        for (Index side = 0; side < 4; ++side) {
            const Index next = (side + 1) % 4;
            loops.push_back({a + side, a + next, b + next, b + side});
        }
    }
    expectRefused(TopologyCause::NotASphere, {3, 0}, "a surface of 2 pieces",
                  [&] { lattice(16, {loops}); });
}

TEST(ComplexBuilderRefuses, PartsOfAnotherDimension) {
    ComplexBuilder mesh(2, 8), solid(3, 8), curve(1, 8);
    expectRefused(TopologyCause::WrongDimension, {3, 0}, "dimension 2 is made of faces; got a cell",
                  [&] { mesh.addCell(cube()); });
    expectRefused(TopologyCause::WrongDimension, {2, 0}, "dimension 3 is made of cells; got a face",
                  [&] {
                      solid.addFace({0, 1, 2});
                  });
    expectRefused(TopologyCause::WrongDimension, {1, 0}, "got an edge",
                  [&] { solid.addEdge(0, 1); });
    expectRefused(TopologyCause::WrongDimension, {2, 0}, "dimension 1 is made of edges", [&] {
        curve.addFace({0, 1, 2});
    });
}

// validate() works on complexes of any origin, including those made from relations.
TEST(ComplexBuilderRefuses, RelationsToMissingEntities) {
    const CellComplex good = singleCell(StandardCell::Tetrahedron);
    const auto damaged = [&](int dimension, Index row, Index index) {
        CellComplex::Boundaries boundaries = {good.boundary(1), good.boundary(2), good.boundary(3)};
        Rows<Signed> rows;
        for (Index r = 0; r < good.count(dimension); ++r) {
            for (std::size_t i = 0; i < good.boundary(dimension)[r].size(); ++i)
                rows.values.push_back({r == row && i == 1 ? index : good.boundary(dimension)[r][i],
                                       good.boundary(dimension).signs(r)[i]});
            rows.offsets.push_back(Offset(rows.values.size()));
        }
        boundaries[std::size_t(dimension) - 1] = SignedIncidence(rows);
        return CellComplex(3, 4, boundaries);
    };
    expectRefused(TopologyCause::VertexOutOfRange, {1, 2}, "edge 2 names vertex 4; there are 4",
                  [&] { validate(damaged(1, 2, 4)); });
    expectRefused(TopologyCause::EntityOutOfRange, {2, 3}, "face 3 names edge -1; there are 6",
                  [&] { validate(damaged(2, 3, -1)); });
    expectRefused(TopologyCause::EntityOutOfRange, {3, 0}, "cell 0 names face 4; there are 4",
                  [&] { validate(damaged(3, 0, 4)); });
    expectRefused(TopologyCause::NotOrientable, {2, 0}, "do not form a loop",
                  [&] { validate(damaged(2, 0, 5)); });
}

// Found by fuzzing: edges with two heads passed as a loop, but their children did not form one.
TEST(ComplexBuilderRefuses, EdgesWithTwoHeads) {
    CellComplex::Boundaries boundaries;
    boundaries[0] = SignedIncidence(
        Rows<Signed>{{0, 2, 4, 6}, {{0, -1}, {1, 1}, {1, -1}, {2, 1}, {2, 1}, {0, 1}}});
    boundaries[1] = SignedIncidence(Rows<Signed>{{0, 3}, {{0, 1}, {1, 1}, {2, 1}}});
    expectRefused(TopologyCause::NotOrientable, {1, 2},
                  "does not run from its first vertex to its second",
                  [&] { validate(CellComplex(2, 3, boundaries)); });
}

TEST(ComplexBuilder, DropsUnusedVertices) {
    ComplexBuilder builder(3, 7);
    builder.addCell(StandardCell::Tetrahedron, {6, 1, 4, 2});
    EXPECT_EQ(builder.dropUnusedVertices(), (std::vector<Index>{0, 3, 5}));
    EXPECT_TRUE(builder.dropUnusedVertices().empty());
    // Vertices 6, 1, 4 and 2 become 3, 0, 2 and 1.
    ComplexBuilder expected(3, 4);
    expected.addCell(StandardCell::Tetrahedron, {3, 0, 2, 1});
    EXPECT_EQ(topologyDifference(builder.build(), expected.build()), std::nullopt);
    // A vertex that is added later is a new one.
    EXPECT_EQ(builder.addVertex(), 4);
    EXPECT_EQ(builder.dropUnusedVertices(), (std::vector<Index>{4}));

    ComplexBuilder empty(3, 2);
    EXPECT_EQ(empty.dropUnusedVertices(), (std::vector<Index>{0, 1}));
}

TEST(ComplexBuilderRefuses, UnusedVertexAndEmptyComplexes) {
    expectRefused(TopologyCause::UnusedEntity, {0, 8}, "vertex 8 belongs to no edge",
                  [&] { lattice(9, {cube()}); });
    expectRefused(TopologyCause::EmptyComplex, {3, 0}, "no cell", [] { lattice(0, {}); });
    expectRefused(TopologyCause::EmptyComplex, {3, 0}, "no cell", [] { lattice(4, {}); });
    expectRefused(TopologyCause::EmptyComplex, {2, 0}, "no face", [] { buildMesh(4, {}); });
    expectRefused(TopologyCause::EmptyComplex, {1, 0}, "no edge", [] { buildCurve(1, false); });
    expectRefused(TopologyCause::NotASphere, {3, 1}, "0 pieces", [] { lattice(8, {cube(), {}}); });
}

TEST(ComplexBuilderRefuses, RepeatedCellsAndFaces) {
    expectRefused(TopologyCause::RepeatedCell, {3, 1}, "cell 1 has the same faces as cell 0", [] {
        lattice(8, {cube(), cube()});
    });
    Loops twice = cube();
    twice.push_back(twice.front());
    expectRefused(TopologyCause::RepeatedFace, {3, 0}, "lists face 0 twice",
                  [&] { lattice(8, {twice}); });
}

// Three cubes in a row whose ends are glued with a reflection: a solid Klein bottle.
TEST(ComplexBuilderRefuses, LatticeThatCannotBeOriented) {
    const auto slice = [](Index i) {
        // Four vertices per slice; slice 3 is slice 0 mirrored.
        return i < 3 ? std::array<Index, 4>{4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3}
                     : std::array<Index, 4>{1, 0, 3, 2};
    };
    ComplexBuilder builder(3, 12);
    for (Index i = 0; i < 3; ++i) {
        const auto a = slice(i), b = slice(i + 1);
        builder.addCell(StandardCell::Hexahedron, {a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]});
    }
    EXPECT_EQ(causeOf([&] { builder.build(); }), TopologyCause::NotOrientable);
}

/// Returns tetrahedra whose edges from a to a + d all have one bucket in the builder's hash table:
/// it computes a + d · 0x9E3779B97F4A7C15. The first tetrahedra use all vertices.
std::vector<std::array<Index, 4>> collidingCells(Index vertexCount) {
    std::vector<std::array<Index, 4>> cells;
    for (Index vertex = 0; vertex + 3 < vertexCount; vertex += 4)
        cells.push_back({vertex, vertex + 1, vertex + 2, vertex + 3});
    const auto mask = static_cast<std::uint64_t>(vertexCount);
    for (Index d = 5; d < vertexCount / 2; ++d) {
        const auto a = static_cast<Index>((777 - d * 0x9E3779B97F4A7C15) & mask);
        if (a + d + 3 < vertexCount) cells.push_back({a, a + d, a + d + 1, a + d + 3});
    }
    cells.push_back({vertexCount - 4, vertexCount - 3, vertexCount - 2, vertexCount - 1});
    return cells;
}

TEST(ComplexBuilder, CellsMayBeChosenSoThatTheyCollide) {
    constexpr Index kVertices = 4095;
    ComplexBuilder builder(3, kVertices);
    std::set<std::vector<Index>> edges, faces;
    const auto cells = collidingCells(kVertices);
    for (const auto& cell : cells) {
        builder.addCell(StandardCell::Tetrahedron, cell);
        for (int i = 0; i < 4; ++i) {
            std::vector<Index> face;
            for (int j = 0; j < 4; ++j) {
                if (j != i) face.push_back(cell[j]);
                if (j < i) edges.insert({cell[j], cell[i]});
            }
            faces.insert(face);
        }
    }
    ASSERT_GT(cells.size(), 2000u);
    EXPECT_EQ(countsOf(builder.build()),
              (Counts{kVertices, static_cast<Index>(edges.size()), static_cast<Index>(faces.size()),
                      static_cast<Index>(cells.size())}));
}

TEST(ComplexBuilder, CubesThatMeetInAnEdgeOrAVertexOnlyAreAllowed) {
    const std::array<Index, 3> n = {2, 2, 1};
    ComplexBuilder edge(3, 18 - 4);
    std::vector<Index> names(18, -1);
    Index next = 0;
    const auto rename = [&](std::array<Index, 8> cell) {
        for (Index& vertex : cell) {
            Index& name = names[vertex];
            if (name < 0) name = next++;
            vertex = name;
        }
        return cell;
    };
    edge.addCell(StandardCell::Hexahedron, rename(gridCell(n, 0, 0, 0)));
    edge.addCell(StandardCell::Hexahedron, rename(gridCell(n, 1, 1, 0)));
    EXPECT_EQ(countsOf(edge.build()), (Counts{14, 23, 12, 2}));
    Loops second = shifted(cube(), 7);  // shares vertex 7 with the first
    EXPECT_EQ(countsOf(lattice(15, {cube(), second})), (Counts{15, 24, 12, 2}));
}

}  // namespace
}  // namespace espalier::far
