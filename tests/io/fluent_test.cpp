// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>

#include <charconv>
#include <map>
#include <set>
#include <tuple>

#include "support/temporary_folder.h"
#include "support/test.h"

namespace espalier::io {
namespace {

std::string hex(std::int64_t number) {
    char text[20];
    return {text, std::to_chars(text, text + sizeof text, number, 16).ptr};
}

/// How the sections are written.
enum class Writing { Text, Float, Double };

/// A section: its head, and numbers of 4 bytes or hexadecimal ones.
std::string section(int kind, const std::string& head, const std::vector<std::int32_t>& numbers,
                    Writing writing) {
    std::string body;
    for (const std::int32_t number : numbers)
        body +=
            writing == Writing::Text ? hex(number) + "\n" : bytesOf(number, std::endian::little);
    if (writing == Writing::Text) return concat("(", kind, " (", head, ")(\n", body, "))\n");
    const int full = kind + (writing == Writing::Float ? 2000 : 3000);
    return concat("(", full, " (", head, ")(", body, ")\nEnd of Binary Section   ", full, ")\n");
}

std::string nodeSection(const std::string& head, std::span<const Point3> points, int dimension,
                        Writing writing) {
    std::string body;
    for (const Point3& point : points)
        for (int axis = 0; axis < dimension; ++axis) {
            const double number = point[static_cast<std::size_t>(axis)];
            body += writing == Writing::Text ? formatNumber(number) + " "
                    : writing == Writing::Float
                        ? bytesOf(static_cast<float>(number), std::endian::little)
                        : bytesOf(number, std::endian::little);
        }
    if (writing == Writing::Text) return concat("(10 (", head, ")(\n", body, "\n))\n");
    const int full = writing == Writing::Float ? 2010 : 3010;
    return concat("(", full, " (", head, ")(", body, ")\nEnd of Binary Section   ", full, ")\n");
}

/// The mesh of mesh_samples.h. The nodes 9 to 12 come first in the file. Its faces, seen from their
/// first cells, are anticlockwise: Fluent's normals point into the first cell.
std::string sampleFluent(Writing writing, bool isReversed = false) {
    struct Face {
        std::vector<Index> points;
        int first, second;
    };
    std::map<std::set<Index>, Face> faces;
    const far::StandardCell kinds[] = {far::StandardCell::Hexahedron, far::StandardCell::Pyramid,
                                       far::StandardCell::Wedge, far::StandardCell::Tetrahedron};
    for (int cell = 0; cell < 4; ++cell) {
        std::vector<int> points = sampleCells()[static_cast<std::size_t>(cell)];
        if (cell == 2) points = {1, 9, 5, 2, 10, 6};  // in VTK's order
        for (const auto& loop : far::faceLoops(kinds[cell])) {
            Face face{{}, cell + 1, 0};
            for (const Index corner : loop)
                face.points.insert(face.points.begin(), points[static_cast<std::size_t>(corner)]);
            const std::set<Index> key(face.points.begin(), face.points.end());
            const auto [at, isNew] = faces.emplace(key, face);
            if (!isNew) at->second.second = cell + 1;
        }
    }
    std::vector<std::int32_t> inside, wall, rest;
    std::size_t insideCount = 0, wallCount = 0;
    for (auto& [key, face] : faces) {
        if (isReversed) std::reverse(face.points.begin(), face.points.end());
        const bool isInside = face.second > 0, isWall = !isInside && face.first == 1;
        auto& list = isInside ? inside : isWall ? wall : rest;
        insideCount += isInside ? 1 : 0;
        wallCount += isWall ? 1 : 0;
        list.push_back(static_cast<std::int32_t>(face.points.size()));
        for (const Index point : face.points) list.push_back(point + 1);
        // A face of the boundary may have its cell on either side.
        if (isInside || isWall) {
            list.push_back(face.first);
            list.push_back(face.second);
        } else {
            std::reverse(list.end() - static_cast<std::ptrdiff_t>(face.points.size()), list.end());
            list.push_back(0);
            list.push_back(face.first);
        }
    }
    const std::vector<Point3> points = samplePoints();
    const std::size_t all = faces.size();
    const auto head = [](const char* zone, std::size_t first, std::size_t last, int type) {
        return concat(zone, " ", hex(static_cast<std::int64_t>(first)), " ",
                      hex(static_cast<std::int64_t>(last)), " ", type, " 0");
    };
    return "(0 \"a mesh (of Fluent\")\n(0 comment (with a list))\n(2 3)\n(10 (0 1 c 0))\n(12 (0 1 "
           "4 0))\n"
           "(13 (0 1 11 0))\n" +
           nodeSection("1 9 c 1 3", std::span(points).subspan(8), 3, writing) +
           nodeSection("2 1 8 1 3", std::span(points).first(8), 3, writing) +
           section(13, head("a", 1, insideCount, 2), inside, writing) +
           section(13, head("b", insideCount + 1, insideCount + wallCount, 3), wall, writing) +
           section(13, head("c", insideCount + wallCount + 1, all, 5), rest, writing) +
           "(12 (7 1 3 1 0)(4 5 6))\n(12 (8 4 4 1 2))\n(45 (10 interior inside)())\n"
           "(39 (11 wall the-wall)(\n(a . 1) (b \"x)\\\"\")))\n(45 (7 fluid air 1)())\n";
}

/// The points in the order of the file.
std::vector<Point3> pointsInFile() {
    std::vector<Point3> points = samplePoints();
    std::rotate(points.begin(), points.begin() + 8, points.end());
    return points;
}

constexpr Writing kWritings[] = {Writing::Text, Writing::Float, Writing::Double};

TEST(Fluent, MeshesAreReadAndWrittenInPlace) {
    for (const Writing writing : kWritings) {
        const std::string text = sampleFluent(writing);
        for (const char* name : {"a.msh", "a.cas"}) {
            const auto model = readModel(name, text);
            EXPECT_EQ(copyOf(model->positions()), pointsInFile());
            EXPECT_EQ(written(*model, model->positions()), text);
            EXPECT_EQ(model->storage(), writing == Writing::Text    ? CoordinateStorage::Text
                                        : writing == Writing::Float ? CoordinateStorage::Float
                                                                    : CoordinateStorage::Double);
        }
        const auto model = readModel("a.msh", text);
        const ModelCells cells = model->readCells();
        ASSERT_EQ(cells.volume.cellCount(), 4);
        EXPECT_EQ(cells.volume.internalFaceCount(), 2);
        EXPECT_FALSE(cells.isOpenFoam);
        const auto counts = cellCounts(cells);
        for (const std::size_t kind : {0, 1, 2, 3}) EXPECT_EQ(counts[kind].count, 1) << kind;
        EXPECT_EQ(readLattice("a.msh", text).complex.count(3), 4);
        EXPECT_EQ(model->readSurface().faces.count(), 16u);
        auto moved = copyOf(model->positions());
        moved[3] = {0.5, -7, 3};  // the tip, node 12
        const std::string result = written(*model, moved);
        EXPECT_EQ(copyOf(readModel("a.msh", result)->positions()), moved);
        if (writing == Writing::Text) {
            std::string expected = text;
            expected.replace(expected.find("3 1 3 \n"), 5, "0.5 -7 3");
            EXPECT_EQ(result, expected);
        } else {
            EXPECT_EQ(result.size(), text.size());
        }
    }
}

/// Volumes are positive, whichever way the faces of a file turn.
TEST(Fluent, CellsAreRightHanded) {
    for (const bool isReversed : {false, true}) {
        const std::string text = sampleFluent(Writing::Text, isReversed);
        const auto cells = readModel("a.msh", text)->readCells();
        const std::vector<Point3> points = pointsInFile();
        for (Index face = 0; face < cells.volume.faceCount(); ++face) {
            // Away from the centre of the owner.
            Point3 centre{0, 0, 0};
            double count = 0;
            for (const Index other : cells.volume.faces(cells.volume.owner(face)))
                for (const Index point : cells.volume.face(other)) {
                    centre = sum(centre, points[static_cast<std::size_t>(point)]);
                    ++count;
                }
            std::vector<Point3> loop;
            for (const Index point : cells.volume.face(face))
                loop.push_back(points[static_cast<std::size_t>(point)]);
            EXPECT_GT(dot(areaVector(loop), difference(loop[0], scaled(centre, 1 / count))), 0)
                << isReversed << " " << face;
        }
    }
}

TEST(Fluent, ZonesAreGroups) {
    for (const Writing writing : kWritings) {
        const auto patches = readModel("a.msh", sampleFluent(writing))->readCells().patches;
        ASSERT_EQ(patches.size(), 4u);
        EXPECT_EQ(patches[0].name, "air");
        EXPECT_EQ(patches[0].type, "fluid");
        EXPECT_EQ(patches[0].dimension, 3);
        EXPECT_EQ(patches[0].points.size(), 11u);
        EXPECT_EQ(patches[1].name, "zone 8");
        EXPECT_EQ(patches[1].points.size(), 4u);
        EXPECT_EQ(patches[2].name, "the-wall");
        EXPECT_EQ(patches[2].type, "wall");
        EXPECT_EQ(patches[2].faceCount(), 4);
        EXPECT_EQ(patches[2].points.size(), 8u);
        EXPECT_EQ(patches[3].name, "zone 12");
        EXPECT_EQ(patches[3].type, "pressure-outlet");
        EXPECT_EQ(patches[3].faceCount(), 12);
    }
}

/// Two squares and a triangle in a row, of zones "left" and "right".
std::string plane(Writing writing) {
    const std::vector<Point3> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0},
                                        {1, 1, 0}, {2, 1, 0}, {3, 0, 0}};
    return "(2 2)\n(10 (0 1 7 0))\n" + nodeSection("1 1 7 1 2", points, 2, writing) +
           section(13, "2 1 2 2 2", {2, 5, 1, 2, 3, 6, 2, 3}, writing) +
           section(13, "3 3 4 7 2", {1, 2, 0, 1, 3, 2, 2, 0}, writing) +
           section(13, "4 5 9 3 2", {5, 6, 0, 2, 4, 5, 0, 1, 1, 4, 1, 0, 3, 7, 0, 3, 7, 6, 0, 3},
                   writing) +
           "(12 (5 1 1 1 3))\n(12 (6 2 3 1 0)(3 1))\n(45 (3 symmetry mid)())\n"
           "(45 (5 fluid left)())\n(45 (6 fluid right)())\n";
}

TEST(Fluent, MeshesOfTwoDimensionsHaveNoZ) {
    for (const Writing writing : kWritings) {
        const std::string text = plane(writing);
        const auto model = readModel("a.msh", text);
        const ModelCells cells = model->readCells();
        ASSERT_EQ(cells.surface.faceCount(), 3);
        EXPECT_EQ(cells.surface.corners(0).size(), 4u);
        EXPECT_EQ(cells.surface.corners(2).size(), 3u);
        EXPECT_EQ(cells.unknownElements, 0);
        ASSERT_EQ(cells.patches.size(), 4u);
        EXPECT_EQ(cells.patches[0].name, "left");
        EXPECT_EQ(cells.patches[0].type, "fluid");
        EXPECT_THAT(cells.patches[0].points, ElementsAre(0, 1, 3, 4));
        EXPECT_EQ(cells.patches[1].name, "right");
        EXPECT_EQ(cells.patches[2].name, "mid");
        EXPECT_EQ(cells.patches[2].type, "symmetry");
        EXPECT_EQ(cells.patches[2].dimension, 1);
        EXPECT_THAT(cells.patches[2].points, ElementsAre(0, 1, 2));
        EXPECT_EQ(cells.patches[3].name, "zone 4");
        auto moved = copyOf(model->positions());
        moved[6] = {4, 0.5, 0};
        EXPECT_EQ(copyOf(readModel("a.msh", written(*model, moved))->positions()), moved);
        moved[6][2] = 1;
        EXPECT_REFUSED(Error, "the mesh is of two dimensions", written(*model, moved));
    }
}

TEST(Fluent, PeriodicZonesNameEachOther) {
    std::string text = sampleFluent(Writing::Text);
    text += "(18 (1 1 b c)(\n1 2\n))\n";
    const auto patches = readModel("a.msh", text)->readCells().patches;
    EXPECT_EQ(patches[2].partner, "zone 12");
    EXPECT_EQ(patches[3].partner, "the-wall");
}

/// Zones of the type 31 have faces that smaller ones replace.
TEST(Fluent, ParentsAreNoFaces) {
    const std::string text = sampleFluent(Writing::Text) + "(13 (d 12 12 1f 4)(1 2 3 4 9 0))\n";
    const auto cells = readModel("a.msh", text)->readCells();
    EXPECT_EQ(cells.volume.cellCount(), 4);
    EXPECT_EQ(cells.volume.faceCount(), 18);
    EXPECT_EQ(cells.patches.size(), 4u);
}

/// The extension .msh is Gmsh's, too. The content decides, also for the name of an output.
TEST(Fluent, TheContentTellsItFromGmsh) {
    const test::TemporaryFolder folder;
    const auto fluent = readModel("a.msh", "\n " + sampleFluent(Writing::Text));
    const auto gmsh = readModel("a.msh", sampleGmsh2());
    EXPECT_NE(&fluent->format(), &gmsh->format());
    EXPECT_EQ(fluent->extension(), ".msh");
    for (const char* name : {"b.msh", "b.cas"}) EXPECT_EQ(fluent->checkTarget(folder / name), "");
    EXPECT_EQ(gmsh->checkTarget(folder / "b.msh"), "");
    EXPECT_REFUSED(FileError, "a model that was read as .msh cannot be written as .cas",
                   gmsh->checkTarget(folder / "b.cas"));
    EXPECT_REFUSED(FileError, "expected a section such as (10", readModel("a.cas", sampleGmsh2()));
    EXPECT_EQ(readRefinable("a.msh", sampleFluent(Writing::Text)).complex.count(3), 4);
}

TEST(Fluent, MalformedFilesAreRefusedWithTheLine) {
    const auto expectRefused = [](const std::string& bytes, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readModel("a.msh", bytes)->readCells());
    };
    const std::string nodes = "(2 3)\n(10 (1 1 4 1 3)(0 0 0 1 0 0 0 1 0 0 0 1))\n";
    expectRefused("(2 3)\n", "a.msh: has no nodes");
    expectRefused("(2 4)\n", "a.msh:1: the dimension is 4; expected 2 or 3");
    expectRefused("(x 3)\n", "a.msh:1: 'x' is not the number of a section");
    expectRefused("(10 (1 1 2 1 3)(0 0 0\n0 y 0))\n", "a.msh:2: 'y' is not a number; expected y");
    expectRefused("(10 (1 1 2 1 3)(0 0 0))\n", "the section ends; expected a coordinate");
    expectRefused("(10 (1 1 ffff 1 3)(0 0 0))\n", "the section claims 65535 nodes");
    expectRefused("(10 (1 5 1 1 3)(0 0 0))\n", "a section has the nodes 5 to 1");
    expectRefused("(10 (1 1 g 1 3)(0 0 0))\n", "'g' is not a number in the head of a section");
    expectRefused(nodes + "(0 (\n", "a.msh:4: the file ends in a section of the kind 0");
    expectRefused(nodes + "(3041 (1 1 2)(abc)\n", "the section 3041 does not end");
    expectRefused(nodes + "(13 (1 1 1 3 3)(1 2 5 1 0))\n",
                  "a.msh:3: a face names node 5, which does not exist");
    expectRefused(nodes + "(13 (1 1 1 3 2)(1 2 1 0))\n",
                  "a.msh:3: a face of a mesh of 3 dimensions has 2 nodes");
    expectRefused(nodes + "(13 (1 1 1 3 3)(1 2 3 0 0))\n", "a.msh:3: a face has no cell");
    expectRefused(nodes + "(13 (1 1 1 3 3)(1 2 3 2 2))\n",
                  "a.msh:3: a face has cell 2 on both sides");
    expectRefused(nodes + "(13 (1 1 1 3 3)(1 2 3 1))\n",
                  "a.msh:3: the section ends; expected a cell");
    expectRefused(nodes + "(12 (1 1 5 1 2))(12 (2 5 6 1 2))\n",
                  "a.msh: the zones 1 and 2 both have cell 5");
    expectRefused(
        nodes + "(3010 (2 5 5 1 3)(" + std::string(24, '\0') + ")\nEnd of Binary Section 3010)\n",
        "the nodes of a zone are written in another way than those before");
}

}  // namespace
}  // namespace espalier::io
