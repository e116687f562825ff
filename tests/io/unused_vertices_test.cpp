// SPDX-License-Identifier: Apache-2.0
#include <io/replaced.h>

#include "lattice_samples.h"

// Tests vertices that no cell uses. ParaView and other programs write such files, and an unused
// vertex must not make a lattice unreadable.

namespace espalier::test {
namespace {

using testing::EndsWith;

/// A file with six vertices, values and marks on all of them, and a tetrahedron of vertices 1, 2, 4
/// and 5.
struct File {
    const char* name;
    std::string text;

    friend void PrintTo(const File& file, std::ostream* out) { *out << file.name; }
};

const File kOvm = {"a.ovm",
                   "OVM ASCII\n"
                   "Vertices\n6\n9 9 9\n0 0 0\n1 0 0\n8 8 8\n0 7 0\n0 0 1\n"
                   "Edges\n6\n1 2\n2 4\n4 1\n1 5\n5 2\n5 4\n"
                   "Faces\n4\n3 0 2 4\n3 6 8 1\n3 9 10 3\n3 11 7 5\n"
                   "Polyhedra\n1\n4 0 2 4 6\n"
                   "VProp double \"heat\"\n10 11 12 13 14 15\n"
                   "VProp vec2d \"uv\"\n0 1 10 11 20 21 30 31 40 41 50 51\n"
                   "VProp long \"ids\"\n0 1 2 3 4 5\n"
                   "VProp double \"espalier:vertex_sharpness\"\n-1 10 -1 5 0.5 -1\n"
                   "EProp double \"espalier:edge_sharpness\"\n-1 -1 -1 -1 2 -1\n"};

const File kVtk = {"a.vtk",
                   "# vtk DataFile Version 2.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                   "FIELD f 2\n"
                   "espalier:edge_vertices 2 1 int\n5 2\n"
                   "espalier:edge_sharpness 1 1 double\n2\n"
                   "POINTS 6 double\n9 9 9 0 0 0 1 0 0 8 8 8 0 7 0 0 0 1\n"
                   "CELLS 1 5\n4 1 2 4 5\nCELL_TYPES 1\n10\n"
                   "POINT_DATA 6\n"
                   "FIELD f 4\n"
                   "heat 1 6 double\n10 11 12 13 14 15\n"
                   "uv 2 6 double\n0 1 10 11 20 21 30 31 40 41 50 51\n"
                   "ids 1 6 vtktypeint64\n0 1 2 3 4 5\n"
                   "espalier:vertex_sharpness 1 6 double\n-1 10 -1 5 0.5 -1\n"};

std::string vtuArray(const std::string& name, const std::string& type, int components,
                     const std::string& values) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
           std::to_string(components) + "\" format=\"ascii\">" + values + "</DataArray>\n";
}

std::string vtuPiece(const std::string& pointData, const std::string& points,
                     const std::string& cell, int pointCount) {
    return "<Piece NumberOfPoints=\"" + std::to_string(pointCount) +
           "\" NumberOfCells=\"1\">\n<PointData>\n" + pointData + "</PointData>\n<Points>\n" +
           vtuArray("Points", "Float64", 3, points) + "</Points>\n<Cells>\n" +
           vtuArray("connectivity", "Int64", 1, cell) + vtuArray("offsets", "Int64", 1, "4") +
           vtuArray("types", "UInt8", 1, "10") + "</Cells>\n</Piece>\n";
}

std::string vtuFile(const std::string& fieldData, const std::string& pieces) {
    return "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n<FieldData>\n" + fieldData +
           "</FieldData>\n" + pieces + "</UnstructuredGrid>\n</VTKFile>\n";
}

const File kVtu = {
    "a.vtu",
    vtuFile(vtuArray("espalier:edge_vertices", "Int64", 2, "5 2") +
                vtuArray("espalier:edge_sharpness", "Float64", 1, "2"),
            vtuPiece(vtuArray("heat", "Float64", 1, "10 11 12 13 14 15") +
                         vtuArray("uv", "Float64", 2, "0 1 10 11 20 21 30 31 40 41 50 51") +
                         vtuArray("ids", "Int64", 1, "0 1 2 3 4 5") +
                         vtuArray("espalier:vertex_sharpness", "Float64", 1, "-1 10 -1 5 0.5 -1"),
                     "9 9 9 0 0 0 1 0 0 8 8 8 0 7 0 0 0 1", "1 2 4 5", 6))};

/// Returns the lattice that is read: vertices 1, 2, 4 and 5 become 0, 1, 2 and 3.
Lattice usedTetrahedron() {
    far::ComplexBuilder builder(3, 4);
    builder.addCell(far::StandardCell::Tetrahedron, {0, 1, 2, 3});
    Lattice lattice;
    lattice.complex = builder.build();
    lattice.positions = {{0, 0, 0}, {1, 0, 0}, {0, 7, 0}, {0, 0, 1}};
    lattice.attributes = {{"heat", 1, {11, 12, 14, 15}},
                          {"uv", 2, {10, 11, 20, 21, 40, 41, 50, 51}}};
    lattice.integers = {{"ids", 1, IntegerType::Int64, {1, 2, 4, 5}}};
    lattice.marks.vertices = {{0, far::kInfinitelySharp}, {2, 0.5}};
    lattice.marks.edges = {{{1, 3}, 2}};
    return lattice;
}

class UnusedVertices : public testing::TestWithParam<File> {};

INSTANTIATE_TEST_SUITE_P(Formats, UnusedVertices, testing::Values(kOvm, kVtk, kVtu));

TEST_P(UnusedVertices, AreDroppedWithTheirValuesAndMarks) {
    const TemporaryFolder folder;
    const auto path = folder / GetParam().name;
    putLatticeFile(path, GetParam().text);
    io::ReadNotes notes;
    expectSameLattice(io::readLattice(path, &notes), usedTetrahedron());
    EXPECT_THAT(notes.droppedVertices, ElementsAre(0, 3));
    notes = {};
    expectSameLattice(io::readRefinable(path, GetParam().text, &notes), usedTetrahedron());
    EXPECT_THAT(notes.droppedVertices, ElementsAre(0, 3));
    expectSameLattice(io::readLattice(path), usedTetrahedron());
}

TEST_P(UnusedVertices, AreNotWrittenAgain) {
    const Lattice lattice = latticeOf(GetParam().name, GetParam().text);
    io::ReadNotes notes{{7}};
    const std::string written = writtenLattice(GetParam().name, lattice);
    expectSameLattice(io::readLattice(GetParam().name, written, &notes), lattice);
    EXPECT_THAT(notes.droppedVertices, IsEmpty()) << "the notes are of the file read last";
}

TEST_P(UnusedVertices, MayHaveNonFinitePositions) {
    const std::string text = replaced(GetParam().text, "8 8 8", "8 nan 8");
    expectSameLattice(latticeOf(GetParam().name, text), usedTetrahedron());
    EXPECT_THAT(refusalOf(GetParam().name, replaced(GetParam().text, "0 7 0", "0 nan 0")),
                HasSubstr("point 4 is not finite"));
}

TEST_P(UnusedVertices, AloneMakeNoLattice) {
    std::string text = GetParam().text;
    const std::string name = GetParam().name;
    if (name == "a.ovm")
        text = "OVM ASCII\nVertices\n1\n9 9 9\nEdges\n0\nFaces\n0\nPolyhedra\n0\n";
    else if (name == "a.vtk")
        text =
            "# vtk DataFile Version 2.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
            "POINTS 1 float\n9 9 9\n";
    else
        text = vtuFile("", "<Piece NumberOfPoints=\"1\" NumberOfCells=\"0\"><Points>" +
                               vtuArray("Points", "Float64", 3, "9 9 9") + "</Points></Piece>");
    EXPECT_THAT(refusalOf(name, text), EndsWith(": there is no cell to refine"));
}

TEST(UnusedVerticesOfLattices, CannotHaveMarkedEdges) {
    for (const std::string ends : {"5 3", "0 3", "3 1"}) {
        const std::string name = "edge (" + replaced(ends, " ", ", ") + "), which does not exist";
        EXPECT_THAT(refusalOf("a.vtu", replaced(kVtu.text, ">5 2<", ">" + ends + "<")),
                    HasSubstr(name));
        EXPECT_THAT(refusalOf("a.vtk", replaced(kVtk.text, "\n5 2\n", "\n" + ends + "\n")),
                    HasSubstr(name));
    }
}

TEST(UnusedVerticesOfLattices, AreNumberedAcrossPieces) {
    // The pieces have vertices 0 to 4 and 5 to 9; no cell uses 0 and 9.
    const std::string pieces = vtuPiece(vtuArray("ids", "Int64", 1, "0 1 2 3 4"),
                                        "9 9 9 0 0 0 1 0 0 0 1 0 0 0 1", "1 2 3 4", 5) +
                               vtuPiece(vtuArray("ids", "Int64", 1, "5 6 7 8 9"),
                                        "2 0 0 3 0 0 2 1 0 2 0 1 9 9 9", "0 1 2 3", 5);
    const std::string marks = vtuArray("espalier:edge_vertices", "Int64", 2, "8 5") +
                              vtuArray("espalier:edge_sharpness", "Float64", 1, "2");
    io::ReadNotes notes;
    const Lattice lattice = io::readLattice("a.vtu", vtuFile(marks, pieces), &notes);
    EXPECT_THAT(notes.droppedVertices, ElementsAre(0, 9));
    EXPECT_THAT(lattice.integers.at(0).values, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
    EXPECT_EQ(lattice.positions.at(7), (Point3{2, 0, 1}));
    EXPECT_EQ(lattice.marks.edges, (std::vector<far::Marks::Edge>{{{4, 7}, 2}}));
}

TEST(UnusedVerticesOfLattices, AreNotCountedInMessages) {
    // A tetrahedron that lacks a face, as a polyhedron of the vertices 1 to 4.
    const std::string text =
        "# vtk DataFile Version 2.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        "POINTS 5 float\n9 9 9 0 0 0 1 0 0 0 1 0 0 0 1\n"
        "CELLS 1 14\n13 3 3 1 3 2 3 1 2 4 3 2 3 4\nCELL_TYPES 1\n42\n";
    EXPECT_THAT(refusalOf("a.vtk", text),
                AllOf(HasSubstr("cell 0 is open: its edge (0, "),
                      HasSubstr(" (unused vertices, 1 in all, are not counted)")));
    EXPECT_THAT(refusalOf("a.vtk", replaced(kVtk.text, "4 1 2 4 5", "4 1 2 4 4")),
                HasSubstr("names vertex 4 twice"))
        << "before any is dropped, the file's numbers count";
}

TEST(UnusedVerticesOfCurves, AreDroppedAndOfMeshesKept) {
    const std::string points = "v 0 0 0\nv 9 9 9\nv 1 2 0\nv 3 2 0\nv 8 8 8\n";
    const std::string tags = "t corner 2/1/0 1 3 10\n";
    io::ReadNotes notes;
    const Lattice curve = io::readRefinable("a.obj", points + "l 1 3 4\n" + tags, &notes);
    EXPECT_THAT(notes.droppedVertices, ElementsAre(1, 4));
    EXPECT_EQ(curve.complex.count(0), 3);
    EXPECT_EQ(curve.positions, (std::vector<Point3>{{0, 0, 0}, {1, 2, 0}, {3, 2, 0}}));
    EXPECT_EQ(curve.marks, (far::Marks{.vertices = {{2, far::kInfinitelySharp}}}));

    notes = {};
    const Lattice mesh = io::readRefinable("a.obj", points + "f 1 3 4\n" + tags, &notes);
    EXPECT_THAT(notes.droppedVertices, IsEmpty());
    EXPECT_EQ(mesh.complex.count(0), 5);
    EXPECT_EQ(mesh.marks.vertices.size(), 2u);
}

TEST(UnusedVerticesOfCurves, CannotHaveTagsOfEdges) {
    const std::string curve = "v 0 0 0\nv 9 9 9\nv 1 2 0\nl 1 3\n";
    EXPECT_EQ(io::readRefinable("a.obj", curve + "t crease 2/1/0 2 0 3\n").marks.edges,
              (std::vector<far::Marks::Edge>{{{0, 1}, 3}}));
    EXPECT_REFUSED(io::FileError, "a.obj:5: a tag names edge (1, 2); expected two",
                   io::readRefinable("a.obj", curve + "t crease 2/1/0 1 2 3\n"));
    EXPECT_REFUSED(io::FileError, "a.obj:5: a tag names vertex 3; expected 0 to 2",
                   io::readRefinable("a.obj", curve + "t corner 1/1/0 3 3\n"));
}

TEST(ReadNotes, AreDescribedInOneLine) {
    EXPECT_EQ(io::describe("a.vtu", {}), "");
    EXPECT_EQ(io::describe("a.vtu", {{17}}), "a.vtu: dropped 1 unused vertex (vertex 17)");
    EXPECT_EQ(io::describe("a.vtu", {{1, 2, 3, 5, 8}}),
              "a.vtu: dropped 5 unused vertices (vertices 1, 2, 3, 5, 8)");
    EXPECT_EQ(
        io::describe("a\n.vtu", {{1, 2, 3, 5, 8, 13}}),
        io::shownPath("a\n.vtu") + ": dropped 6 unused vertices (vertices 1, 2, 3, 5, 8, ...)");
    EXPECT_EQ(io::describe("a.vtk", {{}, {0, 0, 1}}),
              "a.vtk: skipped 1 surface cell, which is not a cell of a lattice");
    EXPECT_EQ(io::describe("a.vtk", {{17}, {2, 1, 24}}),
              "a.vtk: skipped 2 vertex cells, 1 line and 24 surface cells, which are not cells of "
              "a lattice; dropped 1 unused vertex (vertex 17)");
}

}  // namespace
}  // namespace espalier::test
