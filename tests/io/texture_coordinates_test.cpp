// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>
#include <espalier/io/models/obj_mesh.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/refined_lattice.h>

#include <optional>

#include "support/temporary_folder.h"
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

/// Refines a mesh, and returns its texture coordinates at the corners of its faces.
std::vector<std::array<double, 2>> refinedCorners(
    const Lattice& mesh, int level, std::optional<far::FaceVaryingLinear> linear = {}) {
    far::TopologyRefiner refiner(mesh.complex, refinerOptions(mesh));
    refiner.refineUniform(level);
    const auto textures = stencils::refinedLattice(refiner, level, mesh, linear).textureCoordinates;
    std::vector<std::array<double, 2>> corners;
    for (const Index i : textures.corners)
        corners.push_back(
            {textures.values[2 * std::size_t(i)], textures.values[2 * std::size_t(i) + 1]});
    return corners;
}

TEST(TextureCoordinates, TheTagOfTheFileIsTheDefaultMode) {
    for (const auto& [word, mode] : far::kFaceVaryingLinearWords) {
        const Lattice tagged = readObjMesh(
            "a.obj", std::string(kTwoQuads) + "t facevaryinginterpolateboundary 1/0/0 " +
                         std::to_string(static_cast<int>(mode)) + "\n");
        const Lattice plain = readObjMesh("a.obj", kTwoQuads);
        EXPECT_EQ(refinedCorners(tagged, 2), refinedCorners(plain, 2, mode)) << word;
        // An explicit mode counts more than the tag.
        EXPECT_EQ(refinedCorners(tagged, 2, far::FaceVaryingLinear::None),
                  refinedCorners(plain, 2, far::FaceVaryingLinear::None));
    }
    EXPECT_NE(refinedCorners(readObjMesh("a.obj", kTwoQuads), 2, far::FaceVaryingLinear::None),
              refinedCorners(readObjMesh("a.obj", kTwoQuads), 2));
}

/// The refined mesh has the mode as its tag, so refining it again gives the next level.
TEST(TextureCoordinates, OfARefinedMeshAreRefinedFurtherByTheSameMode) {
    // A cube whose faces are charts of several faces: a band around it, and two ends, one of which
    // is cut into two.
    Lattice mesh = readObjMesh("a.obj",
                               "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\n"
                               "v 0 1 1\nvt 0 0\nvt 1 0\nvt 2 0\nvt 3 0\nvt 4 0\nvt 0 1\nvt 1 1\n"
                               "vt 2 1\nvt 3 1\nvt 4 1\nvt 5 5\nvt 6 5\nvt 6 6\nvt 5 6\nvt 7 7\n"
                               "vt 8 7\nvt 8 8\nvt 9 9\nvt 9 8\nvt 8 9.5\n"
                               "f 1/1 2/2 6/7 5/6\nf 2/2 3/3 7/8 6/7\nf 3/3 4/4 8/9 7/8\n"
                               "f 4/4 1/5 5/10 8/9\nf 4/11 3/12 2/13 1/14\nf 5/15 6/16 7/17\n"
                               "f 5/18 7/19 8/20\n");
    for (const bool hasCrease : {false, true}) {
        if (hasCrease) mesh.marks.edges = {{{0, 1}, far::kInfinitelySharp}, {{1, 2}, 1}};
        for (const auto& [word, mode] : far::kFaceVaryingLinearWords) {
            far::TopologyRefiner refiner(mesh.complex, refinerOptions(mesh));
            refiner.refineUniform(1);
            const Lattice once = stencils::refinedLattice(refiner, 1, mesh, mode);
            EXPECT_EQ(once.tags.faceVarying, mode);
            const auto twice = refinedCorners(once, 1), wanted = refinedCorners(mesh, 2, mode);
            ASSERT_EQ(twice.size(), wanted.size());
            for (std::size_t i = 0; i < twice.size(); ++i)
                for (std::size_t axis = 0; axis < 2; ++axis)
                    // Products of sums of at most 16 numbers below 10, in another order.
                    EXPECT_NEAR(twice[i][axis], wanted[i][axis], 1e-13)
                        << word << ", corner " << i << (hasCrease ? ", creased" : "");
        }
    }
}

TEST(TextureCoordinates, ThatDoNotFitTheMeshAreRefused) {
    Lattice mesh = readObjMesh("a.obj", kTwoQuads);
    const TemporaryFolder folder;
    const auto expectRefused = [&](const FaceVaryingAttribute& textures, const char* cause) {
        mesh.textureCoordinates = textures;
        EXPECT_REFUSED(FileError, cause, writeObjMesh(folder / "a.obj", mesh));
    };
    const std::vector<Index> corners = mesh.textureCoordinates.corners;
    const std::vector<double> values = mesh.textureCoordinates.values;
    expectRefused({3, values, corners}, "the texture coordinates have 3 components; an OBJ has 2");
    expectRefused({2, values, {0, 1, 2}}, "are not one for each corner of each face");
    expectRefused({2, {0, 0}, corners}, "have no number 1, which a corner names");
    std::vector<double> infinite = values;
    infinite[3] = kInfinity;
    expectRefused({2, infinite, corners}, "are not finite");
    // Without corners, the values are written too.
    expectRefused({2, infinite, {}}, "are not finite");
    expectRefused({2, {0, 0, 1}, {}}, "have 3 numbers; expected pairs");
    mesh.textureCoordinates = {2, values, {}};
    EXPECT_NO_THROW(writeObjMesh(folder / "a.obj", mesh));
    mesh.textureCoordinates = {2, {0, 0}, corners};
    EXPECT_REFUSED(Error, "a corner of a face names the texture coordinate 1; there are 1",
                   refinedCorners(mesh, 1));
}

}  // namespace
}  // namespace espalier::io
