// SPDX-License-Identifier: Apache-2.0
// The patches and groups of meshes, in each format that has them.
#include <espalier/io/model.h>
#include <io/mesh_samples.h>
#include <io/model_files.h>

#include "io/meshes/patch_collector.h"
#include "support/test.h"

namespace espalier::io {
namespace {

/// A patch in a form that tests can compare.
struct Patch {
    std::string name, type;
    int dimension;
    Index faces;
    std::vector<Index> points;
    friend bool operator==(const Patch&, const Patch&) = default;
};

std::vector<Patch> patchesOf(const Model& model) {
    std::vector<Patch> result;
    for (const far::MeshPatch& patch : model.readCells().patches)
        result.push_back(
            {patch.name, patch.type, patch.dimension, patch.faceCount(), patch.points});
    return result;
}

std::vector<Index> upTo(Index end) {
    std::vector<Index> all(end);
    std::iota(all.begin(), all.end(), 0);
    return all;
}

TEST(PatchCollector, ReadsMarkersOfSu2) {
    const auto model = readModel(
        "a.su2",
        "NDIME= 2\nNELEM= 2\n5 0 1 2 0\n9 0 2 3 4 1\nNPOIN= 5\n0 0\n1 0\n1 1\n0 1\n-1 0.5\n"
        "NMARK= 2\nMARKER_TAG= wall\nMARKER_ELEMS= 2\n3 0 1\n3 1 2\nMARKER_ELEMS= 1\n3 3 4\n"
        "MARKER_TAG= far\nMARKER_ELEMS= 1\n3 2 3\n");
    // Elements after a marker belong to no marker, until the next tag.
    EXPECT_THAT(patchesOf(*model),
                ElementsAre(Patch{"wall", "", 1, 0, {0, 1, 2}}, Patch{"far", "", 1, 0, {2, 3}}));
    // The patches are groups of points.
    const auto groups = model->groups();
    ASSERT_EQ(groups.size(), 2u);
    EXPECT_EQ(groups[1].name, "far");
    EXPECT_THAT(groups[1].read(), ElementsAre(2, 3));
}

// Lines of second order are lines with a point in the middle, which follows the ends.
TEST(PatchCollector, ReadsCurvedLines) {
    const std::string points = "0 0 0 1\n1 0 0 1\n0 1 0 1\n.5 0 0 1\n.5 .5 0 1\n0 .5 0 1\n";
    const std::string gmsh =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 .5 0 0\n"
        "5 .5 .5 0\n6 0 .5 0\n$EndNodes\n$Elements\n2\n1 9 2 7 1 1 2 3 4 5 6\n2 8 2 5 1 1 2 4\n"
        "$EndElements\n";
    const std::string medit = "MeshVersionFormatted 2\nDimension 3\nVertices 6\n" + points +
                              "TrianglesP2 1\n1 2 3 4 5 6 7\nEdgesP2 1\n1 2 4 5\nEnd\n";
    for (const auto& [name, text] :
         {std::pair<std::string, std::string>{"a.msh", gmsh}, {"a.mesh", medit}}) {
        const auto patches = readModel(name, text)->readCells().patches;
        ASSERT_EQ(patches.size(), 2u) << name;
        EXPECT_EQ(patches[1].name, "line 5");
        EXPECT_EQ(patches[1].dimension, 1);
        EXPECT_THAT(patches[1].points, ElementsAre(0, 1, 3));
        ASSERT_EQ(patches[1].lines.count(), 1u);
        EXPECT_THAT(patches[1].lines[0], ElementsAre(0, 1, 3));
    }
}

TEST(PatchCollector, ReadsPhysicalGroupsOfGmsh2) {
    const std::string text =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"a \"\"wall\"\"\"\n3 7 "
        "\"fluid\"\n$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 9 9 9\n"
        "$EndNodes\n$Elements\n5\n1 4 2 7 1 1 2 3 4\n2 2 2 1 1 1 2 3\n3 2 0 1 2 4\n4 2 1 5 1 3 "
        "4\n5 1 1 1 1 2\n$EndElements\n";
    // The third element has no tag, and the number 1 of lines is another group than of surfaces.
    EXPECT_THAT(
        patchesOf(*readModel("a.msh", text)),
        ElementsAre(Patch{"fluid", "", 3, 0, {0, 1, 2, 3}},
                    Patch{"a \"\"wall\"\"", "", 2, 1, {0, 1, 2}},
                    Patch{"surface 5", "", 2, 1, {0, 2, 3}}, Patch{"line 1", "", 1, 0, {0, 1}}));
}

// Version 4 lists the groups at the entities: a point, a curve, a surface of two groups, a volume.
TEST(PatchCollector, ReadsPhysicalGroupsOfGmsh4) {
    const auto withEntities = [](const std::string& entities) {
        return "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 4 "
               "\"wall\"\n$EndPhysicalNames\n$Entities\n" +
               entities +
               "$EndEntities\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
               "$EndNodes\n$Elements\n3 3 1 3\n2 5 2 1\n1 1 2 3\n2 6 2 1\n2 1 2 4\n3 1 4 1\n3 1 2 "
               "3 "
               "4\n$EndElements\n";
    };
    const std::string good =
        "1 1 2 1\n1 0 0 0 1 9\n1 0 0 0 1 0 0 0 1 1\n5 0 0 0 1 1 0 2 4 -8 2 1 -1\n"
        "6 0 0 0 1 1 0 0 0\n1 0 0 0 1 1 1 1 3 2 5 6\n";
    EXPECT_THAT(
        patchesOf(*readModel("a.msh", withEntities(good))),
        ElementsAre(Patch{"wall", "", 2, 1, {0, 1, 2}}, Patch{"surface 8", "", 2, 1, {0, 1, 2}},
                    Patch{"volume 3", "", 3, 0, upTo(4)}));
    const auto refuse = [&](const std::string& entities, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readModel("a.msh", withEntities(entities))->readCells());
    };
    refuse("0 0 1 0\n5 0 0 0 1 1 0 1 -9223372036854775808 0\n",
           "the tag of a physical group is -9223372036854775808");
    std::string many;
    for (int i = 0; i < 101; ++i) many += " 100000";
    refuse("0 0 1 0\n5 0 0 0 1 1 0 101" + many + " 0\n",
           "an entity has 101 physical groups; at most 100 can be read");
    // Binary files have the same section.
    std::string binary = sampleBinaryGmsh4(std::endian::little);
    const auto number = [](std::int32_t value) { return bytesOf(value, std::endian::little); };
    const auto size = [](std::uint64_t value) { return bytesOf(value, std::endian::little); };
    const std::string box(6 * sizeof(double), '\0');
    const std::string none = size(0) + size(0) + size(0) + size(0);
    const std::string one = size(0) + size(0) + size(0) + size(1) + number(1) + box + size(1) +
                            number(12) + size(1) + number(2);
    const auto patches = patchesOf(*readModel("a.msh", replaced(binary, none, one)));
    ASSERT_EQ(patches.size(), 1u);
    EXPECT_EQ(patches[0].name, "volume 12");
    EXPECT_EQ(patches[0].points, upTo(12));
}

TEST(PatchCollector, ReadsReferencesOfMedit) {
    const auto model = readModel(
        "a.mesh",
        "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
        "Edges 1\n1 2 7\nTriangles 3\n1 2 3 5\n1 2 4 6\n1 3 4 5\nTetrahedra 1\n1 2 3 4 5\nEnd\n");
    EXPECT_THAT(
        patchesOf(*model),
        ElementsAre(Patch{"line 7", "", 1, 0, {0, 1}}, Patch{"surface 5", "", 2, 2, {0, 1, 2, 3}},
                    Patch{"surface 6", "", 2, 1, {0, 1, 3}}, Patch{"volume 5", "", 3, 0, upTo(4)}));
}

TEST(PatchCollector, ReadsPatchesOfOpenFoam) {
    for (const bool isBinary : {false, true}) {
        const TemporaryFolder folder;
        const auto points = putFoam(folder / "polyMesh", sampleFoam(isBinary));
        const auto put = [&](const std::string& patches) {
            putFile(folder / "polyMesh/boundary",
                    foamHeader("polyBoundaryMesh", "boundary", isBinary) + patches);
        };
        const auto cells = readModel(points)->readCells();
        const Index first = cells.volume.internalFaceCount(), last = cells.volume.faceCount();
        const std::string start = concat(first), next = concat(first + 2);
        put("3\n(\n// a comment\nleft\n{\n type cyclic;\n inGroups 1(cyclic);\n nFaces 2;\n "
            "startFace " +
            start +
            ";\n matchTolerance 1e-4;\n neighbourPatch right;\n extra { inner { a 1; } }\n}\n"
            "\"right side\" { type \"wall\"; nFaces " +
            concat(last - first - 2) + "; startFace " + next +
            "; /* another */ }\nnothing { type empty; nFaces 0; startFace 0; }\n)\n");
        const auto patches = readModel(points)->readCells().patches;
        ASSERT_EQ(patches.size(), 3u);
        EXPECT_EQ(patches[0].name, "left");
        EXPECT_EQ(patches[0].type, "cyclic");
        EXPECT_EQ(patches[0].partner, "right");
        EXPECT_EQ(patches[0].faceCount(), 2);
        EXPECT_TRUE(std::ranges::equal(patches[0].faces[1], cells.volume.face(first + 1)));
        EXPECT_EQ(patches[1].name, "right side");
        EXPECT_EQ(patches[1].type, "wall");
        EXPECT_EQ(patches[1].faceCount(), last - first - 2);
        EXPECT_EQ(patches[2].faceCount(), 0);
        const auto refuse = [&](const std::string& text, const std::string& message) {
            put("1\n(\n" + text + ")\n");
            EXPECT_REFUSED(FileError, message, readModel(points)->readCells());
        };
        const std::string range = "nFaces 1; startFace " + start + "; ";
        refuse("a { " + range + "}\n", "the patch 'a' has no type");
        refuse("a { type wall; nFaces 1; }\n", "the patch 'a' has no startFace");
        refuse("a { type wall; startFace 1; }\n", "the patch 'a' has no nFaces");
        refuse("a { type wall; nFaces 1 startFace 3; }\n", "expected ;, got 'startFace'");
        refuse("a { type wall; #include \"x\"\n" + range + "}\n",
               "the patch 'a' has '#include', which cannot be read");
        refuse("a { type wall; " + range + "b }\n", "expected ;, got }");
        refuse("a { type wall; nFaces 1; startFace 0; }\n",
               "the patch 'a' has 1 faces from face 0 on");
        refuse("a { type wall; nFaces 99; startFace " + start + "; }\n",
               "the patch 'a' has 99 faces");
        put("2\n(\na { type wall; " + range + "}\nb { type wall; " + range + "}\n)\n");
        EXPECT_REFUSED(FileError, concat("expected faces of ", first + 1, " to ", last - 1),
                       readModel(points)->readCells());
    }
}

// A group changes from a list of its points to bits when it gets large.
TEST(PatchCollector, LargeGroupsAndManyGroupsHaveTheirPoints) {
    PatchCollector collector;
    const std::vector<std::string> both = {"all", "even", "all"};
    for (Index point = 0; point < 300'000; ++point) {
        const auto names = std::span(both).first(point % 2 == 0 ? 3 : 1);
        collector.begin(names);
        const std::array<Index, 2> points = {point, point};
        collector.add(2, points);
    }
    for (Index group = 0; group < 2000; ++group) {
        const std::string name = concat("g", group);
        collector.begin(std::span(&name, 1));
        const std::array<Index, 3> points = {299'999 - group, group, group};
        collector.add(3, points);
        collector.addFace(points);
    }
    const auto patches = collector.take();
    ASSERT_EQ(patches.size(), 2002u);
    EXPECT_EQ(patches[0].points, upTo(300'000));
    EXPECT_EQ(patches[1].points.size(), 150'000u);
    EXPECT_EQ(patches[1].points[7], 14);
    EXPECT_THAT(patches[12].points, ElementsAre(10, 299'989));
    EXPECT_EQ(patches[12].faceCount(), 1);
}

}  // namespace
}  // namespace espalier::io
