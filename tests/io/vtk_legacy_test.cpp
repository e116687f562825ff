// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/topology_match.h>
#include <espalier/io/model.h>

#include <algorithm>
#include <cmath>

#include "lattice_samples.h"

namespace espalier::test {
namespace {

const std::string kHead = "# vtk DataFile Version 2.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\n";
const std::string kPoints = "POINTS 4 float\n0 0 0 1 0 0\n0 1 0 0 0 1\n";
const std::string kCells = "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n";

TEST(VtkLegacy, ReadsATetrahedron) {
    const Lattice lattice = latticeOf("a.vtk", kHead + kPoints + kCells);
    EXPECT_EQ(lattice.complex.count(0), 4);
    EXPECT_EQ(lattice.complex.count(2), 4);
    EXPECT_EQ(lattice.positions[3], (Point3{0, 0, 1}));
}

/// Gmsh 4.8 writes the vertices, lines and surfaces of a model before its volumes.
TEST(VtkLegacy, CellsOfLowerDimensionAreSkippedAndCounted) {
    const std::string bytes =
        kHead + "POINTS 6 double\n0 0 0 1 0 0\n9 9 9 0 1 0 0 0 1\n1 1 1\n" +
        "CELLS 8 30\n1 0\n1 1\n2 0 1\n3 0 1 3\n4 0 1 2 3\n3 0 1 4\n4 0 1 3 4\n4 1 3 4 5\n"
        "CELL_TYPES 8\n1\n1\n3\n5\n9\n5\n10\n10\n";
    const auto read = [](const std::string& name, const std::string& text, io::ReadNotes& notes) {
        return io::readLattice(name, text, &notes);
    };
    io::ReadNotes notes;
    const Lattice lattice = read("a.vtk", bytes, notes);
    EXPECT_EQ(lattice.complex.count(3), 2);
    EXPECT_EQ(lattice.complex.count(0), 5);
    EXPECT_EQ(notes, (io::ReadNotes{{2}, {2, 1, 3}}));
    // The same in the layout of version 5.
    std::string newer = bytes;
    newer.replace(newer.find("2.0"), 3, "5.1");
    const std::size_t cells = newer.find("CELLS"), types = newer.find("CELL_TYPES");
    newer.replace(cells, types - cells,
                  "CELLS 9 20\nOFFSETS vtktypeint64\n0 1 2 4 7 11 14 18 22\n"
                  "CONNECTIVITY vtktypeint64\n0 1 0 1 0 1 3 0 1 2 3 0 1 4 0 1 3 4 1 3 4 5\n");
    newer.replace(newer.find("9 20"), 4, "9 22");
    io::ReadNotes notesOfNewer;
    EXPECT_EQ(far::topologyDifference(read("b.vtk", newer, notesOfNewer).complex, lattice.complex),
              std::nullopt);
    EXPECT_EQ(notesOfNewer, notes);
}

TEST(VtkLegacy, AFileWithoutVolumesSaysWhatItHolds) {
    const std::string surface = kHead + kPoints + "CELLS 2 7\n3 0 1 2\n2 0 1\nCELL_TYPES 2\n5 3\n";
    EXPECT_THAT([&] { latticeOf("a.vtk", surface); },
                ThrowsMessage<far::TopologyError>(HasSubstr(
                    "a.vtk: there is no cell of a volume; the file has 0 vertex cells, 1 lines and "
                    "1 surface cells, which are not cells of a lattice")));
}

TEST(VtkLegacy, ErrorsCountSkippedCells) {
    EXPECT_THAT(
        refusalOf("a.vtk", kHead + kPoints + "CELLS 2 8\n2 0 1\n4 0 1 2 3\nCELL_TYPES 2\n3 24\n",
                  [](const auto& path) { io::readLattice(path); }),
        HasSubstr("cell 1 is of VTK's type 24"));
}

/// Pentagonal and hexagonal prisms: VTK's lower end is anticlockwise seen from the upper one.
TEST(VtkLegacy, PrismsArePolyhedra) {
    for (const int sides : {5, 6}) {
        std::string text = kHead + concat("POINTS ", 2 * sides, " double\n");
        std::string cell = concat(2 * sides);
        for (int i = 0; i < 2 * sides; ++i) {
            const double angle = 2 * 3.14159265358979 * i / sides;
            text += concat(std::cos(angle), " ", std::sin(angle), i < sides ? " 0\n" : " 1\n");
            cell += concat(" ", i);
        }
        text += concat("CELLS 1 ", 2 * sides + 1, "\n", cell, "\nCELL_TYPES 1\n",
                       sides == 5 ? 15 : 16, "\n");
        const Lattice lattice = latticeOf("a.vtk", text);
        EXPECT_EQ(lattice.complex.count(0), 2 * sides);
        EXPECT_EQ(lattice.complex.count(1), 3 * sides);
        EXPECT_EQ(lattice.complex.count(2), sides + 2);
        const auto model = io::readModel("a.vtk", text);
        const io::ModelCells cells = model->readCells();
        EXPECT_EQ(cells.volume.cellCount(), 1);
        EXPECT_EQ(cells.volume.faceCount(), sides + 2);
        // The upper end is anticlockwise seen from above.
        for (Index face = 0; face < cells.volume.faceCount(); ++face) {
            const auto loop = cells.volume.face(face);
            if (std::ssize(loop) == sides && *std::min_element(loop.begin(), loop.end()) == sides)
                EXPECT_EQ((loop[1] - loop[0] + sides) % sides, 1);
        }
        EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints +
                                           concat("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n",
                                                  sides == 5 ? 15 : 16, "\n")),
                    HasSubstr(concat("cell 0 is a prism of ", sides,
                                     " sides and has 4 vertices; expected ", 2 * sides)));
    }
}

std::string gridText(const std::string& dimensions, int pointCount) {
    std::string text =
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS " + dimensions +
        concat("\nPOINTS ", pointCount, " float\n");
    for (int i = 0; i < pointCount; ++i) text += concat(i % 3, " ", i / 3 % 2, " ", i / 6, "\n");
    return text;
}

TEST(VtkLegacy, StructuredGridsAreLattices) {
    const std::string text =
        gridText("3 2 2", 12) +
        "CELL_DATA 2\nSCALARS c int\nLOOKUP_TABLE default\n1 2\nPOINT_DATA 12\nSCALARS p double\n"
        "LOOKUP_TABLE default\n0 1 2 3 4 5 6 7 8 9 10 11\n";
    const Lattice lattice = latticeOf("a.vtk", text);
    EXPECT_EQ(lattice.complex.count(3), 2);
    EXPECT_EQ(lattice.complex.count(2), 11);
    EXPECT_EQ(lattice.attributes.at(0).values.at(11), 11);
    // The same as an unstructured grid.
    std::string cells = kHead + text.substr(text.find("POINTS"));
    cells = cells.substr(0, cells.find("CELL_DATA")) +
            "CELLS 2 18\n8 0 1 4 3 6 7 10 9\n8 1 2 5 4 7 8 11 10\nCELL_TYPES 2\n12 12\n";
    EXPECT_EQ(far::topologyDifference(latticeOf("b.vtk", cells).complex, lattice.complex),
              std::nullopt);
    EXPECT_EQ(io::readModel("a.vtk", text)->readCells().volume.cellCount(), 2);

    for (const auto& sample :
         {std::pair{"3 2 1", "0 lines and 2 surface cells"}, std::pair{"6 1 1", "5 lines and 0"}})
        EXPECT_REFUSED(far::TopologyError, sample.second,
                       io::readLattice("a.vtk", gridText(sample.first, 6)));
    for (const auto& sample :
         {std::pair{"2 2 2", "there are 12 points, but DIMENSIONS has 2 × 2 × 2"},
          std::pair{"3 2 -2", "a.vtk:5: "}, std::pair{"4294967296 4294967296 3", "DIMENSIONS has"}})
        EXPECT_REFUSED(io::FileError, sample.second,
                       io::readLattice("a.vtk", gridText(sample.first, 12)));
    EXPECT_REFUSED(io::FileError, "holds 'rectilinear_grid', which has no list of points",
                   io::readLattice("a.vtk",
                                   "# vtk DataFile Version 3.0\nt\nASCII\n"
                                   "DATASET RECTILINEAR_GRID\nDIMENSIONS 2 2 2\n"));
    EXPECT_REFUSED(io::FileError, "'cells' is not a keyword that can stand here",
                   io::readLattice("a.vtk", gridText("3 2 2", 12) + "CELLS 1 2\n1 0\n"));
}

TEST(VtkLegacy, KeywordsMayBeInUpperOrLowerCase) {
    const Lattice lattice = latticeOf(
        "a.vtk",
        "# VTK DataFile version 4.2\r\na title\r\nascii\r\ndataset unstructured_grid\r\n"
        "points 4 FLOAT\r\n0 0 0 1 0 0 0 1 0 0 0 1\r\ncells 1 5 4 0 1 2 3 cell_types 1 10");
    EXPECT_EQ(lattice.complex.count(3), 1);
}

TEST(VtkLegacy, PointArraysBecomeAttributes) {
    const Lattice lattice =
        latticeOf("a.vtk", kHead + kPoints + kCells +
                               "CELL_DATA 1\n"
                               "SCALARS material int\nLOOKUP_TABLE default\n7\n"
                               "FIELD more 1\nx 2 1 float\n1 2\n"
                               "POINT_DATA 4\n"
                               "SCALARS heat float\nLOOKUP_TABLE mine\n0.1 2 3 4\n"
                               "LOOKUP_TABLE mine 2\n0 0 0 1 1 1 1 1\n"
                               "SCALARS pair double 2\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8\n"
                               "COLOR_SCALARS colour 3\n0 0 0 1 1 1 0 0 0 1 1 1\n"
                               "VECTORS flow float\n1 2 3 4 5 6 7 8 9 10 11 12\n"
                               "NORMALS n%20x float\n1 0 0 1 0 0 1 0 0 1 0 0\n"
                               "TEXTURE_COORDINATES uv 2 float\n1 2 3 4 5 6 7 8\n"
                               "GLOBAL_IDS ids vtkIdType\n1 2 3 4\n"
                               "METADATA\nINFORMATION 1\nNAME a LOCATION b\nDATA 1 POINTS\n\n"
                               "FIELD FieldData 4\n"
                               "names 1 4 string\none\n\nthree\nfour\n"
                               "flags 1 4 bit\n1 0 1 0\n"
                               "METADATA\nCOMPONENT_NAMES\nX\n\n"
                               "NULL_ARRAY\n"
                               "last 1 4 unsigned_char\n1 2 3 255\n");
    ASSERT_EQ(lattice.attributes.size(), 5u);
    std::vector<std::string> names;
    for (const auto& attribute : lattice.attributes) names.push_back(attribute.name);
    EXPECT_THAT(names, ElementsAre("heat", "pair", "flow", "n x", "uv"));
    EXPECT_THAT(lattice.attributes[0].values, ElementsAre(double{0.1f}, 2, 3, 4));
    EXPECT_EQ(lattice.attributes[1].components, 2);
    EXPECT_EQ(lattice.attributes[2].components, 3);
    EXPECT_THAT(lattice.attributes[4].values, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
    ASSERT_EQ(lattice.integers.size(), 1u);
    EXPECT_EQ(lattice.integers[0].name, "last");
    EXPECT_EQ(lattice.integers[0].type, IntegerType::UInt8);
    EXPECT_THAT(lattice.integers[0].values, ElementsAre(1, 2, 3, 255));
}

/// Tries strings whose length is stored in 1 byte (up to 63), 2, 4 and 8 bytes.
TEST(VtkLegacy, BinaryStringsAreSkipped) {
    std::string head = kHead;
    head.replace(head.find("ASCII"), 5, "BINARY");
    std::string points = "POINTS 4 unsigned_char\n";
    points += std::string("\0\0\0\1\0\0\0\1\0\0\0\1", 12);
    std::string cells = "\nCELLS 1 5\n";
    cells += std::string("\0\0\0\4\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\3", 20);
    cells += std::string("\nCELL_TYPES 1\n\0\0\0\12", 18);
    std::string data = "\nPOINT_DATA 4\nFIELD f 3\nnames 1 4 string\n";
    data +=
        "\xc3"
        "abc";
    data += std::string("\x80\3", 2) + "\n\n\n";
    data += std::string("\x40\0\0\3", 4) + "abc";
    data += std::string("\0\0\0\0\0\0\0\3", 8) + "abc";
    data += std::string("\nbits 1 4 bit\n\xa0\nlast 1 4 short\n\0\1\0\2\0\3\xff\xff\n", 40);
    const Lattice lattice = latticeOf("a.vtk", head + points + cells + data);
    EXPECT_EQ(lattice.positions[1], (Point3{1, 0, 0}));
    ASSERT_EQ(lattice.integers.size(), 1u);
    EXPECT_EQ(lattice.integers[0].name, "last");
    EXPECT_THAT(lattice.integers[0].values, ElementsAre(1, 2, 3, -1));
    // A string that claims more bytes than the file has.
    data.replace(data.find("\xc3"
                           "abc"),
                 4, "\x3f\xff\xff\xff\xff\xff\xff\xff");
    EXPECT_THAT(refusalOf("a.vtk", head + points + cells + data), HasSubstr("expected a string"));
}

TEST(VtkLegacy, Version5HasOffsetsAndPolyhedraAsFaceStreams) {
    std::string head = kHead;
    head.replace(head.find("2.0"), 3, "5.1");
    const std::string polyhedron =
        "CELLS 3 21\nOFFSETS vtktypeint64\n0 17 21\nCONNECTIVITY vtktypeint64\n"
        "4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3  1 0 2 4\nCELL_TYPES 2\n42\n10\n";
    const std::string points = "POINTS 5 float\n0 0 0 1 0 0 0 1 0 0 0 1 0 0 -1\n";
    const Lattice lattice = latticeOf("a.vtk", head + points + polyhedron);
    EXPECT_EQ(lattice.complex.count(3), 2);
    EXPECT_EQ(lattice.complex.count(2), 7);
    const std::string before =
        "CELLS 2 23\n17 4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3\n4 1 0 2 4\n"
        "CELL_TYPES 2\n42\n10\n";
    expectSameLattice(latticeOf("a.vtk", kHead + points + before), lattice);
}

TEST(VtkLegacy, ErrorsNameTheOffender) {
    EXPECT_THAT(refusalOf("a.vtk", ""), StartsWith(":1: is not a legacy VTK file"));
    EXPECT_THAT(refusalOf("a.vtk", "# vtk DataFile Version 6.0\n"),
                StartsWith(":1: is of version '6.0'"));
    EXPECT_THAT(refusalOf("a.vtk", "# vtk DataFile Version 2.0\nt\nTEXT\n"),
                StartsWith(":3: expected ASCII or BINARY, got 'text'"));
    EXPECT_THAT(refusalOf("a.vtk", "# vtk DataFile Version 2.0\nt\nASCII\nDATASET POLYDATA\n"),
                StartsWith(": holds a surface (POLYDATA) without cells of a volume; a lattice"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + "POINTS 1 string\n0 0 0\n"),
                HasSubstr("'string' is not a type of numbers"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + "POINTS 4 float\n0 0 0 1 0 0\n0 1 0 0 x 1\n"),
                StartsWith(":7: 'x' is not a number"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + "VERTICES 3"),
                StartsWith(":5: 'vertices' is not a keyword"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints + "CELLS 1 4\n4 0 1 2\nCELL_TYPES 1\n10\n"),
                HasSubstr("the numbers of CELLS end inside cell 0"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints + "CELLS 1 6\n4 0 1 2 3 4\nCELL_TYPES 1\n10\n"),
                HasSubstr("CELLS has 6 numbers, of which 5 belong to cells"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints + "CELLS 1 5\n4 0 1 2 3\n"),
                HasSubstr("has 1 cells and 0 cell types"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints + "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n24\n"),
                HasSubstr("cell 0 is of VTK's type 24"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints + "CELLS 1 5\n4 0 1 2 9\nCELL_TYPES 1\n10\n"),
                HasSubstr("cell 0 names vertex 9; there are 4"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints + kCells + "POINT_DATA 5\n"),
                HasSubstr("the data are for 5 points, but there are 4"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints + kCells + "POINT_DATA 4\nVOLTAGE x float\n"),
                HasSubstr("'voltage' is not a keyword"));
    EXPECT_THAT(refusalOf("a.vtk",
                          kHead + kPoints + kCells + "POINT_DATA 4\nFIELD f 1\nx 1 3 int\n1 2 3\n"),
                HasSubstr("'x' has 3 tuples of 1 for 4 points"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints + kCells + "POINT_DATA 4\nSCALARS x int 1.5\n"),
                HasSubstr("'1.5' is not a number of components"));
}

TEST(VtkLegacy, ClaimedSizesAreCheckedBeforeAllocating) {
    for (const std::string claim : {"18446744073709551615", "6148914691236517206", "4000000000"}) {
        for (const std::string& head : {kHead, std::string(kHead).replace(37, 5, "BINARY")}) {
            EXPECT_NE(refusalOf("a.vtk", head + "POINTS " + claim + " float\n0 0 0"), "");
            EXPECT_NE(refusalOf("a.vtk", head + "CELLS 1 " + claim + "\n0 0 0"), "");
            EXPECT_NE(refusalOf("a.vtk", head + "CELLS " + claim + " 1\n0000"), "");
            EXPECT_NE(refusalOf("a.vtk", head + "CELL_TYPES " + claim + "\n0 0 0"), "");
            EXPECT_NE(refusalOf("a.vtk", head + "FIELD f 1\nx " + claim + " 2 int\n1 2"), "");
            EXPECT_NE(refusalOf("a.vtk", head + "FIELD f 1\nx 2 " + claim + " string\n1 2"), "");
            EXPECT_NE(refusalOf("a.vtk", head + "FIELD f " + claim + "\n"), "");
            EXPECT_NE(refusalOf("a.vtk", head + "FIELD f 1\nx 1 " + claim + " bit\n1 2"), "");
        }
    }
}

TEST(VtkLegacy, InvalidMarksAreRefused) {
    const auto withField = [](const std::string& vertices, const std::string& sharpness) {
        return kHead + "FIELD FieldData 2\nespalier:edge_vertices 2 " + vertices +
               "\nespalier:edge_sharpness 1 " + sharpness + "\n" + kPoints + kCells;
    };
    EXPECT_EQ(latticeOf("a.vtk", withField("1 int\n0 3", "1 double\n10")).marks.edges,
              (std::vector<far::Marks::Edge>{{{0, 3}, far::kInfinitelySharp}}));
    EXPECT_THAT(refusalOf("a.vtk", withField("2 int\n0 3 1 2", "1 double\n10")),
                HasSubstr("has marks of 1 edges, and 4 vertices of marked edges"));
    EXPECT_THAT(refusalOf("a.vtk", withField("1 int\n0 4", "1 double\n10")),
                HasSubstr("a mark names vertex 4; there are 4"));
    EXPECT_THAT(refusalOf("a.vtk", withField("1 double\n0 nan", "1 double\n10")),
                HasSubstr("a mark names vertex nan"));
    EXPECT_THAT(refusalOf("a.vtk", withField("1 int\n0 3", "1 double\nnan")),
                HasSubstr("value 0 of 'espalier:edge_sharpness', counted from 0, is NaN"));
    EXPECT_THAT(refusalOf("a.vtk", kHead + kPoints + kCells + "POINT_DATA 4\nFIELD f 1\n" +
                                       "espalier:vertex_sharpness 1 4 double\n0 -1 nan 2\n"),
                HasSubstr("value 2 of 'espalier:vertex_sharpness', counted from 0, is NaN"));
}

/// Compares the whole file for a tetrahedron with all kinds of marks.
TEST(VtkLegacy, WritesAsciiVersion3) {
    Lattice lattice = latticeOf("a.vtk", kHead + kPoints + kCells);
    lattice.positions[1][0] = 0.1;
    lattice.marks.edges = {{{0, 1}, far::kInfinitelySharp}};
    lattice.marks.vertices = {{2, 0}};
    lattice.attributes = {{"u v", 2, {1, 2, 3, 4, 5, 6, 7, 8}}};
    EXPECT_EQ(writtenLattice("a.vtk", lattice),
              "# vtk DataFile Version 3.0\nEspalier lattice\nASCII\nDATASET UNSTRUCTURED_GRID\n"
              "FIELD FieldData 2\nespalier:edge_vertices 2 1 int\n0 1\n"
              "espalier:edge_sharpness 1 1 double\n10\n"
              "POINTS 4 double\n0 0 0\n0.1 0 0\n0 1 0\n0 0 1\n"
              "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n"
              "POINT_DATA 4\nFIELD FieldData 2\nu%20v 2 4 double\n1 2\n3 4\n5 6\n7 8\n"
              "espalier:vertex_sharpness 1 4 double\n-1\n-1\n0\n-1\n");
}

}  // namespace
}  // namespace espalier::test
