// SPDX-License-Identifier: Apache-2.0
// mesh_model_test.cpp has the tests that all formats of meshes share.
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>

#include "support/test.h"

namespace espalier::io {
namespace {

TEST(Medit, MeshesOfTwoDimensionsHaveNoZ) {
    const std::string text =
        "MeshVersionFormatted 1\nDimension 2\nVertices\n4\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
        "Quadrilaterals 1\n1 2 3 4 0\nEnd\n";
    const auto model = readModel("a.mesh", text);
    EXPECT_EQ(model->readSurface().faces.count(), 1u);
    auto moved = copyOf(model->positions());
    moved[2][0] = 1.5;
    EXPECT_THAT(written(*model, moved), HasSubstr("1 0 1\n1.5 1 1\n"));
    moved[2][2] = 1;
    EXPECT_REFUSED(Error, "the mesh is of two dimensions", written(*model, moved));
}

TEST(Medit, QuadraticElementsAreCurved) {
    std::string text = sampleMedit();
    text.replace(text.find("End\n"), 4,
                 "TetrahedraP2 1\n1 2 3 4 5 6 7 8 9 10 0\nEdgesP2 1 1 2 3 0\n");
    const ModelCells cells = readModel("a.mesh", text)->readCells();
    EXPECT_EQ(cells.curvedCells, 0);
    EXPECT_TRUE(cells.volume.isSecondOrder(4));
    // Another order of the nodes is not read.
    const std::string ordered = text + "TetrahedraP2Ordering 1\n4 0 0 0\n";
    EXPECT_EQ(readModel("a.mesh", ordered)->readCells().curvedCells, 1);
    EXPECT_REFUSED(FileError, "cell 4 of the volume has curved edges", readLattice("a.mesh", text));
}

TEST(Medit, MalformedFilesAreRefusedWithTheLine) {
    const auto replaced = [](const std::string& before, const std::string& after) {
        std::string text = sampleMedit();
        EXPECT_NE(text.find(before), std::string::npos) << before;
        return text.replace(text.find(before), before.size(), after);
    };
    const auto expectRefused = [](const std::string& bytes, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readModel("a.mesh", bytes)->readCells());
    };
    expectRefused(std::string("\1\0\0\0", 4), "the file does not begin with MeshVersionFormatted");
    expectRefused("MeshVersionFormatted 2\n", "the file ends; expected Vertices");
    expectRefused("MeshVersionFormatted 2\nVertices 0\n",
                  "a.mesh:2: Vertices come before Dimension");
    expectRefused(replaced("Dimension\n3", "Dimension\n4"), "a.mesh:3: the dimension is 4");
    expectRefused(replaced("Vertices 12", "Vertices 12345"),
                  "a.mesh:5: the number of vertices is 12345, but");
    expectRefused(replaced("2.00", "two"), "a.mesh:7: 'two' is not a number");
    expectRefused(replaced("Pyramids\n1\n 5 6", "Pyramids\n1\n 5 13"),
                  "an element names vertex 13; there are 12, counted from 1");
    expectRefused(replaced("Pyramids\n1\n 5 6", "Pyramids\n1\n 5 0"), "an element names vertex 0");
    expectRefused(replaced("Vertices 12", "Vertices 11"),
                  "a.mesh:17: more rows follow than the number after Vertices says");
    expectRefused(replaced("Pyramids\n1\n", "Pyramids\n1\n1 2 3 4 5 0\n"),
                  "more rows follow than the number after Pyramids says");
    expectRefused(replaced("Pyramids\n1\n 5 6", "Pyramids\n1\n 5 x"),
                  "'x' is not a number; expected a vertex of an element");
}

}  // namespace
}  // namespace espalier::io
