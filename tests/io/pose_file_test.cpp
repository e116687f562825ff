// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_match.h>
#include <espalier/io/formats.h>
#include <espalier/io/model.h>
#include <espalier/io/pose_file.h>
#include <espalier/stencils/stencil_table.h>

#include <algorithm>

#include "lattice_samples.h"
#include "support/test.h"

namespace espalier::test {
namespace {

/// A cube with the vertices of VTK's hexahedron, 1 wide.
Lattice cube() {
    far::ComplexBuilder builder(3, 8);
    builder.addCell(far::StandardCell::Hexahedron, std::vector<Index>{0, 1, 2, 3, 4, 5, 6, 7});
    Lattice lattice;
    lattice.complex = builder.build();
    lattice.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                         {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    return lattice;
}

/// The text of an OBJ with the eight vertices of the cube, the last one moved to (2, 2, 2).
std::string meshWith(const std::string& faces) {
    return "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 2 2 2\n" + faces;
}

std::vector<Point3> readMesh(const std::string& bytes, const Lattice& rest,
                             const std::string& name = "editor.obj") {
    const TemporaryFolder folder;
    putLatticeFile(folder / name, bytes);
    return io::readPose(folder / name, rest, "rest.vtu");
}

/// The message, after the path, that refuses an editor mesh as a pose of the cube.
std::string refusalOfMesh(const std::string& bytes, const std::string& name = "editor.obj") {
    return refusalOf(name, bytes, [](const auto& path) { io::readPose(path, cube(), "rest.vtu"); });
}

TEST(PoseFile, EditorMeshsKeepThePositionsOfEachVertexBitForBit) {
    const TemporaryFolder folder;
    for (Lattice lattice : {mixedLattice(), boxLattice()}) {
        lattice.positions[1] = {0.1 + 0.2, -1e-300, 12345678901234567.0};
        for (const char* name : {"editor.obj", "editor.PLY"}) {
            io::writeEditorMesh(folder / name, lattice);
            EXPECT_EQ(io::readPose(folder / name, lattice), lattice.positions) << name;
        }
    }
}

TEST(PoseFile, EditorMeshsHaveEveryFaceOfTheLattice) {
    const TemporaryFolder folder;
    const Lattice lattice = boxLattice();
    for (const char* name : {"editor.obj", "editor.ply"}) {
        io::writeEditorMesh(folder / name, lattice);
        const io::ModelFaces faces = io::readModel(folder / name)->readSurface().faces;
        ASSERT_EQ(faces.count(), static_cast<std::size_t>(lattice.complex.count(2)));
        for (Index face = 0; face < lattice.complex.count(2); ++face)
            EXPECT_TRUE(std::ranges::equal(faces[face], lattice.complex.relation(2, 0)[face]));
    }
}

TEST(PoseFile, LatticeFilesArePosesIfTheirCellsAreEqual) {
    const TemporaryFolder folder;
    Lattice pose = cube();
    pose.positions[6] = {3, 3, 3};
    io::writeLattice(folder / "pose.vtk", pose);
    EXPECT_EQ(io::readPose(folder / "pose.vtk", cube()), pose.positions);
    EXPECT_THAT(messageOf<io::FileError>(
                    [&] { io::readPose(folder / "pose.vtk", boxLattice(), "rest.vtu"); }),
                HasSubstr("pose.vtk: is not a pose of rest.vtu (called the first, this file the "
                          "second): the numbers of vertices differ"));
}

TEST(PoseFile, FacesMayBeginAnywhereTurnEitherWayAndBeMissing) {
    const std::vector<Point3> expected = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                          {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {2, 2, 2}};
    for (const char* faces : {"", "f 1 2 3 4\n", "f 3 4 1 2\n", "f 4/1/1 3/2/1 2/3/1 1/1/1\n",
                              "f -8 -7 -6 -5\nf 8 5 6 7\n"})
        EXPECT_EQ(readMesh(meshWith(faces), cube()), expected) << faces;
}

TEST(PoseFile, TrianglesOfAFaceAreNamedAsSuch) {
    EXPECT_EQ(refusalOfMesh(meshWith("f 1 2 3 4\nf 5 6 7\nf 5 7 8\n")),
              ": is not a pose of rest.vtu: face 1 of the file, of vertices 4, 5, 6, is a part of "
              "face 5 of the lattice, of vertices 4, 5, 6, 7. Export the mesh without splitting "
              "faces into triangles");
}

TEST(PoseFile, FacesThatTheLatticeDoesNotHaveAreRefused) {
    const std::string message =
        " is not a face of the lattice. The vertices may have another order: begin with an editor "
        "mesh "
        "written by 'espalier refine LATTICE -n 0 -o editor.obj', and keep the order of its "
        "vertices";
    EXPECT_EQ(refusalOfMesh(meshWith("f 1 2 3 5\n")),
              ": is not a pose of rest.vtu: face 0 of the file, of vertices 0, 1, 2, 4," + message);
    // The vertices of a face, but crosswise.
    EXPECT_THAT(refusalOfMesh(meshWith("f 1 3 2 4\n")), HasSubstr("0, 2, 1, 3," + message));
}

// Blender's legacy importer numbers the vertices in the order in which the faces use them.
TEST(PoseFile, VerticesInTheOrderOfTheirFirstUseAreRecognised) {
    const Lattice lattice = cube();
    const io::ModelFaces faces = io::facesOf(lattice.complex);
    std::vector<int> numbers(8, 0);  // counted from 1
    std::string points, text;
    int count = 0;
    for (std::size_t face = 0; face < faces.count(); ++face) {
        text += "f";
        for (const Index vertex : faces[face]) {
            if (numbers[vertex] == 0) {
                numbers[vertex] = ++count;
                const auto& [x, y, z] = lattice.positions[vertex];
                points += concat("v ", x, " ", y, " ", z, "\n");
            }
            text += concat(" ", numbers[vertex]);
        }
        text += "\n";
    }
    EXPECT_THAT(refusalOfMesh(points + text), HasSubstr("or choose Keep Vert Order"));
    // Without a face it is no such mesh.
    EXPECT_THAT(refusalOfMesh(points + text.substr(0, text.rfind("f "))),
                HasSubstr("The vertices may have another order"));
}

TEST(PoseFile, FacesWithoutVerticesAreNamedAsSuch) {
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n";
    EXPECT_EQ(
        refusalOfMesh(head + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n0\n",
                      "editor.ply"),
        ": is not a pose of rest.vtu: face 0 of the file has no vertices. Export the mesh with "
        "the faces of the lattice");
}

TEST(PoseFile, EightVerticesOfAFaceAreListed) {
    EXPECT_THAT(refusalOfMesh(meshWith("f 1 2 3 4 5 6 7 8\n")),
                HasSubstr("of vertices 0, 1, 2, 3, 4, 5, 6, 7, is not a face"));
    EXPECT_THAT(refusalOfMesh(meshWith("f 1 2 3 4 5 6 7 8 1\n")),
                HasSubstr("of vertices 0, 1, 2, 3, 4, 5, 6, 7, ..., is not a face"));
}

// If the time to compare a face grew as the square of its corners, this would take minutes.
TEST(PoseFile, AFaceMayRepeatItsLowestVertexOften) {
    std::string face = "f";
    for (int i = 0; i < 300'000; ++i) face += " 1";
    EXPECT_THAT(refusalOfMesh(meshWith(face + " 2\n")), HasSubstr("is not a face of the lattice"));
}

TEST(PoseFile, TheNumberOfPointsMustBeTheNumberOfVertices) {
    EXPECT_EQ(refusalOfMesh(meshWith("v 0 0 0\n")),
              ": is not a pose of rest.vtu: it has 9 points; expected one for each of the 8 "
              "vertices of the lattice, in their order. Export the mesh without removing, merging "
              "or splitting vertices");
}

TEST(PoseFile, MalformedFacesNameTheirPlace) {
    EXPECT_EQ(refusalOfMesh(meshWith("f 1 2 3 9\n")),
              ":9: a face has the corner '9', which names no point; there are 8 before it and 8 in "
              "the file");
    EXPECT_THAT(refusalOfMesh(meshWith("f 1 2 0\n")), HasSubstr(":9: a face has the corner '0'"));
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n"
        "1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 0 1 2 ";
    EXPECT_EQ(readMesh(ply + "3\n", cube(), "editor.ply"), cube().positions);
    EXPECT_EQ(refusalOfMesh(ply + "8\n", "editor.ply"),
              ":18: a face has the corner '8', which is not the number of a point; there are 8");
}

TEST(PoseFile, BoundModelsCompareTheNumberOfPointsTheCellsAndTheFaces) {
    const TemporaryFolder folder;
    io::writeEditorMesh(folder / "editor.obj", cube());
    io::writeLattice(folder / "pose.ovm", cube());
    io::BoundModel bound;
    bind::Binding& binding = bound.binding;
    binding.topologyHash = far::topologyHash(cube().complex);
    binding.table = stencils::StencilTable<double>(8, {0}, {}, {});
    bound.faces = io::facesOf(cube().complex);
    for (const char* name : {"editor.obj", "pose.ovm"})
        EXPECT_EQ(io::readPose(folder / name, bound, "m.espb"), cube().positions);
    putLatticeFile(folder / "other.obj", meshWith("f 1 3 2 4\n"));
    EXPECT_THAT(
        messageOf<io::FileError>([&] { io::readPose(folder / "other.obj", bound, "m.espb"); }),
        HasSubstr("other.obj: is not a pose of the lattice of m.espb: face 0 of the "
                  "file, of vertices 0, 2, 1, 3, is not a face of the lattice"));
    ++binding.topologyHash;
    EXPECT_THAT(
        messageOf<io::FileError>([&] { io::readPose(folder / "pose.ovm", bound, "m.espb"); }),
        HasSubstr("pose.ovm: is not a pose of the lattice of m.espb: the bound "
                  "lattice has 8 vertices, the pose 8; or their cells differ"));
    binding.table = stencils::StencilTable<double>(9, {0}, {}, {});
    EXPECT_THAT(
        messageOf<io::FileError>([&] { io::readPose(folder / "editor.obj", bound, "m.espb"); }),
        HasSubstr("editor.obj: is not a pose of the lattice of m.espb: it has 8 "
                  "points; expected one for each of the 9 vertices"));
}

TEST(PoseFile, OnlyObjAndPlyAreEditorMeshes) {
    EXPECT_TRUE(io::isFileOf(io::FileContent::EditorMesh, "a.Obj"));
    EXPECT_TRUE(io::isFileOf(io::FileContent::EditorMesh, "a.ply"));
    for (const char* name : {"a.vtu", "a.stl", "a"}) {
        EXPECT_FALSE(io::isFileOf(io::FileContent::EditorMesh, name));
        EXPECT_EQ(messageOf<io::FileError>([&] { io::writeEditorMesh(name, cube()); }),
                  name + std::string(
                             ": an editor mesh cannot be written in this format; expected .obj or "
                             ".ply"));
    }
}

}  // namespace
}  // namespace espalier::test
