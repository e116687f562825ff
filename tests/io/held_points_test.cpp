// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <espalier/io/pose_file.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/inventory.h>
#include <io/model_files.h>

#include <limits>

// Points that are not finite: kept where nothing that moves uses them, refused elsewhere.

namespace espalier::io {
namespace {

constexpr float kFloatNan = std::numeric_limits<float>::quiet_NaN();

const std::string kOneNan = "kept 1 point that is not finite and in no face (point ";

/// Moves all points by (0, 0, 1), and returns the file.
std::string raised(const Model& model) {
    std::vector<Point3> moved = copyOf(model.positions());
    for (Point3& point : moved) point[2] += 1;
    return written(model, moved,
                   std::vector<DeformationGradient>(moved.size(), {1, 0, 0, 0, 0, -1, 0, 1, 0}));
}

/// Reads a file whose point 0 is not finite and unused. `moved` is the file with z = 1 instead of
/// 0.
void expectHeld(const std::string& name, const std::string& bytes, const std::string& moved) {
    const auto model = readModel(name, bytes);
    EXPECT_THAT(model->notes(), ElementsAre(kOneNan + "0)")) << name;
    EXPECT_EQ(model->positions()[0], model->positions()[1]) << name;
    EXPECT_THAT(model->heldPoints(), ElementsAre(0)) << name;
    EXPECT_REFUSED(FileError, name + ": point 0 is not finite", refuseHeldPoints(name, *model));
    EXPECT_EQ(written(*model, model->positions()), bytes) << name;
    EXPECT_EQ(raised(*model), moved) << name;
    EXPECT_EQ(describe("b/" + name, *model), "b/" + name + ": " + kOneNan + "0)");
    EXPECT_REFUSED(FileError, name + ": is not understood in full: kept 1 point",
                   refuseNotes(name, *model));
}

std::string objOf(const std::string& z, const std::string& normal, const std::string& faces) {
    return "v nan 0 -inf\nv 0 0 " + z + "\nv 1 0 " + z + "\nv 0 1 " + z + "\nvn " + normal + "\n" +
           faces;
}

TEST(HeldPoints, OfAnObj) {
    const std::string faces = "f 2//1 3//1 4//1\n";
    // A quarter turn about x carries the normal z to −y.
    expectHeld("a.obj", objOf("0", "0 0 1", faces), objOf("1", "0 -1 0", faces));
    EXPECT_REFUSED(FileError, "a.obj:1: 'nan' is not finite; expected x",
                   readModel("a.obj", objOf("0", "0 0 1", "f 1 2 3\n")));
    EXPECT_REFUSED(FileError, "a.obj:2: '-inf' is not finite; expected z",
                   readModel("a.obj", "# all\nv 0 0 -inf\nv nan 0 0\n"));
    // Free-form curves, which are not read, may use the point.
    EXPECT_REFUSED(FileError, "a.obj:1: 'nan'",
                   readModel("a.obj", "v nan 0 0\nv 0 0 0\ncurv 0 1 1 2\nend\n"));
}

/// A cloud of points has no faces that could move.
TEST(HeldPoints, OfACloud) {
    const auto model = readModel("a.obj", "v 1 2 3\nv nan nan nan\nv inf 0 0\n");
    EXPECT_THAT(model->positions(), ElementsAre(Point3{1, 2, 3}, Point3{1, 2, 3}, Point3{1, 2, 3}));
    EXPECT_THAT(model->notes(), ElementsAre("kept 2 points that are not finite and in no face (the "
                                            "first is point 1)"));
    EXPECT_EQ(raised(*model), "v 1 2 4\nv nan nan nan\nv inf 0 0\n");
}

/// The vertices of a pose are wanted themselves.
TEST(HeldPoints, AreNoPose) {
    const TemporaryFolder folder;
    const Lattice rest = shapes::box({.cells = {1, 1, 1}});
    std::string text = "v nan 0 0\n";
    for (int i = 1; i < 8; ++i) text += "v 1 2 3\n";
    putFile(folder / "a.obj", text);
    EXPECT_REFUSED(FileError, "point 0 is not finite", readPose(folder / "a.obj", rest));
    putFile(folder / "b.obj", "v 0 0 0\nfoo\n" + text.substr(text.find('\n') + 1));
    ReadNotes notes;
    EXPECT_EQ(readPose(folder / "b.obj", rest, "rest", &notes).size(), 8u);
    EXPECT_EQ(describe("b.obj", notes),
              "b.obj: kept 1 line whose first word no OBJ has ('foo' in line 2)");
}

/// A face of held points alone does not move, so nothing is torn.
TEST(HeldPoints, MayBeWholeFaces) {
    const std::string text =
        "v nan 0 0\nv 0 nan 0\nv 0 0 nan\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const auto model = readModel("a.obj", text + "f 4 5 6\n");
    EXPECT_EQ(model->notes().size(), 1u);
    EXPECT_REFUSED(FileError, "a.obj:3: 'nan' is not finite; expected z",
                   readModel("a.obj", text + "f 3 4 5\n"));
}

std::string plyOf(const std::string& z, const std::string& faces) {
    return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
           "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
           "nan NaN -inf\n0 0 " +
           z + "\n1 0 " + z + "\n0 1 " + z + "\n" + faces;
}

TEST(HeldPoints, OfAPly) {
    expectHeld("a.ply", plyOf("0", "3 1 2 3\n"), plyOf("1", "3 1 2 3\n"));
    EXPECT_REFUSED(FileError, "a.ply:10: 'nan' is not finite; expected x",
                   readModel("a.ply", plyOf("0", "3 0 1 2\n")));
}

std::string binaryPlyOf(float z, std::int32_t first) {
    std::string bytes =
        "ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (const float number : {kFloatNan, 0.f, -kFloatNan, 0.f, 0.f, z, 1.f, 0.f, z, 0.f, 1.f, z})
        bytes += bytesOf(number, std::endian::big);
    bytes += '\3';
    for (const std::int32_t corner : {first, 2, 3}) bytes += bytesOf(corner, std::endian::big);
    return bytes;
}

TEST(HeldPoints, OfABinaryPly) {
    expectHeld("a.ply", binaryPlyOf(0, 1), binaryPlyOf(1, 1));
    const std::size_t x = binaryPlyOf(0, 0).find("end_header\n") + 11;
    EXPECT_REFUSED(FileError, concat("byte ", x, ": x of point 0 is not finite"),
                   readModel("a.ply", binaryPlyOf(0, 0)));
}

std::string vtkOf(const std::string& z, const std::string& cells) {
    return "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n"
           "nan 0 0 0 0 " +
           z + " 1 0 " + z + " 0 1 " + z + "\n0 0 nan\n" + cells;
}

TEST(HeldPoints, OfALegacyVtk) {
    const auto model = readModel("a.vtk", vtkOf("0", "CELLS 1 4\n3 1 2 3\nCELL_TYPES 1\n5\n"));
    EXPECT_EQ(raised(*model), vtkOf("1", "CELLS 1 4\n3 1 2 3\nCELL_TYPES 1\n5\n"));
    // The cells of a volume use points, too.
    EXPECT_REFUSED(FileError, "a.vtk:7: 'nan' is not finite; expected z",
                   readModel("a.vtk", vtkOf("0", "CELLS 1 5\n4 1 2 3 4\nCELL_TYPES 1\n10\n")));
}

std::string vtuOf(const std::string& z, int first) {
    const std::string array =
        "<DataArray type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\" "
        "format=\"ascii\">\nnan 0 0 0 0 ";
    return "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"4\" "
           "NumberOfCells=\"1\">\n<Points>\n" +
           array + z + " 1 0 " + z + " 0 1 " + z +
           "\n</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\">" +
           std::to_string(first) +
           " 2 3</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\">3</DataArray>\n<DataArray "
           "type=\"UInt8\" Name=\"types\">5</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n"
           "</VTKFile>\n";
}

TEST(HeldPoints, OfAVtu) {
    const auto model = readModel("a.vtu", vtuOf("0", 1));
    EXPECT_THAT(model->notes(), ElementsAre(kOneNan + "0)"));
    EXPECT_EQ(written(*model, model->positions()), vtuOf("0", 1));
    const auto again = readModel("a.vtu", raised(*model));
    EXPECT_THAT(again->notes(), ElementsAre(kOneNan + "0)"));
    EXPECT_EQ(again->positions()[3], (Point3{0, 1, 1}));
    // Each piece has an array of its own; the changed one is written with the NaN.
    const auto number = [](const std::string& text) {
        std::size_t count = 0;
        for (std::size_t at = 0; (at = text.find("nan", at)) != std::string::npos; ++at) ++count;
        return count;
    };
    EXPECT_EQ(number(raised(*model)), 1u);
    EXPECT_REFUSED(FileError, "a.vtu: point 0 is not finite", readModel("a.vtu", vtuOf("0", 0)));
}

/// The stand-in may need more digits, or be larger, than the numbers of another piece.
TEST(HeldPoints, OfPiecesOfDifferentPrecision) {
    const auto piece = [](const std::string& type, const std::string& points) {
        return "<Piece NumberOfPoints=\"2\" NumberOfCells=\"0\">\n<Points>\n<DataArray type=\"" +
               type + "\" NumberOfComponents=\"3\">\n" + points +
               "\n</DataArray>\n</Points>\n<Cells/>\n</Piece>\n";
    };
    const std::string text = "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n" +
                             piece("Float64", "1e300 0.1 0 0 0 0") +
                             piece("Float32", "nan 0 0 1 2 3") +
                             "</UnstructuredGrid>\n</VTKFile>\n";
    const auto model = readModel("a.vtu", text);
    EXPECT_EQ(model->positions()[2], model->positions()[0]);
    EXPECT_EQ(written(*model, model->positions()), text);
    std::vector<Point3> moved = copyOf(model->positions());
    moved[3] = {4, 5, 6};
    const auto again = readModel("a.vtu", written(*model, moved));
    EXPECT_EQ(again->positions()[3], moved[3]);
    EXPECT_EQ(again->notes(), model->notes());
}

/// A facet without any place is kept; a facet with one corner that is not finite is refused.
TEST(HeldPoints, OfAnStl) {
    const auto facet = [](const std::string& last, const std::string& z) {
        return "facet normal 0 0 1\nouter loop\nvertex 0 0 " + z + "\nvertex 1 0 " + z +
               "\nvertex 0 1 " + last + "\nendloop\nendfacet\n";
    };
    const std::string lost =
        "facet normal nan nan nan\nouter loop\nvertex nan nan nan\nvertex nan nan nan\n"
        "vertex nan nan nan\nendloop\nendfacet\n";
    const auto model = readModel("a.stl", "solid a\n" + lost + facet("0", "0") + "endsolid a\n");
    EXPECT_THAT(model->notes(), ElementsAre("kept 3 points that are not finite and in no face (the "
                                            "first is point 0)"));
    EXPECT_EQ(raised(*model), "solid a\n" + lost + facet("1", "1") + "endsolid a\n");
    EXPECT_REFUSED(FileError, "a.stl:6: 'inf' is not finite; expected z",
                   readModel("a.stl", "solid a\n" + facet("inf", "0") + "endsolid a\n"));
}

/// Readers of lattices drop vertices that no cell uses.
TEST(HeldPoints, OfAMesh) {
    const auto meshOf = [](const std::string& z) {
        return "NDIME= 3\nNELEM= 1\n10 0 1 2 3\nNPOIN= 5\n0 0 " + z + "\n1 0 " + z + "\n0 1 " + z +
               "\n0 0 5\nnan 0 0\n";
    };
    const auto model = readModel("a.su2", meshOf("0"));
    EXPECT_THAT(model->notes(), ElementsAre(kOneNan + "4)"));
    std::vector<Point3> moved = copyOf(model->positions());
    for (Point3& point : moved) point[2] = point[2] == 5 ? 5 : 1;
    EXPECT_EQ(written(*model, moved), meshOf("1"));
    EXPECT_EQ(readLattice("a.su2", meshOf("0")).positions.size(), 4u);
    EXPECT_REFUSED(FileError, "a.su2:5: 'nan' is not finite; expected x",
                   readModel("a.su2",
                             "NDIME= 3\nNELEM= 1\n10 0 1 2 3\nNPOIN= 4\nnan 0 0\n1 0 0\n"
                             "0 1 0\n0 0 1\n"));
}

}  // namespace
}  // namespace espalier::io
