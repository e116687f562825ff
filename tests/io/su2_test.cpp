// SPDX-License-Identifier: Apache-2.0
// mesh_model_test.cpp has the tests that all formats of meshes share.
#include <espalier/io/lattice_file.h>
#include <espalier/io/model.h>
#include <io/mesh_samples.h>

#include "support/test.h"

namespace espalier::io {
namespace {

const std::string kPlane =
    "NDIME= 2\nNELEM= 2\n5 0 1 2 0\n9 0 2 3 4 1\nNPOIN= 5\n0 0 0\n1 0 1\n1 1 2\n0 1 3\n-1 0.5 4\n"
    "NMARK= 1\nMARKER_TAG= a\nMARKER_ELEMS= 1\n3 0 1\n";

TEST(Su2, MeshesOfTwoDimensionsHaveNoZ) {
    const auto model = readModel("a.su2", kPlane);
    EXPECT_EQ(model->positions().size(), 5u);
    EXPECT_EQ(model->positions()[4], (Point3{-1, 0.5, 0}));
    EXPECT_EQ(model->readSurface().faces.count(), 2u);
    EXPECT_EQ(model->readCells().volume.cellCount(), 0);
    EXPECT_EQ(model->readCells().surface.faceCount(), 2);
    auto moved = copyOf(model->positions());
    moved[4] = {-2, 0.25, 0};
    std::string expected = kPlane;
    expected.replace(expected.find("-1 0.5"), 6, "-2 0.25");
    EXPECT_EQ(written(*model, moved), expected);
    moved[2][2] = 0.5;
    EXPECT_REFUSED(Error,
                   "the new position of point 2 has z = 0.5, but the mesh is of two dimensions",
                   written(*model, moved));
    EXPECT_REFUSED(far::TopologyError,
                   "there is no cell of a volume; the file has 0 vertex cells, 1 "
                   "lines and 2 surface cells",
                   readLattice("a.su2", kPlane));
}

// The elements of a zone number the points of their zone.
TEST(Su2, ZonesFollowEachOther) {
    const std::string zone =
        "NDIME= 3\nNELEM= 1\n10 0 1 2 3 0\nNPOIN= 4\n0 0 0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\n";
    std::string text = "NZONE= 2\nIZONE= 1\n" + zone + "IZONE= 2\n" + zone;
    const auto model = readModel("a.su2", text);
    EXPECT_EQ(model->positions().size(), 8u);
    const auto mesh = model->readCells().volume;
    EXPECT_THAT(mesh.corners(1), ElementsAre(4, 5, 6, 7));
    EXPECT_EQ(readLattice("a.su2", text).complex.count(3), 2);
    text.replace(text.rfind("10 0 1 2 3"), 10, "10 0 1 2 4");
    EXPECT_REFUSED(FileError, "a.su2:14: an element names point 4; there are 4",
                   readModel("a.su2", text)->readCells());
}

// A zone may list its elements before its points.
TEST(Su2, ElementsNameThePointsOfTheirZone) {
    const auto zone = [](const std::string& nodes, bool pointsFirst) {
        const std::string elements = "NELEM= 1\n10 " + nodes + " 0\n";
        const std::string points = "NPOIN= 4\n0 0 0 0\n1 0 0 1\n0 1 0 2\n0 0 1 3\n";
        return "NDIME= 3\n" + (pointsFirst ? points + elements : elements + points);
    };
    for (const bool pointsFirst : {false, true}) {
        const std::string good = zone("0 1 2 3", pointsFirst), bad = zone("0 1 2 4", pointsFirst);
        EXPECT_REFUSED(
            FileError,
            concat("a.su2:", pointsFirst ? 10 : 5,
                   ": an element names point 4; there are 4 in its zone"),
            readModel("a.su2", "NZONE= 2\nIZONE= 1\n" + bad + "IZONE= 2\n" + good)->readCells());
    }
}

TEST(Su2, ElementsOfUnknownTypesAreCounted) {
    std::string text = kPlane;
    text.replace(text.find("5 0 1 2 0"), 9, "7 0 1 2 5");
    const auto model = readModel("a.su2", text);
    EXPECT_EQ(model->readCells().unknownElements, 1);
    EXPECT_EQ(model->readSurface().faces.count(), 1u);
    EXPECT_THAT(model->readSurface().otherShapes, ElementsAre("1 element of unknown types"));
    EXPECT_REFUSED(FileError,
                   "a.su2:3: an element has the type 7; expected 1, 3, 5, 9, 10, 12, 13 or 14",
                   readLattice("a.su2", text));
}

// Meshes of one of several processes, as SU2 4 and before wrote them: the marker has one more line,
// and its elements end with a number of a transformation.
TEST(Su2, MarkersOfSharedPointsAreVertices) {
    std::string text = kPlane;
    text.replace(text.find("NMARK= 1"), 8, "NMARK= 2");
    // The first word of the line changed with a version of SU2.
    for (const std::string word : {"SEND_RECV", "SEND_TO"}) {
        const std::string whole =
            text + "MARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 2\n" + word + "= 1\n1 3 0\n1 4 0\n";
        EXPECT_REFUSED(far::TopologyError,
                       "the file has 2 vertex cells, 1 lines and 2 surface cells",
                       readLattice("a.su2", whole));
        const auto model = readModel("a.su2", whole);
        EXPECT_EQ(written(*model, model->positions()), whole);
    }
}

TEST(Su2, MalformedFilesAreRefusedWithTheLine) {
    const auto replaced = [](const std::string& before, const std::string& after) {
        std::string text = kPlane;
        EXPECT_NE(text.find(before), std::string::npos) << before;
        return text.replace(text.find(before), before.size(), after);
    };
    const auto expectRefused = [](const std::string& bytes, const std::string& message) {
        EXPECT_REFUSED(FileError, message, readModel("a.su2", bytes)->readSurface());
    };
    expectRefused("% nothing\n", "a.su2:1: the file ends; expected NPOIN=");
    expectRefused("NPOIN= 0\n", "a.su2:1: the points come before NDIME=");
    expectRefused(replaced("NDIME= 2", "NDIME= 4"), "a.su2:1: NDIME is 4; expected 2 or 3");
    expectRefused(replaced("NMARK= 1", "NDIME= 3"), "a.su2:11: NDIME is 3; it was 2 before");
    expectRefused(replaced("NPOIN= 5", "NPOIN= five"),
                  "a.su2:5: 'five' after NPOIN= is not a number");
    expectRefused(replaced("NPOIN= 5", "NPOIN= 500000000"),
                  "a.su2:5: NPOIN is 500000000, but only");
    expectRefused(replaced("1 1 2\n", "1\n"), "a.su2:8: the line ends; expected y of a vertex");
    expectRefused(replaced("1 1 2\n", "1 inf 2\n"), "a.su2:8: 'inf' is not finite");
    expectRefused(replaced("5 0 1 2 0", "5 0 1"),
                  "a.su2:3: the line ends; an element of the type 5 has 3 points");
    expectRefused(replaced("5 0 1 2 0", "5 0 1 x"), "a.su2:3: 'x' is not the number of a point");
    expectRefused(replaced("5 0 1 2 0", "5 0 1 -1"), "a.su2:3: an element names point -1");
    expectRefused(replaced("NELEM= 2", "NELEM= 1"), "a.su2:4: more rows follow than NELEM= says");
    expectRefused(replaced("NPOIN= 5", "NPOIN= 4"), "a.su2:10: more rows follow than NPOIN= says");
    expectRefused(replaced("MARKER_ELEMS= 1\n3 0 1", "MARKER_ELEMS= 1\n3 0 1\n% more\n\n3 1 2"),
                  "a.su2:17: more rows follow than MARKER_ELEMS= says");
    expectRefused(replaced("5 0 1 2 0", "x"), "a.su2:3: 'x' is not the type of an element");
    expectRefused(replaced("MARKER_ELEMS= 1\n3 0 1\n", "MARKER_ELEMS= 1\n%    \n"),
                  "the file ends; expected an element");
}

}  // namespace
}  // namespace espalier::io
