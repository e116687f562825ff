// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/models/obj_mesh.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/refined_lattice.h>

#include "support/test.h"

namespace espalier::io {
namespace {

constexpr const char* kTwoQuads =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n"
    "vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nvt 0.75 0\nvt 1 0\nvt 1 1\nvt 0.75 1\n"
    "f 1/1 2/2 3/3 4/4\nf 2/5 5/6 6/7 3/8\n";

TEST(TextureCoordinates, AreReadPerCorner) {
    const Lattice mesh = readObjMesh("a.obj", kTwoQuads, nullptr);
    EXPECT_EQ(mesh.textureCoordinates.values.size(), 16U);
    EXPECT_EQ(mesh.textureCoordinates.corners, (std::vector<Index>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(TextureCoordinates, AreDroppedWithANoteIfACornerHasNone) {
    ReadNotes notes;
    const std::string text = std::string(kTwoQuads) + "f 1 2 5\n";
    EXPECT_TRUE(readObjMesh("a.obj", text, &notes).textureCoordinates.empty());
    EXPECT_EQ(notes.droppedTextureCoordinates, 8);
}

TEST(TextureCoordinates, OfModeAllAreBilinear) {
    const Lattice mesh = readObjMesh("a.obj", kTwoQuads, nullptr);
    far::TopologyRefiner refiner(mesh.complex);
    refiner.refineUniform(1);
    const Lattice refined = stencils::refinedLattice(refiner, 1, mesh);
    const FaceVaryingAttribute& textures = refined.textureCoordinates;
    // The child at vertex 0 of face 0: its corners are (0, 0), the sides' midpoints and the centre.
    const std::vector<std::array<double, 2>> expected = {{0, 0}, {0.25, 0}, {0.25, 0.5}, {0, 0.5}};
    for (std::size_t corner = 0; corner < 4; ++corner)
        for (std::size_t i = 0; i < 2; ++i)
            EXPECT_EQ(textures.values[std::size_t(textures.corners[corner]) * 2 + i],
                      expected[corner][i]);
}

// Without seams, texture coordinates are refined like positions.
TEST(TextureCoordinates, WithoutSeamsAreRefinedAsPositions) {
    Lattice mesh = readObjMesh("a.obj", kTwoQuads, nullptr);
    const auto corners = mesh.complex.relation(2, 0).values();
    FaceVaryingAttribute& base = mesh.textureCoordinates;
    base.corners.assign(corners.begin(), corners.end());
    base.values.clear();
    for (const Point3& p : mesh.positions) base.values.insert(base.values.end(), {p[0], p[1]});
    far::TopologyRefiner refiner(mesh.complex);
    refiner.refineUniform(3);
    const Lattice refined =
        stencils::refinedLattice(refiner, 3, mesh, far::FaceVaryingLinear::None);
    EXPECT_EQ(refined.textureCoordinates.values.size(), 2 * refined.positions.size());
    for (std::size_t i = 0; i < refined.positions.size(); ++i)
        for (std::size_t axis = 0; axis < 2; ++axis)
            EXPECT_EQ(refined.textureCoordinates.values[2 * i + axis], refined.positions[i][axis]);
}

}  // namespace
}  // namespace espalier::io
