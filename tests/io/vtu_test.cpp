// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/base64.h>
#include "lattice_samples.h"

#include <espalier/io/files/file.h>

#include "io/files/coding.h"
#include "io/vtk/vtk_xml.h"
#include "support/test.h"

namespace espalier::test {
namespace {

using Integers = std::vector<std::int64_t>;

/// Builds a .vtu file in ascii. This is independent of the code under test.
class Vtu {
public:
    std::string fileAttributes = "byte_order=\"LittleEndian\"";
    std::string fieldData;
    std::string pieces;
    std::string tail;

    static std::string array(const std::string& name, const std::string& values,
                             const std::string& type = "Int64", int components = 1) {
        return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
               std::to_string(components) + "\" format=\"ascii\">\n" + values + "\n</DataArray>\n";
    }

    /// \param counts numbers of points and cells
    Vtu& piece(std::array<int, 2> counts, const std::string& points, const std::string& cells,
               const std::string& pointData = "") {
        pieces += "<Piece NumberOfPoints=\"" + std::to_string(counts[0]) + "\" NumberOfCells=\"" +
                  std::to_string(counts[1]) + "\">\n<PointData>\n" + pointData +
                  "</PointData>\n<Points>\n" + array("Points", points, "Float64", 3) +
                  "</Points>\n<Cells>\n" + cells + "</Cells>\n</Piece>\n";
        return *this;
    }

    std::string text() const {
        return "<VTKFile type=\"UnstructuredGrid\" " + fileAttributes +
               ">\n<UnstructuredGrid>\n<FieldData>" + fieldData + "</FieldData>\n" + pieces +
               "</UnstructuredGrid>\n" + tail + "</VTKFile>\n";
    }

    Lattice read() const { return latticeOf("a.vtu", text()); }
    std::string refusal() const { return refusalOf("a.vtu", text()); }
};

std::string cells(const std::string& connectivity, const std::string& offsets,
                  const std::string& types) {
    return Vtu::array("connectivity", connectivity) + Vtu::array("offsets", offsets) +
           Vtu::array("types", types, "UInt8");
}

const std::string kTetrahedronPoints = "0 0 0 1 0 0 0 1 0 0 0 1";

std::string tetrahedronCells() {
    return cells("0 1 2 3", "4", "10");
}

Vtu tetrahedron() {
    return Vtu().piece({4, 1}, kTetrahedronPoints, tetrahedronCells());
}

TEST(Vtu, ReadsATetrahedron) {
    const Lattice lattice = tetrahedron().read();
    EXPECT_EQ(lattice.complex.count(0), 4);
    EXPECT_EQ(lattice.complex.count(2), 4);
    EXPECT_EQ(lattice.positions[3], (Point3{0, 0, 1}));
    EXPECT_TRUE(lattice.marks.empty());
    EXPECT_TRUE(lattice.attributes.empty());
}

TEST(Vtu, VoxelVerticesAreOrderedByZyx) {
    const std::string points = "0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1";
    const Lattice voxel = Vtu().piece({8, 1}, points, cells("0 1 2 3 4 5 6 7", "8", "11")).read();
    const Lattice hexahedron =
        Vtu().piece({8, 1}, points, cells("0 1 3 2 4 5 7 6", "8", "12")).read();
    expectSameLattice(voxel, hexahedron);
}

/// The layout since VTK 9.4 (its release notes: "VTK XML I/O update to support new vtk Polyhedral
/// cell storage"): faces are listed once, offsets are ends, and cells that are not polyhedra have
/// no faces.
TEST(Vtu, ReadsPolyhedraInTheLayoutOfVtk94) {
    // A hexahedron (standard cell), a pyramid on top of it (polyhedron), and a tetrahedron that
    // shares a face with the pyramid.
    const std::string points = "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1 0.5 0.5 2 2 0.5 2";
    const std::string standard = cells("0 1 2 3 4 5 6 7 4 5 6 7 8 5 6 8 9", "8 13 17", "12 42 42");
    const std::string since94 =
        standard +
        Vtu::array("face_connectivity", "4 5 6 7 4 5 8 5 6 8 6 7 8 7 4 8 5 9 6 6 9 8 8 9 5") +
        Vtu::array("face_offsets", "4 7 10 13 16 19 22 25") +
        Vtu::array("polyhedron_to_faces", "0 1 2 3 4 2 5 6 7") +
        Vtu::array("polyhedron_offsets", "0 5 9");
    const std::string before =
        standard +
        Vtu::array(
            "faces",
            "5 4 4 5 6 7 3 4 5 8 3 5 6 8 3 6 7 8 3 7 4 8 4 3 5 6 8 3 5 9 6 3 6 9 8 3 8 9 5") +
        Vtu::array("faceoffsets", "-1 22 39");
    const Lattice got = Vtu().piece({10, 3}, points, since94).read();
    EXPECT_EQ(got.complex.count(3), 3);
    // The cells have 6 + 5 + 4 faces, and 2 faces are shared.
    EXPECT_EQ(got.complex.count(2), 13);
    expectSameLattice(got, Vtu().piece({10, 3}, points, before).read());
}

TEST(Vtu, PiecesAreNumberedConsecutivelyAndNotWelded) {
    Vtu vtu;
    const std::string heat = Vtu::array("heat", "1 2 3 4", "Float32");
    vtu.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(), heat);
    vtu.piece({0, 0}, "", cells("", "", ""));
    vtu.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(),
              heat + Vtu::array("espalier:vertex_sharpness", "-1 10 -1 0", "Float64"));
    vtu.fieldData = Vtu::array("espalier:edge_vertices", "4 5 1 0", "Int32", 2) +
                    Vtu::array("espalier:edge_sharpness", "0 11", "Float64");
    const Lattice lattice = vtu.read();
    EXPECT_EQ(lattice.complex.count(0), 8);
    EXPECT_EQ(lattice.complex.count(3), 2);
    EXPECT_EQ(lattice.positions[0], lattice.positions[4]);
    ASSERT_EQ(lattice.attributes.size(), 1u);
    EXPECT_EQ(lattice.attributes[0].values, (std::vector<double>{1, 2, 3, 4, 1, 2, 3, 4}));
    EXPECT_EQ(lattice.marks.vertices,
              (std::vector<far::Marks::Vertex>{{5, far::kInfinitelySharp}, {7, 0}}));
    EXPECT_EQ(lattice.marks.edges,
              (std::vector<far::Marks::Edge>{{{0, 1}, far::kInfinitelySharp}, {{4, 5}, 0}}));
}

TEST(Vtu, PiecesMustHaveTheSamePointData) {
    Vtu vtu;
    vtu.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(), Vtu::array("heat", "1 2 3 4"));
    Vtu other = vtu;
    vtu.piece({4, 1}, kTetrahedronPoints, tetrahedronCells());
    EXPECT_THAT(vtu.refusal(),
                HasSubstr("the piece has 0 arrays of PointData; the first one has 1"));
    other.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(), Vtu::array("cold", "1 2 3 4"));
    EXPECT_THAT(other.refusal(), HasSubstr("'cold' is not in the PointData of the first piece"));
    Vtu narrow = tetrahedron();
    narrow.pieces = "";
    narrow.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(), Vtu::array("heat", "1 2 3 4"));
    narrow.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(),
                 Vtu::array("heat", "1 2 3 4", "Int8"));
    EXPECT_THAT(narrow.refusal(),
                HasSubstr("'heat' holds Int8; in the first piece it holds Int64"));
}

/// Tries all encodings of one array. Other tests show that the encoder used here agrees with VTK.
TEST(Vtu, ReadsArraysInAllEncodings) {
    for (const auto order : {std::endian::little, std::endian::big})
        for (const bool isWide : {false, true})
            for (const bool isCompressed : {false, true}) {
                const io::VtkCoding coding{order, isWide, isCompressed};
                Vtu vtu;
                vtu.fileAttributes = std::string("byte_order=\"") +
                                     (order == std::endian::little ? "LittleEndian" : "BigEndian") +
                                     "\" header_type=\"" + (isWide ? "UInt64" : "UInt32") + "\"" +
                                     (isCompressed ? " compressor=\"vtkZLibDataCompressor\"" : "");
                for (const auto type :
                     {io::NumberType::Int8, io::NumberType::UInt8, io::NumberType::Int16,
                      io::NumberType::UInt16, io::NumberType::Int32, io::NumberType::UInt32,
                      io::NumberType::Int64, io::NumberType::UInt64}) {
                    const Integers values = {7, 0, 99, 1};
                    vtu.pieces = "";
                    vtu.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(),
                              io::dataArrayElement<std::int64_t>(
                                  {"ids", type}, values, io::VtkArrayForm::Base64, coding, ""));
                    const VertexIntegers got = vtu.read().integers.at(0);
                    EXPECT_EQ(got.values, values);
                    EXPECT_STREQ(integerTypeName(got.type), io::xmlName(type));
                }
            }
}

TEST(Vtu, CellsOfLowerDimensionAreSkippedAndCounted) {
    const TemporaryFolder folder;
    const std::string bytes =
        Vtu()
            .piece({4, 4}, kTetrahedronPoints, cells("0 0 1 0 1 2 0 1 2 3", "1 3 6 10", "1 3 5 10"))
            .text();
    io::ReadNotes notes;
    const Lattice lattice = io::readLattice("a.vtu", bytes, &notes);
    EXPECT_EQ(lattice.complex.count(3), 1);
    EXPECT_EQ(notes, (io::ReadNotes{{}, {1, 1, 1}}));
}

TEST(Vtu, ErrorsNameTheOffender) {
    EXPECT_THAT(Vtu().piece({4, 1}, kTetrahedronPoints, cells("0 1 2 3", "4", "24")).refusal(),
                HasSubstr("cell 0 is of VTK's type 24; only the types 10 to 16 and 42"));
    EXPECT_THAT(Vtu().piece({4, 1}, kTetrahedronPoints, cells("0 1 2 4", "4", "10")).refusal(),
                HasSubstr("cell 0 names vertex 4; there are 4"));
    EXPECT_THAT(Vtu().piece({4, 1}, kTetrahedronPoints, cells("0 1 2 -1", "4", "10")).refusal(),
                HasSubstr("cell 0 names vertex -1"));
    EXPECT_THAT(Vtu().piece({4, 1}, kTetrahedronPoints, cells("0 1 2 3", "5", "10")).refusal(),
                HasSubstr("the array 'connectivity' has 4 numbers; expected 5, the last of "
                          "'offsets'"));
    EXPECT_THAT(Vtu().piece({4, 2}, kTetrahedronPoints, cells("0 1 2 3", "4 3", "10 10")).refusal(),
                HasSubstr("the array 'offsets' has 3 after 4; expected ascending offsets"));
    EXPECT_THAT(Vtu().piece({4, 1}, kTetrahedronPoints, cells("0 1 2 3", "4 4", "10")).refusal(),
                HasSubstr("the array 'offsets' has 2 numbers; expected 1, one a cell"));
    EXPECT_THAT(Vtu().piece({4, 1}, kTetrahedronPoints, cells("0 1 2", "3", "10")).refusal(),
                HasSubstr("cell 0 has 3 vertices; expected 4"));
    EXPECT_THAT(Vtu().piece({5, 1}, kTetrahedronPoints, tetrahedronCells()).refusal(),
                HasSubstr("the array 'Points' has 12 numbers; expected 5 times 3"));
    EXPECT_THAT(Vtu().piece({4, 1}, "0 0 0 1 0 0 0 1 0 0 0 nan", tetrahedronCells()).refusal(),
                HasSubstr("point 3 is not finite"));
    EXPECT_THAT(Vtu().piece({4, 1}, kTetrahedronPoints, Vtu::array("types", "10")).refusal(),
                HasSubstr("there is no array 'offsets'"));
    EXPECT_THAT(Vtu()
                    .piece({4, 1}, kTetrahedronPoints,
                           Vtu::array("types", "10") + Vtu::array("offsets", "4"))
                    .refusal(),
                HasSubstr("there is no array 'connectivity'"));
    EXPECT_THAT(Vtu().piece({4, 1}, "0 0 0\n1 0 0\n0 x 0\n0 0 1", tetrahedronCells()).refusal(),
                StartsWith(":11: 'x' is not a number"));
    EXPECT_THAT(Vtu().refusal(), HasSubstr("there is no cell"));
}

TEST(Vtu, ErrorsOfPolyhedraNameTheOffender) {
    const auto refusal = [](const std::string& faces) {
        return Vtu()
            .piece({4, 1}, kTetrahedronPoints, cells("0 1 2 3", "4", "42") + faces)
            .refusal();
    };
    const auto streams = [&](const std::string& faces, const std::string& offsets) {
        return refusal(Vtu::array("faces", faces) + Vtu::array("faceoffsets", offsets));
    };
    EXPECT_THAT(refusal(""), HasSubstr("there is no array 'faceoffsets'"));
    EXPECT_THAT(refusal(Vtu::array("faceoffsets", "17")), HasSubstr("there is no array 'faces'"));
    EXPECT_EQ(streams("4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3", "17"), "");
    EXPECT_THAT(
        streams("4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3", "18"),
        HasSubstr("the array 'faces' has 17 numbers; expected 18, the last of 'faceoffsets'"));
    EXPECT_THAT(streams("4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3", "-1"), HasSubstr("run from 0 to -1"));
    EXPECT_THAT(streams("4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0", "16"),
                HasSubstr("the number of vertices of a face is 3, but 2 numbers are left"));
    EXPECT_THAT(streams("3 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3", "17"),
                HasSubstr("cell 0 has 4 numbers after its last face"));
    EXPECT_THAT(streams("-4 3 0 2 1", "5"), HasSubstr("the number of its faces is -4"));
    EXPECT_THAT(streams("3 3 0 2 1 3 0 1 3 3 1 2 3", "13"), HasSubstr("cell 0 is open"));
    const auto lists = [&](const std::string& faces, const std::string& offsets) {
        return refusal(Vtu::array("face_connectivity", "0 2 1 0 1 3 1 2 3 2 0 3") +
                       Vtu::array("face_offsets", "3 6 9 12") +
                       Vtu::array("polyhedron_to_faces", faces) +
                       Vtu::array("polyhedron_offsets", offsets));
    };
    EXPECT_EQ(lists("0 1 2 3", "4"), "");
    EXPECT_THAT(lists("0 1 2 4", "4"),
                HasSubstr("the array 'face_offsets' has 4 numbers; expected 5, as the last face "
                          "that a polyhedron names is 4"));
    EXPECT_THAT(lists("0 1 2 -3", "4"), HasSubstr("cell 0 of the piece names face -3"));
    EXPECT_THAT(lists("0 1 2 3", "4 4"),
                HasSubstr("'polyhedron_offsets' has 2 numbers; expected 1, one a cell"));
    EXPECT_THAT(lists("0 1 2 3", "5"),
                HasSubstr("'polyhedron_to_faces' has 4 numbers; expected 5, the last of"));
}

TEST(Vtu, ErrorsOfMarksNameTheOffender) {
    Vtu vtu = tetrahedron();
    vtu.fieldData = Vtu::array("espalier:edge_vertices", "0 1", "Int64", 2);
    EXPECT_THAT(vtu.refusal(), HasSubstr("marks need both arrays"));
    vtu.fieldData += Vtu::array("espalier:edge_sharpness", "1 2", "Float64");
    EXPECT_THAT(vtu.refusal(),
                HasSubstr("'espalier:edge_sharpness' has 2 numbers; expected 1, one an edge of "
                          "'espalier:edge_vertices'"));
    vtu.fieldData = Vtu::array("espalier:edge_vertices", "0 1", "Int64", 2) +
                    Vtu::array("espalier:edge_sharpness", "1 2", "Float64", 2);
    EXPECT_THAT(vtu.refusal(), HasSubstr("marks need both arrays"));
    vtu.fieldData = Vtu::array("espalier:edge_vertices", "0 4", "Int64", 2) +
                    Vtu::array("espalier:edge_sharpness", "1", "Float64");
    EXPECT_THAT(vtu.refusal(), HasSubstr("a mark names vertex 4; there are 4"));
    vtu.fieldData = Vtu::array("espalier:edge_vertices", "1 1", "Int64", 2) +
                    Vtu::array("espalier:edge_sharpness", "1", "Float64");
    EXPECT_THAT(vtu.refusal(), HasSubstr("a mark names edge (1, 1), which does not exist"));
    vtu.fieldData = Vtu::array("espalier:edge_vertices", "0 1 2 3", "Int64", 2) +
                    Vtu::array("espalier:edge_sharpness", "1 nan", "Float64");
    EXPECT_THAT(vtu.refusal(),
                HasSubstr("value 1 of 'espalier:edge_sharpness', counted from 0, is NaN"));
    Vtu ofVertices;
    ofVertices.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(),
                     Vtu::array("espalier:vertex_sharpness", "-1 10 nan 0", "Float64"));
    EXPECT_THAT(ofVertices.refusal(),
                HasSubstr("value 2 of 'espalier:vertex_sharpness', counted from 0, is NaN"));
}

/// The exception is still a TopologyError, so that programs can query its cause.
TEST(Vtu, TopologyErrorsKeepTheirCauseAndNameTheFile) {
    const TemporaryFolder folder;
    putLatticeFile(folder / "open.vtu",
                   Vtu()
                       .piece({4, 2}, kTetrahedronPoints,
                              cells("0 1 2 3 0 1 2 3", "4 8", "10 42") +
                                  Vtu::array("faces", "3 3 0 2 1 3 0 1 3 3 1 2 3") +
                                  Vtu::array("faceoffsets", "-1 13"))
                       .text());
    const auto error = topologyErrorOf([&] { io::readLattice(folder / "open.vtu"); });
    EXPECT_EQ(error.cause(), far::TopologyCause::OpenCell);
    EXPECT_EQ(error.entity(), (Entity{3, 1}));
    EXPECT_THAT(error.what(), StartsWith((folder / "open.vtu").string() + ": cell 1 is open: "));
}

TEST(Vtu, OtherFilesAreRefused) {
    const auto refusal = [](const std::string& text) { return refusalOf("a.vtu", text); };
    EXPECT_THAT(refusal(""), HasSubstr("it has no VTKFile element"));
    EXPECT_THAT(refusal("<a/>"), HasSubstr("it has no VTKFile element"));
    EXPECT_THAT(refusal("<VTKFile type=\"PolyData\"><PolyData/></VTKFile>"),
                HasSubstr("holds 'PolyData'; expected UnstructuredGrid"));
    EXPECT_THAT(refusal("<VTKFile type=\"UnstructuredGrid\"></VTKFile>"),
                HasSubstr("has no UnstructuredGrid element"));
    EXPECT_THAT(refusal("<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n</Unstr>"),
                StartsWith(":3: is not well-formed XML"));
    Vtu vtu = tetrahedron();
    vtu.fileAttributes = "byte_order=\"Middle\"";
    EXPECT_THAT(vtu.refusal(), HasSubstr("byte_order is 'Middle'; expected LittleEndian or Big"));
    vtu.fileAttributes = "header_type=\"UInt16\"";
    EXPECT_THAT(vtu.refusal(), HasSubstr("header_type is 'UInt16'; expected UInt32 or UInt64"));
}

TEST(Vtu, OnlyCommentsMayBeOutsideOfTheFileElement) {
    const std::string text = tetrahedron().text();
    const auto refusal = [](const std::string& file) { return refusalOf("a.vtu", file); };
    EXPECT_EQ(refusal("<?xml version=\"1.0\"?>\n<!-- a -->\n" + text + "\n<!-- b -->\n"), "");
    const auto line = ":" + std::to_string(std::count(text.begin(), text.end(), '\n') + 2) + ": ";
    for (const std::string more : {"more", "<VTKFile/>", "<a></a>"})
        EXPECT_THAT(refusal(text + "\n" + more + "\n"),
                    StartsWith(line + "there is more than a VTKFile element"))
            << more;
    EXPECT_THAT(refusal("more" + text), StartsWith(":1: there is more than a VTKFile element"));
    EXPECT_THAT(refusal(text + "\n" + std::string(1, '\0') + "more"),
                StartsWith(line + "is not well-formed XML: it holds a byte 0"));
}

/// Names that XML can hold are read back. Other names would make a file that VTK cannot read.
TEST(Vtu, WritesOnlyNamesThatXmlCanHold) {
    Lattice lattice = tetrahedron().read();
    const auto withName = [&](const std::string& name) {
        lattice.attributes = {{name, 1, {1, 2, 3, 4}}};
        return lattice;
    };
    for (const std::string name : {"a\tb\nc\rd", "\xEF\xBF\xBD", "\xF0\x9F\x8C\xB2", "\x7F<&\">"})
        EXPECT_EQ(latticeOf("a.vtu", writtenLattice("a.vtu", withName(name))).attributes[0].name,
                  name);
    for (const std::string name :
         {"a\x01", "a\x1F", "\xEF\xBF\xBE", "\xEF\xBF\xBF", "\xFF", "\xED\xA0\x80"})
        EXPECT_THAT([&] { writtenLattice("a.vtu", withName(name)); },
                    ThrowsMessage<io::FileError>(AllOf(HasSubstr("has a name that XML cannot hold"),
                                                       HasSubstr(inQuotes(name)))));
}

TEST(Vtu, OtherCompressorsAreRefusedIfUsed) {
    Vtu vtu = tetrahedron();
    vtu.fileAttributes = "compressor=\"vtkLZ4DataCompressor\"";
    EXPECT_EQ(vtu.refusal(), "");
    vtu.pieces = "";
    vtu.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(),
              "<DataArray type=\"Int8\" Name=\"x\" format=\"binary\">AAAA</DataArray>");
    EXPECT_THAT(vtu.refusal(), HasSubstr("'x' is compressed with 'vtkLZ4DataCompressor'; only"));
}

TEST(Vtu, AppendedDataIsChecked) {
    Vtu vtu;
    vtu.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(),
              "<DataArray type=\"UInt8\" Name=\"x\" format=\"appended\" offset=\"4\"/>");
    EXPECT_THAT(vtu.refusal(),
                HasSubstr("'x' begins at offset 4 of the appended data, which have 0"));
    // A 32-bit header, 4, and four bytes; the last two look like the end of the element.
    vtu.tail = std::string("<AppendedData encoding=\"raw\">\n _1234\4\0\0\0\1\2</", 45) +
               "\n</AppendedData>\n";
    EXPECT_EQ(vtu.read().integers.at(0).values, (Integers{1, 2, '<', '/'}));
    vtu.tail = "<AppendedData encoding=\"raw\">1234</AppendedData>";
    EXPECT_THAT(vtu.refusal(), HasSubstr("do not begin with '_'"));
    vtu.tail = "<AppendedData encoding=\"hex\">_1234</AppendedData>";
    EXPECT_THAT(vtu.refusal(), HasSubstr("is 'hex'; expected raw or base64"));
    vtu.tail = "<AppendedData encoding=\"raw\">_1234";  // nothing at offset 4
    EXPECT_THAT(vtu.refusal(), HasSubstr("'x' has 0 numbers; expected 4"));
    vtu.tail = "<AppendedData encoding=\"base64\">_1234BAAAAAECPC8=</AppendedData>";
    EXPECT_EQ(vtu.read().integers.at(0).values, (Integers{1, 2, '<', '/'}));
}

/// Some programs write no tag after the data; VTK finds all data by their offsets.
TEST(Vtu, AppendedDataNeedNoEnd) {
    Vtu vtu;
    vtu.piece({4, 1}, kTetrahedronPoints, tetrahedronCells(),
              "<DataArray type=\"UInt8\" Name=\"x\" format=\"appended\" offset=\"0\"/>");
    for (const std::string& data :
         {std::string("raw\">_\4\0\0\0\1\2</", 14), std::string("base64\">_BAAAAAECPC8=")}) {
        vtu.tail = "<AppendedData encoding=\"" + data + "\n";
        const std::string withRootEnd = vtu.text();
        const std::string cut = withRootEnd.substr(0, withRootEnd.rfind("</VTKFile"));
        for (const std::string& text : {withRootEnd, cut, cut + "</AppendedData>"}) {
            EXPECT_EQ(latticeOf("a.vtu", text).integers.at(0).values, (Integers{1, 2, '<', '/'}));
            const auto model = io::readModel("a.vtu", text);
            std::vector<Point3> moved(model->positions().begin(), model->positions().end());
            moved[0][0] -= 1;
            const std::string changed = written(*model, moved);
            EXPECT_EQ(changed.substr(changed.find("<AppendedData")),
                      text.substr(text.find("<AppendedData")));
            EXPECT_EQ(written(*model, model->positions()), text);
        }
        // A file that is cut inside its data.
        EXPECT_NE(refusalOf("a.vtu", cut.substr(0, cut.size() - 4)), "");
    }
}

TEST(Vtu, ClaimedSizesAreCheckedBeforeAllocating) {
    for (const char* claim : {"18446744073709551615", "4000000000", "99999999999999999999", "-1"}) {
        std::string text = tetrahedron().text();
        text.replace(text.find("NumberOfPoints=\"4\"") + 16, 1, claim);
        EXPECT_NE(refusalOf("a.vtu", text), "") << claim;
        text = tetrahedron().text();
        text.replace(text.find("NumberOfCells=\"1\"") + 15, 1, claim);
        EXPECT_NE(refusalOf("a.vtu", text), "") << claim;
        text = tetrahedron().text();
        text.replace(text.find("NumberOfComponents=\"3\"") + 20, 1, claim);
        EXPECT_NE(refusalOf("a.vtu", text), "") << claim;
    }
}

/// Returns an array whose header claims 3 GB, without data: decoding it would give a different
/// error.
std::string claimOf3Gigabytes(const std::string& name, const std::string& type = "Int64",
                              int components = 1) {
    // The header claims 3072 whole blocks of 2^20 bytes.
    std::string header(24, '\0');
    header[1] = 12;
    header[10] = 16;
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
           std::to_string(components) + "\" format=\"binary\">" + io::encodeBase64(header) +
           "</DataArray>\n";
}

TEST(Vtu, ClaimedLengthsAreCheckedBeforeDecoding) {
    const std::string connectivity = Vtu::array("connectivity", "0 1 2 3");
    const std::string offsets = Vtu::array("offsets", "4");
    const std::string types = Vtu::array("types", "42", "UInt8");
    const std::string standard = connectivity + offsets + types;
    const std::string toFaces =
        Vtu::array("polyhedron_to_faces", "0 1 2 3") + Vtu::array("polyhedron_offsets", "4");
    const std::string count = " has 402653184 numbers; expected ";
    const std::pair<std::string, std::string> kCellClaims[] = {
        {connectivity + offsets + claimOf3Gigabytes("types", "UInt8"),
         "'types' has 3221225472 numbers; expected 1, one a cell"},
        {connectivity + claimOf3Gigabytes("offsets") + types,
         "'offsets'" + count + "1, one a cell"},
        {claimOf3Gigabytes("connectivity") + offsets + types,
         "'connectivity'" + count + "4, the last of 'offsets'"},
        {standard + Vtu::array("faces", "0") + claimOf3Gigabytes("faceoffsets"),
         "'faceoffsets'" + count + "1, one a cell"},
        {standard + claimOf3Gigabytes("faces") + Vtu::array("faceoffsets", "17"),
         "'faces'" + count + "17, the last of 'faceoffsets'"},
        {standard + claimOf3Gigabytes("polyhedron_offsets"),
         "'polyhedron_offsets'" + count + "1, one a cell"},
        {standard + Vtu::array("polyhedron_offsets", "4") +
             claimOf3Gigabytes("polyhedron_to_faces"),
         "'polyhedron_to_faces'" + count + "4, the last of 'polyhedron_offsets'"},
        {standard + toFaces + claimOf3Gigabytes("face_offsets"),
         "'face_offsets'" + count + "4, as the last face that a polyhedron names is 3"},
        {standard + toFaces + Vtu::array("face_offsets", "3 6 9 12") +
             claimOf3Gigabytes("face_connectivity"),
         "'face_connectivity'" + count + "12, the last of 'face_offsets'"}};
    for (const auto& [cellArrays, cause] : kCellClaims) {
        Vtu vtu;
        vtu.fileAttributes = "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"";
        vtu.piece({4, 1}, kTetrahedronPoints, cellArrays);
        EXPECT_THAT(vtu.refusal(), HasSubstr(cause));
    }

    Vtu vtu = tetrahedron();
    vtu.fileAttributes = "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"";
    vtu.fieldData = claimOf3Gigabytes("espalier:edge_vertices", "Int64", 2) +
                    claimOf3Gigabytes("espalier:edge_sharpness", "Float64");
    EXPECT_THAT(vtu.refusal(), HasSubstr("'espalier:edge_vertices'" + count +
                                         "at most 12 times 2, as the cells have no more edges"));
    vtu.fieldData = Vtu::array("espalier:edge_vertices", "0 1 1 2", "Int64", 2) +
                    claimOf3Gigabytes("espalier:edge_sharpness", "Float64");
    EXPECT_THAT(vtu.refusal(), HasSubstr("'espalier:edge_sharpness'" + count + "2, one an edge"));
}

/// Some programs write the arrays of Cells with several components.
TEST(Vtu, ComponentsOfListsAreIgnored) {
    const Lattice lattice =
        Vtu()
            .piece({4, 1}, kTetrahedronPoints,
                   Vtu::array("connectivity", "0 1 2 3", "Int64", 4) + Vtu::array("offsets", "4") +
                       Vtu::array("types", "10", "UInt8"))
            .read();
    expectSameLattice(lattice, tetrahedron().read());
    // An older version of the reader took types of two components as two types per cell.
    EXPECT_THAT(Vtu()
                    .piece({4, 1}, kTetrahedronPoints,
                           Vtu::array("connectivity", "0 1 2 3") + Vtu::array("offsets", "4") +
                               Vtu::array("types", "42 10", "UInt8", 2) +
                               Vtu::array("faces", "4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3") +
                               Vtu::array("faceoffsets", "17 -1"))
                    .refusal(),
                HasSubstr("the array 'types' has 2 numbers; expected 1, one a cell"));
}

/// Marks of every edge are read, for cells of every kind: the upper bound of their number is large
/// enough.
TEST(Vtu, AllEdgesMayBeMarked) {
    for (Lattice lattice : {boxLattice(), mixedLattice(), polyhedralLattice()}) {
        for (Index edge = 0; edge < lattice.complex.count(1); ++edge) {
            const auto ends = lattice.complex.relation(1, 0)[edge];
            lattice.marks.edges.push_back({{ends[0], ends[1]}, 1.5});
        }
        const Lattice got = latticeOf("a.vtu", writtenLattice("a.vtu", lattice));
        EXPECT_EQ(got.marks.edges.size(), lattice.marks.edges.size());
    }
}

/// Elements are nested as deeply as a file of a few megabytes allows. The reader must not recurse.
TEST(Vtu, DeeplyNestedElementsAreRead) {
    std::string deep;
    for (int i = 0; i < 200000; ++i) deep += "<a>";
    for (int i = 0; i < 200000; ++i) deep += "</a>";
    Vtu vtu = tetrahedron();
    vtu.pieces.insert(vtu.pieces.find("<PointData>"), deep);
    EXPECT_EQ(vtu.refusal(), "");
}

TEST(Vtu, NamesAreEscaped) {
    Lattice lattice = boxLattice();
    lattice.attributes = {{"<a href=\"b\">&amp;\n'", 1, std::vector<double>(12, 1.0)}};
    const Lattice got = latticeOf("a.vtu", writtenLattice("a.vtu", lattice));
    EXPECT_EQ(got.attributes.at(0).name, lattice.attributes[0].name);
}

TEST(Vtu, StandardCellsHaveTheirOwnTypes) {
    const std::string text = writtenLattice("a.vtu", mixedLattice(), {io::VtuEncoding::Ascii});
    EXPECT_THAT(text, HasSubstr("Name=\"types\" format=\"ascii\">\n          12 14 13 10\n"));
    EXPECT_EQ(text.find("faces"), std::string::npos);
    const std::string other =
        writtenLattice("a.vtu", polyhedralLattice(), {io::VtuEncoding::Ascii});
    EXPECT_THAT(other, HasSubstr("Name=\"types\" format=\"ascii\">\n          42 12\n"));
    // The face stream has the number of faces, 7, and for each face its size and its vertices: 1 +
    // 2 · 6 + 5 · 5 = 38.
    EXPECT_THAT(other, HasSubstr("Name=\"faceoffsets\" format=\"ascii\">\n          38 -1\n"));
}

}  // namespace
}  // namespace espalier::test
