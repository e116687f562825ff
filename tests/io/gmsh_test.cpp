// SPDX-License-Identifier: Apache-2.0
// mesh_model_test.cpp has the tests that all formats of meshes share.
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>
#include <io/replaced.h>

#include "support/test.h"

namespace espalier::io {
namespace {

TEST(Gmsh, ElementsOfSecondOrderHaveTheirNodesInVtkOrder) {
    const std::string text =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
        "5 .5 0 0\n6 .5 .5 0\n7 0 .5 0\n8 0 0 .5\n9 0 .5 .5\n10 .5 0 .5\n$EndNodes\n$Elements\n2\n"
        "1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n2 9 2 0 1 1 2 3 5 6 7\n$EndElements\n";
    const ModelCells cells = readModel("a.msh", text)->readCells();
    EXPECT_EQ(cells.curvedCells, 0);
    ASSERT_EQ(cells.volume.cellCount(), 1);
    // Gmsh has the edge from 2 to 3 before the edge from 1 to 3.
    EXPECT_THAT(cells.volume.points(0), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 9, 8));
    EXPECT_EQ(cells.facesBeside, 0);
    EXPECT_EQ(cells.surface.faceCount(), 0);
    EXPECT_REFUSED(FileError, "a.msh: cell 0 of the volume has curved edges",
                   readLattice("a.msh", text));
}

TEST(Gmsh, UnusedNodesAreDropped) {
    ReadNotes notes;
    const std::string without =
        replaced(sampleGmsh2(), "8 4 2 0 1 6 10 11 12\n", "8 2 2 0 1 6 10 11\n");
    const Lattice lattice = readLattice("a.msh", without, &notes);
    EXPECT_EQ(lattice.complex.count(3), 3);
    EXPECT_THAT(notes.droppedVertices, ElementsAre(11));
}

TEST(Gmsh, ElementsOfUnknownTypesAreCounted) {
    const std::string two = replaced(sampleGmsh2(), "6 7 2 0 1", "6 555 2 0 1 77");
    const std::string four = replaced(sampleGmsh4(), "3 1 7 1", "3 1 555 1");
    for (const std::string& text : {two, four}) {
        const ModelCells cells = readModel("a.msh", text)->readCells();
        EXPECT_EQ(cells.volume.cellCount(), 3);
        EXPECT_EQ(cells.unknownElements, 1);
        EXPECT_REFUSED(FileError, "an element has the type 555, which is not known here",
                       readLattice("a.msh", text));
    }
}

// `gmsh -parametric -format msh22` writes the nodes so: the dimension and the tag of the entity,
// and one parameter on a curve, two on a surface.
TEST(Gmsh, NodesOfVersion2MayHaveParameters) {
    std::string text = replaced(sampleGmsh2(), "$Nodes", "$ParametricNodes");
    text = replaced(text, "$EndNodes", "$EndParametricNodes");
    for (std::size_t i = 0; i < 12; ++i)
        text = replaced(text, "\n" + std::to_string(i + 1) + " " + coordinates(i) + "\n",
                        "\n" + std::to_string(i + 1) + " " + coordinates(i) +
                            std::array{" 0 5\n", " 1 5 0.5\n", " 2 5 0.5 0.25\n", " 3 5\n"}[i % 4]);
    const auto model = readModel("a.msh", text);
    EXPECT_EQ(copyOf(model->positions()), samplePoints());
    EXPECT_EQ(model->readCells().volume.cellCount(), 4);
    auto moved = copyOf(model->positions());
    moved[11][0] = 3.5;
    EXPECT_EQ(written(*model, moved), replaced(text, "12 3 1 3 3 5", "12 3.5 1 3 3 5"));
}

/// Gmsh wrote the same nodes and elements in the versions before 2.2.
TEST(Gmsh, ReadsTheVersionsBefore22) {
    const std::string good = sampleGmsh2();
    const auto expected = readModel("a.msh", good);
    for (const std::string version : {"2", "2.0", "2.1"}) {
        const std::string text = replaced(good, "2.2 0", version + " 0");
        const auto model = readModel("a.msh", text);
        EXPECT_THAT(model->positions(), testing::ElementsAreArray(expected->positions()));
        EXPECT_EQ(model->readSurface().faces, expected->readSurface().faces);
        EXPECT_EQ(written(*model, model->positions()), text);
    }
}

TEST(Gmsh, MalformedFilesAreRefusedWithTheLine) {
    const std::string good = sampleGmsh2();
    const auto expectRefused = [](const std::string& bytes, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readModel("a.msh", bytes)->readCells());
    };
    expectRefused("", "a.msh:1: the file ends; expected $MeshFormat");
    expectRefused("<mesh>", "a.msh:1: expected a section such as $Nodes, got '<mesh>'");
    expectRefused(
        "$NOD\n1\n1 0 0 0\n$ENDNOD\n$ELM\n0\n$ENDELM\n",
        "a.msh:1: the file is of the version 1 of Gmsh's format; write the mesh with gmsh "
        "FILE -save -format msh41");
    expectRefused(replaced(good, "2.2 0", "4 0"),
                  "a.msh:2: the version of the format is '4'; expected 2.2 or 4.1: write the mesh "
                  "with gmsh");
    expectRefused(replaced(good, "0 8\n", "0 4\n"), "a.msh:2: the size of a number is 4 bytes");
    expectRefused(replaced(good, "$EndPhysicalNames", "$End"),
                  "a.msh:4: the section '$PhysicalNames' does not end");
    expectRefused(replaced(good, "$Nodes\n12", "$Nodes\n99999"),
                  "a.msh:9: the number of nodes is 99999, but only");
    expectRefused(replaced(good, "2.00", "x"), "a.msh:11: 'x' is not a number; expected x of");
    expectRefused(replaced(good, "2.00", "nan"), "a.msh:11: 'nan' is not finite");
    expectRefused(replaced(good, "$EndNodes", "13 0 0 0"),
                  "a.msh:22: expected $EndNodes, got '13'");
    expectRefused(replaced(good, "5 5 2 0 1 1 2", "5 5 2 0 1 1 13"),
                  "an element names node 13, which does not exist");
    expectRefused(replaced(good, "5 5 2 0 1 1 2", "5 5 2 0 1 1 0"),
                  "an element names node 0, which does not exist");
    expectRefused(replaced(sampleGmsh2(2, 2), "\n4 2.00", "\n2 2.00"), "two nodes have the tag 2");
    const std::string four = sampleGmsh4();
    expectRefused(replaced(four, "3 1 0 8\n", "3 1 0 7\n"), "a.msh:");
    expectRefused(replaced(four, "2 12 1 12", "2 13 1 12"),
                  "the blocks have 12 nodes, but $Nodes claims 13");
    expectRefused(replaced(four, "6 6 1 6", "6 7 1 6"),
                  "the blocks have 6 elements, but $Elements claims 7");
    expectRefused(replaced(four, "2 5 1 4", "4 5 1 4"), "an entity has the dimension 4");
    const std::string binary = sampleBinaryGmsh2(std::endian::little);
    std::string wrong = binary;
    wrong[wrong.find("8\n") + 2] = 7;
    expectRefused(wrong, "the binary number after the version is not 1");
    wrong = binary;
    wrong[wrong.find("$Elements\n6\n") + 12] = 99;  // The type of the block.
    expectRefused(wrong, "an element has the type 99, which is not known here");
    wrong = binary;
    wrong[wrong.find("$Elements\n6\n") + 12 + 4] = 9;  // The number of triangles of the block.
    expectRefused(wrong, "a block has 9 elements, but 6 are left");
}

/// A square of two triangles, whose left and right sides are periodic, in version 2 or 4.1. Nodes
/// go around from the corner at the left and down.
std::string periodicSquare(bool isVersion4, const std::string& affine) {
    const std::string names =
        "$PhysicalNames\n3\n1 1 \"left\"\n1 2 \"right\"\n2 3 \"plane\"\n"
        "$EndPhysicalNames\n";
    if (!isVersion4)
        return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + names +
               "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n"
               "$Elements\n4\n1 1 2 1 11 4 1\n2 1 2 2 12 2 3\n3 2 2 3 20 1 2 3\n"
               "4 2 2 3 20 1 3 4\n$EndElements\n"
               "$Periodic\n2\n0 2 1\n1\n2 1\n1 12 11\n" +
               affine + "2\n2 1\n3 4\n$EndPeriodic\n";
    return "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + names +
           "$Entities\n0 2 1 0\n11 0 0 0 0 1 0 1 1 0\n12 1 0 0 1 1 0 1 2 0\n"
           "20 0 0 0 1 1 0 1 3 0\n$EndEntities\n"
           "$Nodes\n1 4 1 4\n2 20 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n"
           "$Elements\n3 4 1 4\n1 11 1 1\n1 4 1\n1 12 1 1\n2 2 3\n2 20 2 2\n3 1 2 3\n4 1 3 4\n"
           "$EndElements\n$Periodic\n2\n0 2 1\n0\n1\n2 1\n1 12 11\n" +
           affine + "2\n2 1\n3 4\n$EndPeriodic\n";
}

TEST(Gmsh, PeriodicEntitiesArePartners) {
    const std::string matrix = "1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1\n";
    for (const std::string& file :
         {periodicSquare(false, ""), periodicSquare(false, "Affine " + matrix),
          periodicSquare(true, "0\n"), periodicSquare(true, "16 " + matrix)}) {
        const auto patches = readModel("a.msh", file)->readCells().patches;
        ASSERT_EQ(patches.size(), 3u);
        EXPECT_EQ(patches[0].name, "left");
        EXPECT_EQ(patches[0].partner, "right");
        EXPECT_THAT(patches[0].images, ElementsAre(std::array{0, 1}, std::array{3, 2}));
        EXPECT_EQ(patches[1].partner, "left");
        EXPECT_THAT(patches[1].images, ElementsAre(std::array{1, 0}, std::array{2, 3}));
        EXPECT_EQ(patches[2].partner, "");
        EXPECT_THAT(patches[2].images, IsEmpty());
    }
    // Entities of one group are partners in it.
    const auto one =
        readModel("a.msh", replaced(periodicSquare(false, ""), "1 2 \"right\"", "1 2 \"left\""))
            ->readCells()
            .patches;
    ASSERT_EQ(one.size(), 2u);
    EXPECT_EQ(one[0].partner, "left");
    EXPECT_EQ(one[0].images.size(), 2u);
    // An entity in no group has no patch.
    const auto none =
        readModel("a.msh", replaced(periodicSquare(false, ""), "2 1 2 2 12", "2 1 2 0 12"))
            ->readCells()
            .patches;
    EXPECT_EQ(none[0].partner, "");
}

TEST(Gmsh, MalformedPeriodicEntitiesAreRefused) {
    for (const bool isVersion4 : {false, true}) {
        const std::string good = periodicSquare(isVersion4, isVersion4 ? "0\n" : "");
        const auto refused = [](const std::string& file, const std::string& message) {
            EXPECT_REFUSED(FileError, message, readModel("a.msh", file)->readCells());
        };
        refused(replaced(good, "\n3 4\n$EndP", "\n3 5\n$EndP"), "node 5, which does not exist");
        refused(replaced(good, "2\n2 1\n3 4\n$EndP", "3\n2 1\n3 4\n$EndP"), "a.msh:");
        refused(replaced(good, "2\n2 1\n3 4\n$EndP", "99999\n2 1\n3 4\n$EndP"),
                "the number of periodic nodes is 99999, but only");
        refused(replaced(good, "$EndPeriodic", "$End"), "a.msh:");
        refused(replaced(good, "$Periodic\n2", "$Periodic\nx"), "'x'");
    }
}

}  // namespace
}  // namespace espalier::io
