// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/complex_builder.h>
#include <espalier/shapes/extrude.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/transform.h>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

Lattice boxFrom(double x, int cells, double length) {
    return box({{cells, 2, 1}, {x, 0, 0}, {x + length, 1, 1}});
}

/// Returns the cells of a lattice as sets of positions, to compare lattices without regard to
/// vertex numbers.
std::multiset<std::set<Point3>> cellsByPosition(const Lattice& lattice) {
    std::multiset<std::set<Point3>> cells;
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell) {
        std::set<Point3> positions;
        for (const Index vertex : lattice.complex.relation(3, 0)[cell])
            positions.insert(at(lattice, vertex));
        cells.insert(positions);
    }
    return cells;
}

TEST(Merge, MakesOneBoxOfTwo) {
    const Lattice left = boxFrom(0, 2, 2);
    const Lattice merged = merge(left, boxFrom(2, 3, 3));
    const Lattice whole = boxFrom(0, 5, 5);
    EXPECT_EQ(countsOf(merged.complex), countsOf(whole.complex));
    EXPECT_EQ(cellsByPosition(merged), cellsByPosition(whole));
    EXPECT_EQ(merged.complex.eulerCharacteristic(), 1);
    expectValid(merged);
    // Vertices and cells are in the order of first appearance, so the first box comes first.
    for (std::size_t v = 0; v < left.positions.size(); ++v)
        EXPECT_EQ(merged.positions[v], left.positions[v]);
    EXPECT_EQ(merged.complex.relation(3, 0)[3][0], left.complex.relation(3, 0)[3][0]);
}

TEST(Merge, WeldsVerticesThatDifferByRounding) {
    // The length of the boxes has no exact binary form: 5 · 0.1 + 0.1 is not 6 · 0.1.
    std::vector<Lattice> boxes;
    for (int i = 0; i < 11; ++i) boxes.push_back(boxFrom(i * 0.1, 1, 0.1));
    EXPECT_NE(boxes[5].positions[1], boxes[6].positions[0]);
    const Lattice merged = merge(boxes);
    EXPECT_EQ(countsOf(merged.complex), countsOf(boxFrom(0, 11, 1.1).complex));
    expectValid(merged);
}

TEST(Merge, ClosesARing) {
    std::vector<Lattice> quarters;
    const Lattice quarter = box({{2, 1, 1}, {-1, 1, 0}, {1, 2, 1}});
    for (int i = 0; i < 4; ++i) {
        Lattice turned = quarter;
        for (Point3& p : turned.positions) p[0] *= p[1];  // slant the sides by 45°
        quarters.push_back(transformed(turned, rotation({0, 0, 1}, i * 1.5707963267948966)));
    }
    const Lattice ring = merge(quarters);
    EXPECT_EQ(countsOf(ring.complex), sweptCounts(4, 4, 1, 8, true));
    EXPECT_EQ(ring.complex.eulerCharacteristic(), 0);
    expectValid(ring);
}

TEST(Merge, ObeysTheTolerance) {
    const Lattice left = boxFrom(0, 1, 1);
    Lattice right = boxFrom(1, 1, 1);
    for (Point3& position : right.positions) position[0] += 1e-7;
    EXPECT_EQ(merge(left, right).complex.count(0), 24);
    EXPECT_EQ(merge(left, right, {1e-6}).complex.count(0), 18);
    EXPECT_EQ(merge(left, boxFrom(1, 1, 1), {0}).complex.count(0), 18);
    EXPECT_MESSAGE(
        "merge: tolerance: expected a number from 0 to below 1, a fraction of the whole "
        "size, got -1",
        merge(left, right, {-1}));
}

TEST(Merge, KeepsSeparatePieces) {
    const Lattice apart = merge(boxFrom(0, 1, 1), boxFrom(5, 1, 1));
    EXPECT_EQ(apart.complex.eulerCharacteristic(), 2);
    expectValid(apart);
}

TEST(Merge, WeldsTheVerticesOfOneLattice) {
    const Lattice apart = merge(boxFrom(0, 1, 1), boxFrom(1.001, 1, 1));
    EXPECT_EQ(apart.complex.count(0), 24);
    EXPECT_EQ(merge(std::span(&apart, 1), {1e-2}).complex.count(0), 18);
}

using Groups = std::vector<std::size_t>;

TEST(MergeJoints, CountWeldedVerticesAndSharedFaces) {
    const Lattice parts[] = {boxFrom(0, 2, 2), boxFrom(2, 3, 3), boxFrom(5, 1, 1)};
    // boxFrom() has 2 · 1 faces of 3 · 2 vertices at each end.
    const MergeJoints joints = findJoints(parts, merge(parts));
    EXPECT_EQ(joints.weldedVertices, 2 * 6);
    EXPECT_EQ(joints.sharedFaces, 2 * 2);
    EXPECT_EQ(joints.groups, (Groups{0, 0, 0}));
}

TEST(MergeJoints, ShowPartsThatDoNotMatch) {
    // A side of 2 · 2 faces on a side of 3 · 3 faces: only the four corners coincide.
    const Lattice parts[] = {box({.cells = {2, 2, 2}}), box({{3, 3, 2}, {0, 0, 1}, {1, 1, 2}})};
    const MergeJoints joints = findJoints(parts, merge(parts));
    EXPECT_EQ(joints.weldedVertices, 4);
    EXPECT_EQ(joints.sharedFaces, 0);
    EXPECT_EQ(joints.groups, (Groups{0, 1}));
    const Lattice overlapping[] = {box(), box({{1, 1, 1}, {0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}})};
    EXPECT_EQ(findJoints(overlapping, merge(overlapping)).weldedVertices, 0);
}

TEST(MergeJoints, GroupLatticesThatAreJoinedThroughOthers) {
    // Lattices 0, 3 and 4 touch in a row, and so do 1 and 2. Lattice 4 comes last and joins 0 to 3.
    const Lattice parts[] = {boxFrom(0, 1, 1), boxFrom(10, 1, 1), boxFrom(11, 1, 1),
                             boxFrom(2, 1, 1), boxFrom(1, 1, 1)};
    EXPECT_EQ(findJoints(parts, merge(parts)).groups, (Groups{0, 1, 1, 0, 0}));
}

TEST(MergeJoints, CountSharedEdgesOfMeshes) {
    const Lattice parts[] = {gridMesh({{2, 2}, {0, 0}, {1, 1}}),
                             gridMesh({{2, 2}, {1, 0}, {2, 1}})};
    EXPECT_EQ(findJoints(parts, merge(parts)).sharedFaces, 2);
    // The faces inside one lattice are not shared with another one.
    EXPECT_EQ(findJoints(std::span(parts, 1), merge(std::span(parts, 1))).sharedFaces, 0);
}

TEST(Merge, JoinsMeshes) {
    const Lattice mesh =
        merge(gridMesh({{2, 2}, {0, 0}, {1, 1}}), gridMesh({{2, 2}, {1, 0}, {2, 1}}));
    EXPECT_EQ(countsOf(mesh.complex), (Counts{15, 22, 8, 0}));
    expectValid(extrude(mesh));
}

TEST(Merge, RefusesACellThatWouldCollapse) {
    const Lattice thin = box({{1, 1, 2}, {0, 0, 0}, {100, 1, 1e-6}});
    EXPECT_EQ(messageOf([&] { merge(box(), thin, {1e-6}); }).substr(0, 56),
              "vertices 0 and 4 of cell 0 of lattice 1 would become one");
    EXPECT_EQ(causeOf([&] { merge(box(), thin, {1e-6}); }), far::TopologyCause::RepeatedVertex);
}

TEST(Merge, RefusesDuplicateCellsAndFacesOfThreeCells) {
    EXPECT_EQ(causeOf([] { merge(box(), box()); }), far::TopologyCause::RepeatedCell);
    EXPECT_MESSAGE(
        "cell 0 of lattice 0, cell 0 of lattice 1 would become one cell; each cell may "
        "be in one lattice only",
        merge(box(), box()));
    // The cell is number 1 of its lattice, and number 2 of the result.
    const Lattice again[] = {boxFrom(5, 1, 1), merge(boxFrom(10, 1, 1), box()), box()};
    EXPECT_MESSAGE(
        "cell 2 of lattice 1, cell 0 of lattice 2 would become one cell; each cell may "
        "be in one lattice only",
        merge(again));
    // A third cell at the face x = 1. It is like the first box, but shorter.
    Lattice other = box();
    for (const Index vertex : {0, 2, 4, 6}) other.positions[vertex][0] = 0.5;
    const Lattice all[] = {box(), box({{1, 1, 1}, {1, 0, 0}, {2, 1, 1}}), other};
    EXPECT_EQ(causeOf([&] { merge(all); }), far::TopologyCause::CrowdedFace);
    // Names the face x = 1 of a lattice by its number there.
    const auto faceAtOne = [&](std::size_t number) {
        const Lattice& lattice = all[number];
        for (Index face = 0; face < lattice.complex.count(2); ++face) {
            const auto vertices = lattice.complex.relation(2, 0)[face];
            if (std::all_of(vertices.begin(), vertices.end(),
                            [&](Index vertex) { return lattice.positions[vertex][0] == 1; }))
                return "face " + std::to_string(face) + " of lattice " + std::to_string(number);
        }
        return std::string("none");
    };
    EXPECT_MESSAGE(faceAtOne(0) + ", " + faceAtOne(1) + ", " + faceAtOne(2) +
                       " would become one face of more than two cells",
                   merge(all));
    EXPECT_THAT(messageOf([&] {
                    merge(all, {.names = {"a.vtu", "b.vtu", "c.vtu"}});
                }),
                testing::MatchesRegex("face . of a.vtu, face . of b.vtu, face . of c.vtu "
                                      "would become one face of more than two cells"));
}

/// Adds a hexahedron between two squares; their corners correspond in order.
void addHexahedron(far::ComplexBuilder& builder, std::array<Index, 4> from,
                   std::array<Index, 4> to) {
    std::vector<Index> corners(from.begin(), from.end());
    corners.insert(corners.end(), to.begin(), to.end());
    builder.addCell(far::StandardCell::Hexahedron, corners);
}

TEST(Merge, ErrorsSayWhichNumbersBelongToTheResult) {
    // Three squares on a circle, and a cell from each to the next. The last cell is mirrored, so
    // the ring cannot be oriented.
    std::vector<Point3> positions;
    for (const double turn : {0.0, 2.0, 4.0})
        for (const auto& [r, z] :
             {std::pair(1, 0), std::pair(2, 0), std::pair(2, 1), std::pair(1, 1)})
            positions.push_back({r * std::cos(turn), r * std::sin(turn), double(z)});
    far::ComplexBuilder first(3, 12), last(3, 8);
    addHexahedron(first, {0, 1, 2, 3}, {4, 5, 6, 7});
    addHexahedron(first, {4, 5, 6, 7}, {8, 9, 10, 11});
    addHexahedron(last, {0, 1, 2, 3}, {5, 4, 7, 6});
    Lattice open, mirrored;
    open.complex = first.build();
    open.positions = positions;
    mirrored.complex = last.build();
    for (const std::size_t v : {8, 9, 10, 11, 0, 1, 2, 3})
        mirrored.positions.push_back(positions[v]);
    EXPECT_EQ(causeOf([&] { merge(open, mirrored); }), far::TopologyCause::NotOrientable);
    EXPECT_THAT(messageOf([&] { merge(open, mirrored); }),
                StartsWith("in the merged lattice, face "));
}

TEST(Merge, ErrorsNameTheLattices) {
    const MergeOptions named = {.tolerance = 1e-6, .names = {"a.vtu", "b.vtu"}};
    const Lattice thin = box({{1, 1, 2}, {0, 0, 0}, {100, 1, 1e-6}});
    EXPECT_THAT(messageOf([&] { merge(box(), thin, named); }),
                StartsWith("vertices 0 and 4 of cell 0 of b.vtu would become one"));
    EXPECT_MESSAGE(
        "cell 0 of a.vtu, cell 0 of b.vtu would become one cell; each cell may be in "
        "one lattice only",
        merge(box(), box(), named));
    Lattice lacking = boxFrom(1, 1, 1), left = boxFrom(0, 1, 1);
    left.attributes.push_back({"heat", 1, std::vector<double>(12)});
    EXPECT_MESSAGE("b.vtu lacks attribute 'heat', which a.vtu has", merge(left, lacking, named));
    EXPECT_MESSAGE("a.vtu lacks attribute 'heat', which b.vtu has", merge(lacking, left, named));
    lacking.attributes.push_back({"heat", 2, std::vector<double>(24)});
    EXPECT_MESSAGE("attribute 'heat' has 2 components in b.vtu, but 1 in a.vtu",
                   merge(left, lacking, named));
    EXPECT_MESSAGE("merge: b.vtu is a mesh; expected a lattice", merge(box(), gridMesh(), named));
    EXPECT_MESSAGE("got 1 names for 2 lattices", merge(left, lacking, {.names = {"a.vtu"}}));
}

TEST(Merge, RefusesEmptyListsAndMixedDimensions) {
    EXPECT_MESSAGE("there is no lattice; expected 1 or more", merge(std::span<const Lattice>{}));
    EXPECT_MESSAGE("merge: lattice 1 is a mesh; expected a lattice", merge(box(), gridMesh()));
}

TEST(Merge, CarriesMarks) {
    Lattice left = boxFrom(0, 1, 1);
    Lattice right = boxFrom(1, 1, 1);
    left.marks.edges.push_back({{0, 2}, far::kSmooth});
    left.marks.vertices.push_back({0, far::kSmooth});
    right.marks.edges.push_back({{0, 1}, far::kInfinitelySharp});
    right.marks.vertices.push_back({1, far::kInfinitelySharp});
    const Lattice merged = merge(left, right);
    // Vertex 0 of the right box is vertex 1 of the left box; vertex 1 is the first new vertex, 12.
    const far::Marks expected = {{{{0, 2}, far::kSmooth}, {{1, 12}, far::kInfinitelySharp}},
                                 {{0, far::kSmooth}, {12, far::kInfinitelySharp}}};
    EXPECT_EQ(merged.marks, expected);
    expectValid(merged);
}

/// Adds the attribute "uv", with the x and y of each vertex less `offset` as values.
void addAttribute(Lattice& lattice, double offset) {
    VertexAttribute uv = {"uv", 2, {}};
    for (const Point3& position : lattice.positions) {
        uv.values.push_back(position[0] - offset);
        uv.values.push_back(position[1] - offset);
    }
    lattice.attributes.push_back(uv);
}

TEST(Merge, CarriesAttributesByName) {
    Lattice left = boxFrom(0, 1, 1);
    Lattice right = boxFrom(1, 1, 1);
    addAttribute(left, 0);
    left.attributes.push_back({"heat", 1, std::vector<double>(12, 1.0)});
    right.attributes.push_back({"heat", 1, std::vector<double>(12, 2.0)});
    addAttribute(right, 10);
    const Lattice merged = merge(left, right);
    ASSERT_EQ(merged.attributes.size(), 2U);
    EXPECT_EQ(merged.attributes[0].name, "uv");
    EXPECT_EQ(merged.attributes[1].name, "heat");
    for (std::size_t v = 0; v < merged.positions.size(); ++v) {
        // Welded vertices have the values of the left box, which is the first that has them.
        const bool isLeft = v < 12;
        EXPECT_EQ(merged.attributes[1].values[v], isLeft ? 1 : 2);
        EXPECT_EQ(merged.attributes[0].values[2 * v + 1],
                  merged.positions[v][1] - (isLeft ? 0 : 10));
    }
}

TEST(Merge, RefusesAttributesThatDoNotMatch) {
    Lattice left = boxFrom(0, 1, 1);
    Lattice right = boxFrom(1, 1, 1);
    addAttribute(left, 0);
    EXPECT_MESSAGE("lattice 1 lacks attribute 'uv', which lattice 0 has", merge(left, right));
    EXPECT_MESSAGE("lattice 0 lacks attribute 'uv', which lattice 1 has", merge(right, left));
    right.attributes.push_back({"uv", 1, std::vector<double>(12)});
    EXPECT_MESSAGE("attribute 'uv' has 1 components in lattice 1, but 2 in lattice 0",
                   merge(left, right));
}

}  // namespace
}  // namespace espalier::shapes
