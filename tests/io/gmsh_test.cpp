// SPDX-License-Identifier: Apache-2.0
// mesh_model_test.cpp has the tests that all formats of meshes share.
#include <espalier/io/meshes/gmsh.h>
#include <io/mesh_samples.h>
#include <io/replaced.h>

#include "support/test.h"

namespace espalier::io {
namespace {

TEST(Gmsh, QuadraticElementsAreCurved) {
    const std::string text =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
        "5 .5 0 0\n6 .5 .5 0\n7 0 .5 0\n8 0 0 .5\n9 0 .5 .5\n10 .5 0 .5\n$EndNodes\n$Elements\n2\n"
        "1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n2 9 2 0 1 1 2 3 5 6 7\n$EndElements\n";
    const ModelVolume volume = readGmshModel("a.msh", text)->readVolume();
    EXPECT_EQ(volume.curvedCells, 1);
    EXPECT_EQ(volume.mesh.cellCount(), 0);
    EXPECT_REFUSED(FileError, "a.msh: cell 0 of the volume has curved edges",
                   readGmsh("a.msh", text));
}

TEST(Gmsh, UnusedNodesAreDropped) {
    ReadNotes notes;
    const std::string without =
        replaced(sampleGmsh2(), "8 4 2 0 1 6 10 11 12\n", "8 2 2 0 1 6 10 11\n");
    const Lattice lattice = readGmsh("a.msh", without, &notes);
    EXPECT_EQ(lattice.complex.count(3), 3);
    EXPECT_THAT(notes.droppedVertices, ElementsAre(11));
}

TEST(Gmsh, MalformedFilesAreRefusedWithTheLine) {
    const std::string good = sampleGmsh2();
    const auto expectRefused = [](const std::string& bytes, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readGmshModel("a.msh", bytes)->readVolume());
    };
    expectRefused("", "a.msh:1: the file ends; expected $MeshFormat");
    expectRefused("(0 \"Fluent\")", "a.msh:1: expected a section such as $Nodes, got '(0'");
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
    expectRefused(replaced(good, "5 5 2", "5 555 2"),
                  "an element has the type 555, which is not known here");
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
    wrong[wrong.find("$Elements\n6\n") + 12 + 4] = 9;  // The number of triangles of the block.
    expectRefused(wrong, "a block has 9 elements, but 6 are left");
}

}  // namespace
}  // namespace espalier::io
