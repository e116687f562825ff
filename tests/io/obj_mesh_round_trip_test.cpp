// SPDX-License-Identifier: Apache-2.0
#include "obj_mesh_samples.h"

#include "support/shared_data.h"

namespace espalier::test {
namespace {

using far::Creasing;
using far::kInfinitelySharp;
using far::TriangleSubdivision;

TEST(ObjMesh, IsWrittenAsDocumented) {
    Lattice mesh = readMesh(kVertices + "f 4 5 2 1\nf 6 5 2 3\n");
    mesh.positions[1] = {0.1, -0.0, 1e300};
    mesh.marks.edges = {{{5, 4}, double{4.7F}}, {{1, 4}, 12}, {{0, 1}, 0}, {{1, 0}, 0.3}};
    mesh.marks.vertices = {{3, kInfinitelySharp}, {2, far::kSmooth}, {0, 1}};
    mesh.marks.holes = {1, 0, 1};
    mesh.tags = {Boundary::EdgeOnly, Creasing::Chaikin, TriangleSubdivision::Smooth,
                 far::FaceVaryingLinear::CornersPlus2};
    EXPECT_EQ(writtenMesh(mesh),
              "v 0 0 0\nv 0.1 -0 1e+300\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
              "f 4 5 2 1\nf 6 5 2 3\n"
              "t interpolateboundary 1/0/0 2\n"
              "t creasemethod 0/0/1 chaikin\n"
              "t smoothtriangles 0/0/1 smooth\n"
              "t facevaryinginterpolateboundary 1/0/0 3\n"
              "t crease 2/1/0 0 1 0.3\n"
              "t crease 2/1/0 1 4 10\n"
              "t crease 2/1/0 4 5 4.7\n"
              "t corner 1/1/0 0 1\n"
              "t corner 1/1/0 3 10\n"
              "t hole 1/0/0 0\n"
              "t hole 1/0/0 1\n");
    EXPECT_EQ(writtenMesh(readMesh(kSquares)), kSquares);
}

TEST(ObjMesh, RoundTripIsExact) {
    Lattice mesh = taggedMesh();
    expectSameMesh(readMesh(writtenMesh(mesh)), mesh);
    for (const auto boundary : {Boundary::Open, Boundary::Sharp, Boundary::EdgeOnly}) {
        mesh.tags = {.boundary = boundary};
        expectSameMesh(readMesh(writtenMesh(mesh)), mesh);
    }
    for (const auto creasing : {Creasing::Uniform, Creasing::Chaikin}) {
        mesh.tags = {.creasing = creasing};
        expectSameMesh(readMesh(writtenMesh(mesh)), mesh);
    }
    for (const auto triangles : {TriangleSubdivision::Catmark, TriangleSubdivision::Smooth}) {
        mesh.tags = {.triangles = triangles};
        expectSameMesh(readMesh(writtenMesh(mesh)), mesh);
    }
}

TEST(ObjMesh, RefusesToWriteInconsistentMeshes) {
    const auto refused = [](const Lattice& mesh) -> std::string {
        const TemporaryFolder folder;
        try {
            io::writeObjMesh(folder / "a.obj", mesh);
        } catch (const Error& error) {
            EXPECT_FALSE(std::filesystem::exists(folder / "a.obj"));
            EXPECT_THAT(error.what(), StartsWith((folder / "a.obj").string() + ": "));
            return error.what();
        }
        return "";
    };
    EXPECT_THAT(refused(boxLattice()), HasSubstr("of dimension 3, not 2"));
    EXPECT_THAT(refused({}), HasSubstr("of dimension 0, not 2"));

    Lattice mesh = readMesh(kSquares);
    mesh.attributes = {{"uv", 2, std::vector<double>(12)}};
    EXPECT_THAT(refused(mesh),
                HasSubstr("the attribute 'uv', and an OBJ has no place for attributes"));
    mesh = readMesh(kSquares);
    mesh.positions.pop_back();
    EXPECT_THAT(refused(mesh), HasSubstr("6 vertices and 5 positions"));
    mesh = readMesh(kSquares);
    mesh.positions[3][1] = kNan;
    EXPECT_THAT(refused(mesh), HasSubstr("point 3 is not finite"));
    mesh = readMesh(kSquares);
    mesh.marks.edges = {{{0, 4}, 1}};
    EXPECT_THAT(refused(mesh), HasSubstr("a mark names edge (0, 4), which does not exist"));
    mesh = readMesh(kSquares);
    mesh.marks.holes = {2};
    EXPECT_THAT(refused(mesh), HasSubstr("face 2 is marked as a hole, but there are 2"));
}

/// A text with all kinds of statements. Each truncated or damaged copy must be read, or refused
/// with an Error.
const std::string& textWithAllStatements() {
    static const std::string text =
        writtenMesh(taggedMesh()) + "t crease 4/2/0 0 1 1 4 0 12\nt corner 2/1/0 1 2 \\\n 3\n" +
        "t interpolateboundary 1/0/0 2\nt creasemethod 0/0/1 chaikin\n" +
        "t smoothtriangles 0/0/1 smooth\nt facevarying 1/0/0 1\nv 8 8 8 1 1 1\nf 1/1 -1//2 2/1/1\n";
    return text;
}

TEST(ObjMesh, TruncatedFilesAreReadOrRefused) {
    const TemporaryFolder folder;
    std::size_t readCount = 0;
    for (std::size_t size = 0; size <= textWithAllStatements().size(); ++size) {
        putLatticeFile(folder / "a.obj", textWithAllStatements().substr(0, size));
        try {
            const Lattice mesh = io::readRefinable(folder / "a.obj");
            far::validate(mesh.complex);
            EXPECT_EQ(mesh.positions.size(), std::size_t(mesh.complex.count(0)));
            ++readCount;
        } catch (const io::FileError&) {
        } catch (const far::TopologyError&) {
        } catch (...) {
            ADD_FAILURE() << "another exception for " << size << " bytes";
        }
    }
    // A part can be read at least after each statement from the first face on: 3 faces, 13 tags, a
    // vertex, a face.
    EXPECT_GE(readCount, 18u);
}

TEST(ObjMesh, SurvivesDamage) {
    const TemporaryFolder folder;
    for (std::size_t at = 0; at < textWithAllStatements().size(); at += 3)
        for (const char damage : {'9', '/', '\n'}) {
            std::string damaged = textWithAllStatements();
            damaged[at] = damage;
            putLatticeFile(folder / "a.obj", damaged);
            try {
                io::readRefinable(folder / "a.obj");
            } catch (const io::FileError&) {
            } catch (const far::TopologyError&) {
            } catch (...) {
                ADD_FAILURE() << "another exception at byte " << at;
            }
        }
}

/// The content of OpenSubdiv's regression shapes, as counted by grep and awk. `edges` and
/// `vertices` are the numbers of crease and corner tags.
struct Shape {
    Index vertexCount, faceCount;
    std::size_t edges = 0, vertices = 0;
    std::optional<Boundary> boundary = {};
    std::optional<far::FaceVaryingLinear> faceVarying = {};
};

TEST(ObjMesh, SharedSurfacesAreRead) {
    const auto folder = sharedData() / "surfaces";
    if (!std::filesystem::exists(folder))
        GTEST_SKIP() << folder << " is absent: set ESPALIER_SHARED_DATA to have it read";
    const std::map<std::string, Shape> expected = {
        {"nonman_edges", {142, 85, 0, 0, Boundary::Sharp}},
        {"nonman_verts", {49, 20, 0, 0, Boundary::Sharp}},
        {"car", {1642, 1575, 314}},
        {"cube", {8, 6}},
        {"cube_corner0", {8, 6, 0, 1}},
        {"cube_corner4", {8, 6, 0, 1}},
        {"cube_creases0", {8, 6, 2, 0, Boundary::EdgeOnly}},
        {"cube_creases2", {8, 6, 12, 0, Boundary::EdgeOnly}},
        {"cubes_infsharp",
         {32, 24, 18, 1, Boundary::EdgeOnly, far::FaceVaryingLinear::CornersOnly}},
        {"dart_edgecorner", {25, 16, 2, 0, Boundary::Sharp}},
        {"edgecorner", {52, 28, 0, 0, Boundary::Sharp}},
        {"edgeonly", {40, 20, 0, 6, Boundary::EdgeOnly}},
        {"flap", {8, 3}},
        {"gregory_test1", {10, 7}},
        {"lefthanded", {436, 434}},
        {"pole64", {129, 128}},
        {"pyramid", {5, 5}},
        {"pyramid_creases0", {5, 5, 4, 0, Boundary::EdgeOnly}},
        {"rook", {768, 777, 280}},
        {"tent", {16, 9, 0, 0, Boundary::EdgeOnly}},
        {"toroidal_tet", {20, 24}},
        {"torus", {32, 32}},
        {"torus_creases1", {32, 32, 9}},
        {"val2_back2back", {18, 8, 0, 0, Boundary::Sharp}}};
    EXPECT_EQ(expected.size(), 24u);
    for (const auto& [name, shape] : expected) {
        SCOPED_TRACE(name);
        const Lattice mesh = io::readRefinable(folder / ("catmark_" + name + ".obj"));
        EXPECT_EQ(mesh.complex.count(0), shape.vertexCount);
        EXPECT_EQ(mesh.complex.count(2), shape.faceCount);
        EXPECT_EQ(mesh.marks.edges.size(), shape.edges);
        EXPECT_EQ(mesh.marks.vertices.size(), shape.vertices);
        EXPECT_EQ(mesh.tags,
                  (RefinementTags{.boundary = shape.boundary, .faceVarying = shape.faceVarying}));
        expectSameMesh(readMesh(writtenMesh(mesh)), mesh);
    }
}

TEST(ObjMesh, SharedModelsAreRead) {
    const auto folder = sharedData() / "models";
    if (!std::filesystem::exists(folder))
        GTEST_SKIP() << folder << " is absent: set ESPALIER_SHARED_DATA to have it read";
    // The numbers are counted by grep -c '^v ' and '^f '.
    const Lattice arm = io::readRefinable(folder / "rocker-arm.obj");
    EXPECT_EQ(arm.complex.count(0), 10044);
    EXPECT_EQ(arm.complex.count(2), 20088);
    const Lattice spot = io::readRefinable(folder / "spot.obj");
    EXPECT_EQ(spot.complex.count(0), 2930);
    EXPECT_EQ(spot.complex.count(2), 5856);
    expectSameMesh(readMesh(writtenMesh(spot)), spot);
    // 1113 of the points are in no face.
    const Lattice bunny = io::readRefinable(folder / "stanford-bunny.obj");
    EXPECT_EQ(bunny.complex.count(0), 35947);
    EXPECT_EQ(bunny.complex.count(2), 69451);
}

}  // namespace
}  // namespace espalier::test
