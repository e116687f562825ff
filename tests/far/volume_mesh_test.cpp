// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/volume_mesh.h>

#include "support/complexes.h"
#include "support/test.h"
#include "support/volume_meshes.h"

namespace espalier::far {
namespace {

using Loop = std::vector<Index>;

Loop canonicalLoop(std::span<const Index> loop) {
    Loop result(loop.begin(), loop.end());
    std::rotate(result.begin(), std::min_element(result.begin(), result.end()), result.end());
    return result;
}

/// Returns the faces of a cell as loops that are anticlockwise seen from outside, from their
/// smallest points, sorted.
std::set<Loop> outwardFaces(const VolumeMesh& mesh, Index cell) {
    std::set<Loop> loops;
    for (const Index face : mesh.faces(cell)) {
        Loop loop(mesh.face(face).begin(), mesh.face(face).end());
        if (mesh.owner(face) != cell) {
            EXPECT_EQ(mesh.neighbour(face), cell);
            std::reverse(loop.begin(), loop.end());
        }
        loops.insert(canonicalLoop(loop));
    }
    return loops;
}

std::set<Loop> outwardFaces(const CellComplex& complex, Index cell) {
    std::set<Loop> loops;
    for (const Loop& loop : outwardLoops(complex, CellId(cell))) loops.insert(canonicalLoop(loop));
    return loops;
}

std::vector<CellComplex> complexes() {
    return {grid({2, 3, 2}),
            mixedCells(),
            bipyramid(5),
            singleCell(StandardCell::Tetrahedron),
            singleCell(StandardCell::Wedge),
            lattice(12, {bipyramidLoops(3), bipyramidLoops(10)})};
}

// A CellComplex, whose faces are found by sorting all loops, is the reference.
TEST(VolumeMesh, HasTheFacesOfTheComplexOfItsCells) {
    for (const CellComplex& complex : complexes())
        for (const VolumeMesh& mesh :
             {volumeMeshOf(complex), volumeMeshOf(complex, true), meshOfFaces(complex)}) {
            EXPECT_EQ(mesh.pointCount(), complex.count(0));
            ASSERT_EQ(mesh.cellCount(), complex.count(3));
            ASSERT_EQ(mesh.faceCount(), complex.count(2));
            Index internal = 0;
            for (Index face = 0; face < complex.count(2); ++face)
                internal += complex.relation(2, 3)[face].size() == 2 ? 1 : 0;
            EXPECT_EQ(mesh.internalFaceCount(), internal);
            for (Index cell = 0; cell < complex.count(3); ++cell)
                EXPECT_EQ(outwardFaces(mesh, cell), outwardFaces(complex, cell));
            for (Index face = 0; face < internal; ++face)
                EXPECT_LT(mesh.owner(face), mesh.neighbour(face));
        }
}

TEST(VolumeMesh, RecognisesStandardCellsByTheirFaces) {
    for (const CellComplex& complex : complexes()) {
        const VolumeMesh mesh = meshOfFaces(complex);
        for (Index cell = 0; cell < complex.count(3); ++cell) {
            const auto standard = asStandardCell(complex, CellId(cell));
            ASSERT_EQ(mesh.kind(cell), standard ? std::optional(standard->kind) : std::nullopt);
            if (!standard) continue;
            // The corners may begin elsewhere, but their faces are those of the cell.
            std::set<Loop> loops;
            for (Loop loop : faceLoops(standard->kind)) {
                for (Index& point : loop) point = mesh.corners(cell)[point];
                loops.insert(canonicalLoop(loop));
            }
            EXPECT_EQ(loops, outwardFaces(complex, cell));
        }
    }
}

// Five faces, two of them triangles, that are no wedge; a cell of six quadrilaterals that is open.
TEST(VolumeMesh, CellsThatOnlyHaveTheFaceCountsOfAStandardCellArePolyhedra) {
    const auto meshOf = [](Index points, const std::vector<Loop>& loops) {
        Rows<Index> faces;
        for (const Loop& loop : loops) {
            faces.values.insert(faces.values.end(), loop.begin(), loop.end());
            faces.offsets.push_back(Offset(faces.values.size()));
        }
        return VolumeMesh(points, 1, faces, std::vector<Index>(loops.size(), 0), {});
    };
    // A quadrilateral whose edges fold to triangles with two points above.
    EXPECT_EQ(meshOf(6, {{0, 1, 2}, {0, 2, 1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}).kind(0),
              std::nullopt);
    std::vector<Loop> hexahedron = faceLoops(StandardCell::Hexahedron);
    EXPECT_EQ(meshOf(8, hexahedron).kind(0), StandardCell::Hexahedron);
    std::reverse(hexahedron[4].begin(), hexahedron[4].end());
    EXPECT_EQ(meshOf(8, hexahedron).kind(0), std::nullopt);
    EXPECT_EQ(meshOf(4, {{0, 1, 2}, {0, 2, 1}, {0, 1, 3}, {1, 0, 3}}).kind(0), std::nullopt);
    EXPECT_EQ(meshOf(5, {{0, 1, 2, 3, 4}, {4, 3, 2, 1, 0}}).kind(0), std::nullopt);
}

// Unlike in a CellComplex: three cells at a face, a cell that names a point twice, an unused point.
TEST(VolumeMesh, TopologyIsNotValidated) {
    VolumeMeshBuilder builder(8);
    for (const Index apex : {3, 4, 5}) builder.addCell(StandardCell::Tetrahedron, {0, 1, 2, apex});
    builder.addCell(StandardCell::Tetrahedron, {0, 0, 1, 6});
    const VolumeMesh mesh = builder.build();
    EXPECT_EQ(mesh.cellCount(), 4);
    EXPECT_EQ(mesh.internalFaceCount(), 1);
    EXPECT_EQ(mesh.faceCount(), 15);
    EXPECT_EQ(mesh.owner(0), 0);
    EXPECT_EQ(mesh.neighbour(0), 1);
    EXPECT_EQ(VolumeMesh().cellCount(), 0);
}

TEST(VolumeMesh, NumbersOutOfRangeAreRefused) {
    VolumeMeshBuilder builder(4);
    EXPECT_REFUSED(TopologyError, "cell 0 names point 4; there are 4",
                   builder.addCell(StandardCell::Tetrahedron, {0, 1, 2, 4}));
    EXPECT_REFUSED(TopologyError, "cell 0 names point -1",
                   builder.addCell(std::vector<Loop>{{0, 1, -1}}));
    EXPECT_REFUSED(TopologyError, "fewer than 3 points",
                   builder.addCell(std::vector<Loop>{{0, 1}}));
    EXPECT_REFUSED(TopologyError, "cell 0 has 3 points; expected 4",
                   builder.addCell(StandardCell::Tetrahedron, {0, 1, 2}));
    EXPECT_EQ(builder.cellCount(), 0);
    const auto meshOf = [](Loop loop, std::vector<Index> owners, std::vector<Index> neighbours) {
        Rows<Index> faces;
        faces.values.assign(loop.begin(), loop.end());
        faces.offsets.push_back(Offset(loop.size()));
        return VolumeMesh(3, 2, faces, owners, neighbours);
    };
    EXPECT_EQ(meshOf({0, 1, 2}, {0}, {1}).internalFaceCount(), 1);
    EXPECT_REFUSED(TopologyError, "face 0 names point 3", meshOf({0, 1, 3}, {0}, {}));
    EXPECT_REFUSED(TopologyError, "face 0 has fewer than 3", meshOf({0, 1}, {0}, {}));
    EXPECT_REFUSED(TopologyError, "face 0 has the owner 2; there are 2 cells",
                   meshOf({0, 1, 2}, {2}, {}));
    EXPECT_REFUSED(TopologyError, "face 0 has the neighbour -1", meshOf({0, 1, 2}, {0}, {-1}));
    EXPECT_REFUSED(Error, "got 0 owners and 0 neighbours of 1 faces", meshOf({0, 1, 2}, {}, {}));
    EXPECT_REFUSED(Error, "got 1 owners and 2 neighbours", meshOf({0, 1, 2}, {0}, {1, 1}));
}

}  // namespace
}  // namespace espalier::far
