// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_refiner.h>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

/// Number of entities on each of the strata 0, 1, 2, 3.
using PerStratum = std::array<Index, 4>;
PerStratum countStrata(const Strata& strata, int dimension) {
    return {strata.count(dimension, 0), strata.count(dimension, 1), strata.count(dimension, 2),
            strata.count(dimension, 3)};
}

Strata strataOf(const CellComplex& complex, SharpEdges rule = SharpEdges::SingleCell,
                const Marks& marks = {}) {
    return TopologyRefiner(complex, {.sharpEdges = rule, .marks = marks}).level(0).strata;
}

/// Builds a prism of `layers` layers over a disk of n sectors: Figure 1 of the paper. In each of
/// the layers + 1 disks, vertex 0 is the centre and vertices 1 to n are the rim.
CellComplex cylinder(Index n, Index layers) {
    ComplexBuilder builder(3, (n + 1) * (layers + 1));
    for (Index layer = 0; layer < layers; ++layer)
        for (Index i = 0; i < n; ++i) {
            const Index low = layer * (n + 1), high = low + n + 1, next = (i + 1) % n;
            builder.addCell(StandardCell::Wedge, {low, low + 1 + next, low + 1 + i, high,
                                                  high + 1 + next, high + 1 + i});
        }
    return builder.build();
}

// MacCracken & Joy 1996, section 3, on boxes: 8 corners, and sharp edges along the 12 edges of the
// box.
TEST(Strata, BoxHasCornersSharpEdgesAndSides) {
    for (const SharpEdges rule : {SharpEdges::SingleCell, SharpEdges::Literal}) {
        const Strata strata = strataOf(grid({2, 3, 4}), rule);
        EXPECT_EQ(countStrata(strata, 0), (PerStratum{8, 4 * (1 + 2 + 3), 2 * (2 + 3 + 6), 6}));
        EXPECT_EQ(countStrata(strata, 1)[1], 4 * (2 + 3 + 4));
        EXPECT_EQ(countStrata(strata, 2)[2], 2 * (6 + 8 + 12));
        EXPECT_EQ(countStrata(strata, 3), (PerStratum{0, 0, 0, 24}));
    }
}

// Taken literally, the paper's rule makes the vertical edges of a cylinder of one layer sharp,
// which contradicts its Figure 5. The default rule does not, for any number of layers.
TEST(Strata, SharpEdgesOfACylinder) {
    const Index n = 6;
    for (const Index layers : {1, 2, 3}) {
        const Strata strata = strataOf(cylinder(n, layers));
        EXPECT_EQ(countStrata(strata, 1)[1], 2 * n) << "the two rims";
        EXPECT_EQ(countStrata(strata, 0)[0], 0) << "no corners";
        EXPECT_EQ(countStrata(strata, 0)[1], 2 * n);
    }
    EXPECT_EQ(countStrata(strataOf(cylinder(n, 1), SharpEdges::Literal), 1)[1], 3 * n);
    EXPECT_EQ(countStrata(strataOf(cylinder(n, 1), SharpEdges::Literal), 0)[0], 2 * n);
    EXPECT_EQ(countStrata(strataOf(cylinder(n, 2), SharpEdges::Literal), 1)[1], 2 * n);
}

TEST(Strata, ChildInheritsTheStratumOfItsUpperEnd) {
    TopologyRefiner refiner = test::refined(grid({1, 1, 1}), 2);
    // The refined cube is a box again: 8 corners, 12 edges of 4 parts, 6 sides of 16 faces.
    const Strata& strata = refiner.level(2).strata;
    EXPECT_EQ(countStrata(strata, 0), (PerStratum{8, 12 * 3, 6 * 9, 27}));
    EXPECT_EQ(countStrata(strata, 1)[1], 12 * 4);
    EXPECT_EQ(countStrata(strata, 2)[2], 6 * 16);
}

TEST(Strata, MarksOverrideTheAutomaticOnes) {
    const CellComplex box = grid({2, 2, 2});
    const Index corner = 0, onEdge = 1, end = 2;
    const auto strataWith = [&](const Marks& marks) {
        return strataOf(box, SharpEdges::SingleCell, marks);
    };
    // One edge is made smooth, and its corner too: the corner then has two sharp edges, and the
    // other end of the edge is a dart.
    const Strata smoothed =
        strataWith({.edges = {{{corner, onEdge}, kSmooth}}, .vertices = {{corner, kSmooth}}});
    EXPECT_EQ(smoothed.of({0, corner}), 1);
    EXPECT_EQ(smoothed.of({0, onEdge}), 2);
    EXPECT_EQ(smoothed.of({0, end}), 0);
    EXPECT_EQ(countStrata(smoothed, 1)[1], 23);
    // If only the edge is smooth, the corner is still the vertex of one cell.
    EXPECT_EQ(strataWith({.edges = {{{corner, onEdge}, kSmooth}}}).of({0, corner}), 0);
    // If only the corner is smooth, it still has three sharp edges.
    EXPECT_EQ(strataWith({.vertices = {{corner, kSmooth}}}).of({0, corner}), 0);
    // Vertices marked as corners: on a sharp edge, on a side, and inside.
    for (const Index vertex :
         {onEdge, gridVertex({2, 2, 2}, 1, 1, 0), gridVertex({2, 2, 2}, 1, 1, 1)})
        EXPECT_EQ(strataWith({.vertices = {{vertex, kInfinitelySharp}}}).of({0, vertex}), 0);
    // A sharp edge across a side, between the middles of two edges of the box, makes a crease
    // through the middle of the side. It is a third sharp edge at each of its ends.
    const Index middle = gridVertex({2, 2, 2}, 1, 1, 0), opposite = gridVertex({2, 2, 2}, 1, 2, 0);
    const Strata creased = strataWith(
        {.edges = {{{onEdge, middle}, kInfinitelySharp}, {{opposite, middle}, kInfinitelySharp}}});
    EXPECT_EQ(creased.of({0, middle}), 1);
    EXPECT_EQ(creased.of({0, onEdge}), 0);
    // 10 or more is infinite, as in OpenSubdiv; the later of two marks counts.
    EXPECT_EQ(strataWith({.vertices = {{middle, kSmooth}, {middle, 10}}}).of({0, middle}), 0);
}

TEST(Strata, OneSharpEdgeIsADart) {
    const Index middle = gridVertex({2, 2, 2}, 1, 1, 0);
    const Strata strata = strataOf(grid({2, 2, 2}), SharpEdges::SingleCell,
                                   {.edges = {{{1, middle}, kInfinitelySharp}}});
    EXPECT_EQ(strata.of({0, middle}), 2);
}

TEST(Strata, BadMarksAreRefused) {
    const CellComplex box = grid({2, 1, 1});
    const auto expectRefused = [&](TopologyCause cause, const std::string& text,
                                   const Marks& marks) {
        const auto error = topologyErrorOf([&] { strataOf(box, SharpEdges::SingleCell, marks); });
        EXPECT_EQ(error.cause(), cause) << error.what();
        EXPECT_THAT(error.what(), HasSubstr(text));
    };
    expectRefused(TopologyCause::BadMark, "edge (0, 2), which does not exist",
                  {.edges = {{{0, 2}, kSmooth}}});
    expectRefused(TopologyCause::BadMark, "edge (1, 1), which does not exist",
                  {.edges = {{{1, 1}, kSmooth}}});
    expectRefused(TopologyCause::VertexOutOfRange, "vertex 12; there are 12",
                  {.edges = {{{0, 12}, kSmooth}}});
    expectRefused(TopologyCause::VertexOutOfRange, "vertex -1", {.vertices = {{-1, kSmooth}}});
    expectRefused(TopologyCause::BadMark, "sharpness -2.5", {.edges = {{{0, 1}, -2.5}}});
    expectRefused(TopologyCause::BadMark, "sharpness nan", {.vertices = {{0, kNan}}});
}

/// Builds two cells of the 2 × 2 × 2 grid, which touch only in an edge or vertex at the grid's
/// middle.
CellComplex twoCubes(const std::array<Index, 3>& first, const std::array<Index, 3>& second) {
    std::map<Index, Index> names;
    ComplexBuilder builder(3);
    for (const auto& [i, j, k] : {first, second}) {
        auto cell = gridCell({2, 2, 2}, i, j, k);
        for (Index& vertex : cell) {
            if (!names.count(vertex)) names[vertex] = builder.addVertex();
            vertex = names[vertex];
        }
        builder.addCell(StandardCell::Hexahedron, cell);
    }
    return builder.build();
}

// A boundary edge in a number of boundary faces other than two is sharp, and a mark cannot make it
// smooth. A vertex whose boundary faces do not form one fan is a corner.
TEST(Strata, CubesThatTouchInAnEdgeOrAVertex) {
    const CellComplex byEdge = twoCubes({0, 0, 0}, {1, 1, 0});
    Index shared = 0;
    while (byEdge.relation(1, 3)[shared].size() != 2) ++shared;
    const Strata strata = strataOf(byEdge);
    EXPECT_EQ(strata.of({1, shared}), 1);
    for (const Index end : byEdge.relation(1, 0)[shared]) EXPECT_EQ(strata.of({0, end}), 0);
    const auto ends = byEdge.relation(1, 0)[shared];
    EXPECT_THROW(
        strataOf(byEdge, SharpEdges::SingleCell, {.edges = {{{ends[0], ends[1]}, kSmooth}}}),
        TopologyError);

    const CellComplex byVertex = twoCubes({0, 0, 0}, {1, 1, 1});
    Index touching = 0;
    while (byVertex.relation(0, 3)[touching].size() != 2) ++touching;
    EXPECT_EQ(strataOf(byVertex).of({0, touching}), 0);
    EXPECT_THROW(strataOf(byVertex, SharpEdges::SingleCell, {.vertices = {{touching, kSmooth}}}),
                 TopologyError);
}

// A tripod: four cells around a vertex from which three sharp edges leave.
TEST(Strata, ThreeSharpEdgesMakeACorner) {
    // The 2 × 2 × 2 grid without four of its cubes; (0,0,0), (1,0,0), (0,1,0) and (0,0,1) remain.
    // The middle vertex is on the boundary.
    ComplexBuilder builder(3, 27 - 7);
    std::map<Index, Index> names;
    for (const auto& [i, j, k] : {std::array<Index, 3>{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
        auto cell = gridCell({2, 2, 2}, i, j, k);
        for (Index& vertex : cell)
            vertex = names.emplace(vertex, Index(names.size())).first->second;
        builder.addCell(StandardCell::Hexahedron, cell);
    }
    const CellComplex tripod = builder.build();
    const Index middle = names[gridVertex({2, 2, 2}, 1, 1, 1)];
    // The edges from the middle to (2,1,1), (1,2,1) and (1,1,2) are in one cell each, so they are
    // sharp.
    EXPECT_EQ(tripod.relation(0, 3)[middle].size(), 4u);
    EXPECT_EQ(strataOf(tripod).of({0, middle}), 0);
}

TEST(Strata, MeshesAndCurves) {
    const Strata mesh = strataOf(gridMesh(3, 2));
    EXPECT_EQ(countStrata(mesh, 0), (PerStratum{4, 2 * 2 + 2 * 1, 2, 0}));
    EXPECT_EQ(countStrata(mesh, 1), (PerStratum{0, 10, 7, 0}));
    const Strata open = strataOf(buildCurve(5, false)), closed = strataOf(buildCurve(5, true));
    EXPECT_EQ(countStrata(open, 0), (PerStratum{2, 3, 0, 0}));
    EXPECT_EQ(countStrata(closed, 0), (PerStratum{0, 5, 0, 0}));
    EXPECT_THROW(
        strataOf(buildCurve(5, false), SharpEdges::SingleCell, {.vertices = {{0, kSmooth}}}),
        TopologyError);
    // Three faces at one edge, and two faces that touch in a vertex.
    const CellComplex fins = buildMesh(5, Loops{{0, 1, 2}, {0, 1, 3}, {1, 0, 4}});
    EXPECT_EQ(countStrata(strataOf(fins), 0)[0], 5);
    const CellComplex bowTie = buildMesh(5, Loops{{0, 1, 2}, {0, 3, 4}});
    EXPECT_EQ(strataOf(bowTie).of({0, 0}), 0);
}

// Marks on the refined complex reproduce the features that its base had by rule or by hand.
TEST(Strata, MarksForARefinedComplexReproduceItsStrata) {
    const Index middle = gridVertex({2, 2, 2}, 1, 1, 0);
    const auto expectKept = [](const CellComplex& base, SharpEdges rule, const Marks& marks) {
        TopologyRefiner refiner = test::refined(base, 2, {.sharpEdges = rule, .marks = marks});
        for (int level = 0; level <= 2; ++level) {
            const auto& [complex, strata, holes] = refiner.level(level);
            const Marks kept = marksFor(complex, strata, Boundary::Sharp);
            const Strata again = classify(complex, Boundary::Sharp, SharpEdges::SingleCell, kept);
            for (int d = 0; d <= base.dimension(); ++d)
                for (Index i = 0; i < complex.count(d); ++i)
                    ASSERT_EQ(again.of({d, i}), strata.of({d, i})) << level << " " << d << " " << i;
            if (rule == SharpEdges::SingleCell && marks.empty()) {
                EXPECT_TRUE(kept.empty());
            }
        }
    };
    expectKept(grid({2, 1, 3}), SharpEdges::SingleCell, {});
    expectKept(cylinder(5, 1), SharpEdges::Literal, {});
    expectKept(grid({2, 2, 2}), SharpEdges::SingleCell,
               {.edges = {{{0, 1}, kSmooth}, {{1, middle}, kInfinitelySharp}},
                .vertices = {{0, kSmooth}, {26, kInfinitelySharp}, {middle, kInfinitelySharp}}});
    expectKept(gridMesh(3, 2), SharpEdges::SingleCell,
               {.edges = {{{5, 6}, 1.5}}, .vertices = {{5, 0.5}}});
    // Semi-sharp marks on entities that are sharp by rule, and on entities that are not.
    expectKept(grid({2, 2, 2}), SharpEdges::SingleCell,
               {.edges = {{{0, 1}, 1.5}, {{1, middle}, 0.75}}, .vertices = {{0, 2}, {middle, 9}}});
    expectKept(buildCurve(5, false), SharpEdges::SingleCell, {.vertices = {{2, kInfinitelySharp}}});
}

// OpenSubdiv's boundary modes on a mesh of 3 × 2 faces, where vertices 0 and 3 are corners.
TEST(Strata, EdgeOnlyRoundsTheCornersOfAMesh) {
    const CellComplex mesh = gridMesh(3, 2);
    const auto strataIn = [&](Boundary boundary, const Marks& marks = {}) {
        return classify(mesh, boundary, SharpEdges::SingleCell, marks);
    };
    EXPECT_EQ(countStrata(strataIn(Boundary::EdgeOnly), 0), (PerStratum{0, 10, 2, 0}));
    EXPECT_EQ(strataIn(Boundary::EdgeOnly, {.vertices = {{0, 2.5}}}).of({0, 0}), 0);
    EXPECT_EQ(strataIn(Boundary::EdgeOnly, {.vertices = {{0, 2.5}}}).sharpness({0, 0}), 2.5F);
    // Under Boundary::Sharp a corner is infinitely sharp, whatever its mark says.
    EXPECT_EQ(strataIn(Boundary::Sharp, {.vertices = {{0, 2.5}}}).sharpness({0, 0}),
              kInfinitelySharp);
    EXPECT_THROW(strataIn(Boundary::Sharp, {.vertices = {{0, kSmooth}}}), TopologyError);
    // On a lattice, a vertex of one cell is rounded if its edges are smooth.
    const CellComplex cube = grid({1, 1, 1});
    Marks smooth;
    for (Index edge = 0; edge < cube.count(1); ++edge) {
        const auto ends = cube.relation(1, 0)[edge];
        smooth.edges.push_back({{ends[0], ends[1]}, kSmooth});
    }
    EXPECT_EQ(classify(cube, Boundary::EdgeOnly, SharpEdges::SingleCell, smooth).count(0, 2), 8);
    EXPECT_EQ(classify(cube, Boundary::Sharp, SharpEdges::SingleCell, smooth).count(0, 0), 8);
}

// A sharp edge from the middle of a box to the middle of a side does not make the latter a dart:
// the surface is refined as if it were a separate mesh.
TEST(Strata, SharpEdgesInsideALatticeDoNotAffectItsSurface) {
    const std::array<Index, 3> cells = {2, 2, 2};
    const Index middle = gridVertex(cells, 1, 1, 1), side = gridVertex(cells, 1, 1, 0);
    const Index opposite = gridVertex(cells, 1, 1, 2);
    const CellComplex box = grid(cells);
    const Strata strata = strataOf(box, SharpEdges::SingleCell,
                                   {.edges = {{{middle, side}, kInfinitelySharp},
                                              {{middle, opposite}, kInfinitelySharp},
                                              {{1, side}, kInfinitelySharp},
                                              {{side, 7}, kInfinitelySharp}}});
    EXPECT_EQ(strata.of({0, middle}), 1) << "two sharp edges inside";
    EXPECT_EQ(strata.of({0, opposite}), 2);
    EXPECT_EQ(strata.of({0, side}), 1) << "two on the surface; the third does not count";
    for (const Index edge : box.relation(0, 1)[opposite])
        EXPECT_EQ(strata.inSubcomplex({0, opposite}, 2, {1, edge}),
                  !contains(box.relation(1, 0)[edge], middle));
}

TEST(Strata, ChildrenOfHolesAreHoles) {
    TopologyRefiner refiner = test::refined(gridMesh(3, 2), 2, {.marks = {.holes = {4, 1, 4}}});
    EXPECT_EQ(refiner.level(0).holes, (std::vector<Index>{1, 4}));
    ASSERT_EQ(refiner.level(1).holes.size(), 8u);
    EXPECT_EQ(refiner.level(2).holes.size(), 32u);
    for (const Index hole : refiner.level(1).holes)
        EXPECT_THAT((std::vector<Index>{1, 4}),
                    Contains(refiner.refinement(1).parentOf({2, hole}).upper.index));
    EXPECT_THROW(TopologyRefiner(gridMesh(3, 2), {.marks = {.holes = {6}}}), TopologyError);
    EXPECT_THROW(TopologyRefiner(grid({1, 1, 1}), {.marks = {.holes = {0}}}), TopologyError);
}

TEST(Strata, OpenMarksTheBoundaryAsOpen) {
    const std::array<Index, 3> cells = {2, 2, 2};
    const Strata strata =
        TopologyRefiner(grid(cells), {.boundary = Boundary::Open}).level(0).strata;
    for (Index vertex = 0; vertex < 27; ++vertex)
        EXPECT_EQ(strata.isOpen({0, vertex}), vertex != gridVertex(cells, 1, 1, 1));
    EXPECT_EQ(countStrata(strata, 1), (PerStratum{0, 0, 48, 6}));
}

// An infinitely sharp boundary edge of a mesh remains without boundary control, as in OpenSubdiv's
// mode "none"; a semi-sharp one does not.
TEST(Strata, OpenKeepsBoundaryEdgesThatAreMarkedSharp) {
    const CellComplex mesh = gridMesh(4, 4);
    Marks marks;
    for (Index i = 0; i < 4; ++i) {
        marks.edges.push_back({{i, i + 1}, kInfinitelySharp});  // the first row
        marks.edges.push_back({{20 + i, 21 + i}, 9.5});         // the last row
    }
    TopologyRefiner refiner(mesh, {.boundary = Boundary::Open, .marks = marks});
    const Strata& strata = refiner.level(0).strata;
    for (const Index vertex : {1, 2, 3, 6, 12, 18}) EXPECT_FALSE(strata.isOpen({0, vertex}));
    for (const Index vertex : {0, 4, 5, 9, 20, 22, 24}) EXPECT_TRUE(strata.isOpen({0, vertex}));
    EXPECT_EQ(strata.of({0, 2}), 1);
    // Three vertices remain in each of rows 0 to 3, and with them 2 to 4 quarters of each face at
    // these vertices: (2 · 4 − 2) × (2 · 4 − 1) quadrilaterals.
    refiner.refineUniform(2);
    EXPECT_EQ(refiner.level(1).complex.count(2), 6 * 7);
    // The remaining edges keep their mark when the refined mesh is marked again.
    const auto& [refined, refinedStrata, holes] = refiner.level(1);
    const Marks kept = marksFor(refined, refinedStrata, Boundary::Open);
    const Strata again = classify(refined, Boundary::Open, SharpEdges::SingleCell, kept);
    for (int d = 0; d <= 2; ++d)
        for (Index i = 0; i < refined.count(d); ++i) {
            EXPECT_EQ(again.isOpen({d, i}), refinedStrata.isOpen({d, i}));
            if (!again.isOpen({d, i})) {
                EXPECT_EQ(again.of({d, i}), refinedStrata.of({d, i}));
            }
        }
}

}  // namespace
}  // namespace espalier::far
