// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/shapes/attach.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/merge.h>
#include <espalier/shapes/solids.h>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

/// Returns the outward normal of an axis-parallel boundary face of a box centred at `centre`.
Point3 outward(const Lattice& lattice, Index face, const Point3& centre) {
    Point3 mean = {0, 0, 0};
    for (const Index vertex : lattice.complex.relation(2, 0)[face])
        for (std::size_t axis = 0; axis < 3; ++axis) mean[axis] += at(lattice, vertex)[axis] / 4;
    const Point3 normal = minus(mean, centre);
    const double size = norm(normal);
    return {normal[0] / size, normal[1] / size, normal[2] / size};
}

TEST(Attach, GrowsACrossFromACube) {
    Lattice lattice = box();
    for (Index side = 0; side < 6; ++side) {
        const FaceId face = lattice.complex.faces(CellId(0))[side];
        lattice = attachPrism(lattice, face, outward(lattice, face.value, {0.5, 0.5, 0.5}));
    }
    // Each prism adds 4 vertices, 8 edges, 5 faces and a cell to the 8, 12, 6 and 1 of the cube.
    EXPECT_EQ(countsOf(lattice.complex), (Counts{32, 60, 36, 7}));
    EXPECT_EQ(lattice.complex.eulerCharacteristic(), 1);
    EXPECT_NEAR(totalVolume(lattice), 7, kRounding);
    expectValid(lattice);
}

TEST(Attach, BuildsAColumnPrismByPrism) {
    Lattice lattice = prism({5, 1, 1});
    for (int i = 0; i < 3; ++i) {
        // The second face of a prism is opposite to the face that it is attached to.
        const CellId last(lattice.complex.count(3) - 1);
        lattice = attachPrism(lattice, lattice.complex.faces(last)[1], {0, 0, 1});
    }
    const Lattice expected = cylinder({5, {1, Core::Polygon}, 4, 1, {0, 0, -0.5}, {0, 0, 3.5}});
    EXPECT_EQ(countsOf(lattice.complex), countsOf(expected.complex));
    EXPECT_EQ(lattice.complex.eulerCharacteristic(), 1);
    ASSERT_EQ(lattice.positions.size(), expected.positions.size());
    for (std::size_t v = 0; v < expected.positions.size(); ++v)
        EXPECT_NEAR(norm(minus(lattice.positions[v], expected.positions[v])), 0, kRounding);
    expectValid(lattice);
}

TEST(Attach, KeepsExistingNumbers) {
    const Lattice before = cylinder({6, {2}, 2});
    Index boundary = 0;
    while (before.complex.relation(2, 3)[boundary].size() != 1) ++boundary;
    const Lattice after = attachPyramid(before, FaceId(boundary), {0.3, 0.1, -1});
    EXPECT_EQ(after.complex.count(3), before.complex.count(3) + 1);
    for (int d = 1; d <= 3; ++d)
        for (Index index = 0; index < before.complex.count(d); ++index) {
            const auto rowA = before.complex.boundary(d)[index];
            const auto rowB = after.complex.boundary(d)[index];
            EXPECT_TRUE(std::equal(rowA.begin(), rowA.end(), rowB.begin(), rowB.end()));
        }
    EXPECT_EQ(at(after, before.complex.count(0)), (Point3{0.3, 0.1, -1}));
    expectValid(after);
}

TEST(Attach, AttachesPyramidsToAnyFace) {
    const Lattice start = prism({5, 1, 1});
    for (Index face = 0; face < 7; ++face) {
        const bool pentagon = face < 2;
        const Index n = pentagon ? 5 : 4;
        Point3 apex = {0, 0, face == 0 ? -2.0 : 2.0};
        if (!pentagon) {
            apex = {0, 0, 0};
            for (const Index vertex : start.complex.relation(2, 0)[face])
                for (std::size_t axis = 0; axis < 3; ++axis) apex[axis] += at(start, vertex)[axis];
        }
        const Lattice lattice = attachPyramid(start, FaceId(face), apex);
        EXPECT_EQ(countsOf(lattice.complex), (Counts{11, 15 + n, 7 + n, 2}));
        EXPECT_EQ(valenceInCell(lattice.complex, 1, 10), std::size_t(n));
        expectValid(lattice);
    }
}

TEST(Attach, AttachesAnyCell) {
    // A wedge on top of a cube, as a roof; its ridge has two new vertices.
    const NewVertex ridge[] = {{{0.5, 0, 2}, {4, 5}}, {{0.5, 1, 2}, {6, 7}}};
    const Lattice lattice =
        attachCell(box(), far::StandardCell::Wedge, std::array<Index, 6>{4, 8, 5, 6, 9, 7}, ridge);
    EXPECT_EQ(countsOf(lattice.complex), (Counts{10, 17, 10, 2}));
    EXPECT_NEAR(totalVolume(lattice), 1.5, kRounding);
    expectValid(lattice);
}

TEST(Attach, ClosesAGapWithoutNewVertices) {
    // Two boxes share an edge, and a wedge between them uses only existing vertices.
    const Lattice boxes = merge(box(), box({{1, 1, 1}, {1, 0, 1}, {2, 1, 2}}));
    EXPECT_EQ(at(boxes, 5), (Point3{1, 0, 1}));
    EXPECT_EQ(at(boxes, 7), (Point3{1, 1, 1}));
    EXPECT_EQ(at(boxes, 8), (Point3{2, 0, 1}));
    EXPECT_EQ(at(boxes, 9), (Point3{2, 1, 1}));
    const Lattice lattice =
        attachCell(boxes, far::StandardCell::Wedge, std::array<Index, 6>{1, 5, 8, 3, 7, 9}, {});
    EXPECT_EQ(lattice.complex.count(0), boxes.complex.count(0));
    EXPECT_NEAR(totalVolume(lattice), 2.5, kRounding);
    expectValid(lattice);
}

TEST(Attach, GivesNewVerticesTheAttributesOfTheirSources) {
    Lattice lattice = box();
    lattice.attributes.push_back({"x", 1, {}});
    for (const Point3& position : lattice.positions)
        lattice.attributes[0].values.push_back(position[0]);
    const FaceId top = lattice.complex.faces(CellId(0))[1];
    const Lattice onTop = attachPrism(lattice, top, {0, 0, 1});
    for (std::size_t v = 0; v < onTop.positions.size(); ++v)
        EXPECT_EQ(onTop.attributes[0].values[v], onTop.positions[v][0]);
    const Lattice pointed = attachPyramid(lattice, top, {0.5, 0.5, 2});
    EXPECT_EQ(pointed.attributes[0].values[8], 0.5);
}

TEST(Attach, DoesNotAverageIntegers) {
    Lattice lattice = box();
    lattice.integers.push_back({"material", 1, IntegerType::UInt8, {1, 2, 3, 4, 5, 6, 7, 8}});
    const FaceId top = lattice.complex.faces(CellId(0))[1];
    const Lattice onTop = attachPrism(lattice, top, {0, 0, 1});
    ASSERT_EQ(onTop.integers[0].values.size(), 12U);
    std::size_t copies = 0;
    for (std::size_t v = 8; v < 12; ++v)
        for (std::size_t below = 0; below < 8; ++below) {
            if (onTop.positions[v] != sum(onTop.positions[below], {0, 0, 1})) continue;
            EXPECT_EQ(onTop.integers[0].values[v], onTop.integers[0].values[below]);
            ++copies;
        }
    EXPECT_EQ(copies, 4U);
    const Lattice pointed = attachPyramid(lattice, top, {0.5, 0.5, 2});
    EXPECT_EQ(pointed.integers[0].values[8], 255);
    lattice.integers[0].values.pop_back();
    EXPECT_MESSAGE("attachPyramid: attribute 'material' of the lattice has 7 values; expected 8",
                   attachPyramid(lattice, top, {0.5, 0.5, 2}));
}

TEST(Attach, CarriesMarks) {
    Lattice lattice = box();
    lattice.marks.vertices.push_back({0, far::kSmooth});
    const Lattice grown = attachPrism(lattice, lattice.complex.faces(CellId(0))[1], {0, 0, 1});
    EXPECT_EQ(grown.marks, lattice.marks);
}

TEST(Attach, RefusesCellsThatDoNotFit) {
    const Lattice two = box({{2, 1, 1}});
    Index inner = 0;
    while (two.complex.relation(2, 3)[inner].size() != 2) ++inner;
    EXPECT_MESSAGE("attachPrism: face " + std::to_string(inner) +
                       " is between cells 0 and 1; expected a boundary face",
                   attachPrism(two, FaceId(inner), {0, 0, 1}));
    EXPECT_MESSAGE("attachPrism: face: expected face 0 to 10, got 11",
                   attachPrism(two, FaceId(11), {0, 0, 1}));
    const FaceId bottom = two.complex.faces(CellId(0))[0];
    for (const Point3& offset : {Point3{0, 0, 1}, Point3{1, 0, 0}})
        EXPECT_EQ(messageOf([&] { attachPrism(two, bottom, offset); }).substr(0, 29),
                  "attachPrism: offset: expected");
    EXPECT_MESSAGE(
        "attachPyramid: apex: expected a vector that points outwards from the face, so that the "
        "cell has a volume above 0, got (0.5, 0.5, 1)",
        attachPyramid(two, bottom, {0.5, 0.5, 1}));
    EXPECT_MESSAGE("attachPrism: the lattice is a mesh; expected a lattice",
                   attachPrism(gridMesh(), FaceId(0), {0, 0, 1}));
    const NewVertex unused[] = {{{9, 9, 9}, {}}};
    EXPECT_EQ(causeOf([&] {
                  attachCell(two, far::StandardCell::Tetrahedron, std::array<Index, 4>{0, 1, 3, 6},
                             unused);
              }),
              far::TopologyCause::UnusedEntity);
    const NewVertex lost[] = {{{9, 9, 9}, {12}}};
    EXPECT_MESSAGE(
        "attach: attributesFrom: expected vertex 0 to 11, got 12",
        attachCell(two, far::StandardCell::Tetrahedron, std::array<Index, 4>{0, 1, 3, 12}, lost));
    EXPECT_MESSAGE("attach: vertices: expected 6, got 4",
                   attachCell(two, far::StandardCell::Wedge, std::array<Index, 4>{0, 1, 3, 6}, {}));
}

}  // namespace
}  // namespace espalier::shapes
