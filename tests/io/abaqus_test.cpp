// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/second_order_cells.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>
#include <io/meshes/abaqus_elements.h>

#include <map>
#include <tuple>

#include "support/test.h"

namespace espalier::io {
namespace {

/// The mesh of mesh_samples.h with the numbers 1, 4, 7 … of its nodes.
std::string sampleAbaqus() {
    std::string text = "** a comment\n*HEADING\nNode 1, 2\n*Node, nset=all\n";
    const auto number = [](int point) { return std::to_string(3 * point + 1); };
    const std::vector<Point3> points = samplePoints();
    for (int i = 0; i < 12; ++i) {
        text += number(i);
        for (const double coordinate : points[static_cast<std::size_t>(i)])
            text += ",  " + formatNumber(coordinate);
        text += i == 3 ? ",\r\n** between\n" : "\n";
    }
    const char* types[] = {"C3D8R", "c3d5", "C3D6", "DC3D4"};
    for (std::size_t cell = 0; cell < 4; ++cell) {
        text += concat("*ELEMENT, ELSET=a b,\n Type = ", types[cell], "\n", cell + 1);
        std::size_t count = 0;
        // Long elements go on in the next line.
        for (const int point : sampleCells()[cell])
            text += (++count == 5 && cell == 0 ? ",\n" : ", ") + number(point);
        text += "\n";
    }
    return text +
           "*element, type=S4R5\n7, 1, 10, 7, 4\n*element, type=STRI3\n8, 13, 16, 25\n"
           "*Element, type=B31\n9, 1, 4\n*Step\n*Static\n1., 1.\n*End Step\n";
}

TEST(Abaqus, MeshesAreReadAndWrittenInPlace) {
    const std::string text = sampleAbaqus();
    const auto model = readModel("a.inp", text);
    EXPECT_EQ(copyOf(model->positions()), samplePoints());
    EXPECT_THAT(model->notes(), IsEmpty());
    EXPECT_EQ(model->checkTarget("b.inp"), "");
    EXPECT_EQ(written(*model, model->positions()), text);
    const ModelCells volume = model->readCells();
    EXPECT_EQ(volume.volume.cellCount(), 4);
    EXPECT_EQ(volume.unknownElements, 0);
    EXPECT_EQ(model->readSurface().faces.count(), 2u);
    EXPECT_EQ(readLattice("a.inp", text).complex.count(3), 4);
    auto moved = copyOf(model->positions());
    moved[11] = {0.1, -7, 3};
    std::string expected = text;
    expected.replace(expected.find("34,  3,  1,  3"), 14, "34,  0.1,  -7,  3");
    EXPECT_EQ(written(*model, moved), expected);
}

/// Each part numbers its nodes on its own.
TEST(Abaqus, PartsHaveTheirOwnNumbers) {
    const std::string nodes = "*Node\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1.5d0, 0\n4, 0, 0, 1\n";
    const std::string part = "*Element, type=C3D4\n1, 1, 2, 3, 4\n" + nodes + "*End Part\n";
    const std::string text =
        "*Part, name=A\n" + part + "*Part, name=B\n" + part +
        "*Assembly, name=all\n*Instance, name=A-1, part=A\n*End Instance\n"
        "*Instance, name=B-1, part=B\n0., 0., 5.\n*End Instance\n*Node\n1, 0, 0, 9\n"
        "*Element, type=SPRING1\n1, A-1.3\n*End Assembly\n";
    const auto model = readModel("a.inp", text);
    ASSERT_EQ(model->positions().size(), 9u);
    EXPECT_EQ(model->positions()[2][1], 1.5);
    const auto mesh = model->readCells().volume;
    EXPECT_THAT(mesh.corners(0), ElementsAre(0, 1, 2, 3));
    EXPECT_THAT(mesh.corners(1), ElementsAre(4, 5, 6, 7));
    EXPECT_THAT(model->notes(),
                ElementsAre("took the nodes as their parts have them: 1 instance is moved by a "
                            "translation or a rotation"));
}

TEST(Abaqus, MeshesOfTwoDimensionsHaveNoZ) {
    const std::string text =
        "*NODE\n1, 0, 0\n2, 1, 0\n3, 0, 1\n*ELEMENT, TYPE=CPS3\n1, 1, 2, 3\n*NODE\n4, 0, 0,\n";
    const auto model = readModel("a.inp", text);
    auto moved = copyOf(model->positions());
    moved[1][0] = 2;
    EXPECT_THAT(written(*model, moved), HasSubstr("2, 2, 0\n"));
    moved[3][2] = 1;
    EXPECT_REFUSED(Error, "the mesh is of two dimensions", written(*model, moved));
}

/// CalculiX and Abaqus read such entries as 0.
TEST(Abaqus, MissingCoordinatesAreZero) {
    const std::string text = "*NODE\n1, 5\n2, , 1,\n3, 1, ,0.5\n4, 0, 0, 2\n5,\n6, 1, 2, 3, 4\n";
    const auto model = readModel("a.inp", text);
    EXPECT_EQ(
        copyOf(model->positions()),
        (std::vector<Point3>{{5, 0, 0}, {0, 1, 0}, {1, 0, 0.5}, {0, 0, 2}, {0, 0, 0}, {1, 2, 3}}));
    EXPECT_EQ(written(*model, model->positions()), text);
    const std::vector<Point3> moved = {{5, 0, 7},   {0.25, 1, -1}, {1, 3, 0.5},
                                       {0, 0.5, 2}, {0, 8, 0},     {1, 2, 4}};
    const std::string expected =
        "*NODE\n1, 5, 0, 7\n2, 0.25, 1, -1\n3, 1, 3,0.5\n4, 0, 0.5, 2\n5, 0, 8\n6, 1, 2, 4, 4\n";
    EXPECT_EQ(written(*model, moved), expected);
    EXPECT_EQ(copyOf(readModel("a.inp", expected)->positions()), moved);
}

TEST(Abaqus, TypesOfElements) {
    const auto expect = [](std::string_view name, int dimension, std::size_t nodes,
                           bool isCurved = false) {
        const AbaqusElement type = abaqusElement(name);
        EXPECT_EQ(type.dimension, dimension) << name;
        EXPECT_EQ(type.nodes, nodes) << name;
        EXPECT_EQ(type.isCurved, isCurved) << name;
    };
    expect("C3D8", 3, 8);
    expect("c3d8rht", 3, 8);
    expect("C3D4H", 3, 4);
    expect("C3D10M", 3, 10, true);
    expect("C3D15", 3, 15, true);
    expect("C3D20R", 3, 20, true);
    expect("SC8R", 3, 8);
    expect("AC3D6", 3, 6);
    expect("S3", 2, 3);
    expect("S4R", 2, 4);
    expect("S8R5", 2, 8, true);
    expect("S9R5", 2, 9, true);
    expect("STRI3", 2, 3);
    expect("STRI65", 2, 6, true);
    expect("CPS4R", 2, 4);
    expect("CPEG8", 2, 8, true);
    expect("CAX6", 2, 6, true);
    expect("M3D4R", 2, 4);
    expect("R3D3", 2, 3);
    expect("B31", 1, 0);
    expect("T3D2", 1, 0);
    expect("SPRINGA", 1, 0);
    expect("D", 1, 0);
    expect("MASS", 0, 0);
    for (const char* name : {"C3D27", "C3D15V", "COH3D8", "GK3D8", "C3D", "U1", "CPS5", ""})
        expect(name, -1, 0);
}

/// Abaqus has VTK's order.
TEST(Abaqus, ElementsOfSecondOrder) {
    const auto read = [](const std::string& type, int count) {
        std::string nodes = "*NODE\n", element = "*ELEMENT, TYPE=" + type + "\n1";
        for (int i = 1; i <= count; ++i) {
            nodes += concat(i, ", ", i, ", ", i * i, ", ", i * i * i, "\n");
            element += (i % 16 == 0 ? ",\n" : ", ") + std::to_string(i);
        }
        return readModel("a.inp", nodes + element + "\n")->readCells();
    };
    using Middles = std::vector<std::array<Index, 3>>;
    for (const auto& [type, count, middles] :
         {std::tuple("C3D10", 10, Middles{{4, 0, 1}, {6, 2, 0}, {7, 0, 3}, {9, 2, 3}}),
          {"C3D15", 15, {{6, 0, 1}, {8, 2, 0}, {9, 3, 4}, {11, 5, 3}, {12, 0, 3}, {14, 2, 5}}},
          {"C3D20R",
           20,
           {{8, 0, 1}, {11, 3, 0}, {12, 4, 5}, {15, 7, 4}, {16, 0, 4}, {19, 3, 7}}}}) {
        const ModelCells volume = read(type, count);
        ASSERT_EQ(volume.volume.cellCount(), 1) << type;
        const auto points = volume.volume.points(0);
        ASSERT_EQ(std::ssize(points), count);
        // The cell may be turned, but a middle stays between its corners.
        const auto placeOf = [&](Index point) {
            return far::cellPoints(points.size())[static_cast<std::size_t>(
                std::ranges::find(points, point) - points.begin())];
        };
        for (const auto& [middle, a, b] : middles)
            EXPECT_EQ(placeOf(middle), placeOf(a) | placeOf(b)) << type << " " << middle;
    }
    EXPECT_EQ(read("S8R", 8).surface.points(0).size(), 8u);
    EXPECT_EQ(read("C3D27", 27).unknownElements, 1);
    EXPECT_EQ(read("COH3D8", 8).unknownElements, 1);
}

/// Two hexahedra in a row in the part A, of which the assembly has two instances.
const std::string kBlocks =
    "*Part, name=A\n*Node, nset=all\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n"
    "7,1,1,1\n8,0,1,1\n9,2,0,0\n10,2,1,0\n11,2,0,1\n12,2,1,1\n"
    "*Element, type=C3D8, elset=Left\n1,1,2,3,4,5,6,7,8\n"
    "*Element, type=C3D8\n7,2,9,10,3,6,11,12,7\n";

TEST(Abaqus, SetsAndSurfacesAreGroups) {
    const std::string text =
        kBlocks +
        "*Nset, nset=\"My nodes\", generate\n1, 7, 3\n9\n*Elset, elset=BOTH\nleft, 7, 99\n"
        "*Elset, elset=_hidden, internal\n7\n*Nset, nset=of elements, elset=BOTH\n"
        "*Surface, type=ELEMENT, name=Front\nboth, S3\n"
        "*Surface, name=Right\n_hidden, S4\n*Surface, type=NODE, name=Tip\nMy nodes, 1.\n"
        "*End Part\n*Assembly, name=all\n*Instance, name=A-1, part=A\n*End Instance\n"
        "*Nset, nset=corner, instance=A-1\n1, 12\n*Elset, elset=Far, instance=A-1\n7\n"
        "*Surface, name=Back\nA-1.Left, S5\nFar, S5\n*End Assembly\n";
    const auto cells = readModel("a.inp", text)->readCells();
    std::vector<std::string> names;
    std::map<std::string, far::MeshPatch> patches;
    for (const far::MeshPatch& patch : cells.patches) {
        names.push_back(patch.name);
        patches[patch.name] = patch;
    }
    // First the sets of elements, then those of nodes, then the surfaces.
    EXPECT_THAT(names, ElementsAre("Left", "BOTH", "Far", "all", "My nodes", "corner", "Front",
                                   "Right", "Tip", "Back"));
    EXPECT_EQ(patches["Left"].dimension, 3);
    EXPECT_THAT(patches["Left"].points, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
    EXPECT_EQ(patches["BOTH"].points.size(), 12u);
    EXPECT_THAT(patches["Far"].points, ElementsAre(1, 2, 5, 6, 8, 9, 10, 11));
    EXPECT_EQ(patches["all"].points.size(), 12u);
    EXPECT_EQ(patches["all"].dimension, 0);
    EXPECT_THAT(patches["My nodes"].points, ElementsAre(0, 3, 6, 8));
    EXPECT_THAT(patches["corner"].points, ElementsAre(0, 11));
    EXPECT_EQ(patches["Front"].dimension, 2);
    ASSERT_EQ(patches["Front"].faceCount(), 2);
    EXPECT_THAT(patches["Front"].faces[0], ElementsAre(0, 4, 5, 1));
    EXPECT_THAT(patches["Front"].points, ElementsAre(0, 1, 4, 5, 8, 10));
    EXPECT_THAT(patches["Right"].points, ElementsAre(8, 9, 10, 11));
    EXPECT_THAT(patches["Tip"].points, ElementsAre(0, 3, 6, 8));
    EXPECT_THAT(patches["Back"].points, ElementsAre(2, 3, 6, 7, 9, 11));
}

/// The points of a side have one coordinate in common in a cell whose corners are a box; in a wedge
/// and a tetrahedron, those of a side lie in its plane.
TEST(Abaqus, SidesOfSecondOrderHaveTheirMiddles) {
    // Hexahedron of 20 nodes: S2 is the top.
    const int corners[8][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0},
                               {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}};
    const int edges[12][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                              {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
    std::string text = "*NODE\n";
    int number = 0;
    for (const auto& c : corners) text += concat(++number, ",", c[0], ",", c[1], ",", c[2], "\n");
    for (const auto& [a, b] : edges)
        text += concat(++number, ",", (corners[a][0] + corners[b][0]) / 2, ",",
                       (corners[a][1] + corners[b][1]) / 2, ",",
                       (corners[a][2] + corners[b][2]) / 2, "\n");
    text += "*ELEMENT, TYPE=C3D20R\n1";
    for (int i = 1; i <= 20; ++i) text += (i == 16 ? ",\n" : ",") + std::to_string(i);
    text += "\n";
    // The side, the axis and the coordinate of its plane.
    const std::tuple<int, std::size_t, double> sides[] = {{1, 2, 0}, {2, 2, 2}, {3, 1, 0},
                                                          {4, 0, 2}, {5, 1, 2}, {6, 0, 0}};
    for (const auto& [side, axis, place] : sides) {
        const auto model = readModel("a.inp", text + concat("*SURFACE, NAME=s\n1, S", side, "\n"));
        const auto patches = model->readCells().patches;
        ASSERT_EQ(patches.size(), 1u);
        EXPECT_EQ(patches[0].points.size(), 8u);
        EXPECT_EQ(patches[0].faces[0].size(), 4u);
        for (const Index point : patches[0].points)
            EXPECT_EQ(model->positions()[static_cast<std::size_t>(point)][axis], place) << side;
    }
}

TEST(Abaqus, SidesOfPlaneElementsAndShells) {
    const std::string nodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n";
    const auto pointsOf = [&](const std::string& type, const std::string& side) {
        const auto patches =
            readModel("a.inp", nodes + "*ELEMENT, TYPE=" + type +
                                   "\n1,1,2,3,4\n*SURFACE, NAME=s\n1, " + side + "\n")
                ->readCells()
                .patches;
        return patches.empty() ? std::vector<Index>() : patches[0].points;
    };
    EXPECT_THAT(pointsOf("CPS4", "S2"), ElementsAre(1, 2));
    EXPECT_THAT(pointsOf("S4", "SPOS"), ElementsAre(0, 1, 2, 3));
    EXPECT_THAT(pointsOf("S4R", "E4"), ElementsAre(0, 3));
    EXPECT_THAT(pointsOf("S4", "S1"), ElementsAre(0, 1, 2, 3));  // CalculiX
    EXPECT_THAT(pointsOf("S4", "S3"), ElementsAre(0, 1));
    EXPECT_THAT(pointsOf("CPS4", "S5"), IsEmpty());
    EXPECT_THAT(pointsOf("CPS4", "?"), IsEmpty());
}

TEST(Abaqus, TooManyMembersAreRefused) {
    std::string text = kBlocks;
    for (int i = 0; i < 200; ++i) text += concat("*ELSET, ELSET=s", i, ", GENERATE\n1, 9\n");
    for (int i = 0; i < 200; ++i) text += concat("*NSET, NSET=s", i, ", GENERATE\n1, 12\n");
    EXPECT_REFUSED(FileError, "the sets have more than 1400 members, 100 for each node and element",
                   readModel("a.inp", text)->readCells());
    EXPECT_REFUSED(
        FileError, "the step of a set is 0; expected at least 1",
        readModel("a.inp", kBlocks + "*NSET, NSET=s, GENERATE\n1, 12, 0\n")->readCells());
}

TEST(Abaqus, NotesNameWhatIsNotRead) {
    const auto notesOf = [](const std::string& text) {
        return readModel("a.inp", "*NODE\n1, 0, 0, 0\n" + text)->notes();
    };
    EXPECT_THAT(notesOf("*INCLUDE, INPUT=b.inp\n*include, input = c.inp\n"),
                ElementsAre("did not read the files that *INCLUDE names: 'b.inp', 'c.inp'"));
    EXPECT_THAT(
        notesOf("*INCLUDE, INPUT=b\n*INCLUDE, INPUT=c\n*INCLUDE, INPUT=d\n"
                "*INCLUDE, INPUT=e\n*INCLUDE, INPUT=f\n"),
        ElementsAre("did not read the files that *INCLUDE names: 'b', 'c', 'd' and 2 more"));
    EXPECT_THAT(notesOf("*ELGEN\n1, 2\n"),
                ElementsAre("did not read the elements that Abaqus makes by *ELGEN"));
}

TEST(Abaqus, MalformedFilesAreRefusedWithTheLine) {
    const auto expectRefused = [](const std::string& bytes, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readModel("a.inp", bytes)->readCells());
    };
    const std::string node = "*NODE\n1, 0, 0, 0\n";
    expectRefused("1 2 3\n*HEADING\n", "a.inp: has no nodes; expected *NODE");
    expectRefused("*INCLUDE, INPUT=b.inp\n",
                  "a.inp: has no nodes of its own; *INCLUDE names 'b.inp'");
    expectRefused("*NODE\n1, 0, x, 0\n", "a.inp:2: 'x' is not a number; expected y of a vertex");
    expectRefused("*NODE\na, 0, 0, 0\n", "a.inp:2: 'a' is not a number; expected the number of a");
    expectRefused("*NODE, INPUT=b.txt\n", "a.inp:1: the data of *NODE are in the file 'b.txt'");
    expectRefused("*NODE, SYSTEM=C\n", "a.inp:1: the nodes are in cylindrical or spherical");
    expectRefused("*SYSTEM\n1, 0, 0\n", "a.inp:2: *SYSTEM gives nodes in a coordinate system");
    expectRefused(node + "*NGEN\n1, 5\n", "a.inp:3: *NGEN makes nodes that the file does not list");
    expectRefused(node + node, "a.inp: two nodes have the number 1");
    expectRefused(node + "*ELEMENT\n1, 1\n", "a.inp:3: *ELEMENT has no TYPE=");
    expectRefused(node + "*ELEMENT, TYPE=S3\n1, 1, 1\n",
                  "the element ends; one of the type 'S3' has 3 nodes");
    expectRefused(node + "*ELEMENT, TYPE=S3\n1, 1, 1, 2\n",
                  "a.inp:4: an element names node 2, which does not exist");
}

}  // namespace
}  // namespace espalier::io
