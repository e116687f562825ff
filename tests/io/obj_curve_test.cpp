// SPDX-License-Identifier: Apache-2.0
#include "obj_mesh_samples.h"

namespace espalier::test {
namespace {

// A polygon 0 – 1 – 2 – 3.
const std::string kPolygonPoints = "v 0 0 0\nv 1 2 0\nv 3 2 0\nv 4 0 0\n";  // 4 lines
const std::string kPolygon = kPolygonPoints + "l 1 2 3 4\n";

using Edges = std::vector<std::array<Index, 2>>;

Edges edgesOf(const Lattice& curve) {
    Edges edges;
    for (Index edge = 0; edge < curve.complex.count(1); ++edge) {
        const auto ends = curve.complex.relation(1, 0)[edge];
        edges.push_back({ends[0], ends[1]});
    }
    return edges;
}

TEST(ObjCurve, LinesWithoutFacesMakeACurve) {
    const Lattice curve = readMesh(kPolygon);
    EXPECT_EQ(curve.complex.dimension(), 1);
    EXPECT_EQ(curve.complex.count(0), 4);
    EXPECT_EQ(edgesOf(curve), (Edges{{0, 1}, {1, 2}, {2, 3}}));
    EXPECT_EQ(curve.positions[2], (Point3{3, 2, 0}));
    for (const char* lines : {"l 1 2\nl 2 3\nl 3 4\n", "l 1/7 2/8 3/9 -1/1\n", "l 1 2\\\n 3 4\n",
                              "l -4 -3 -2\nl 3 4\n"})
        EXPECT_EQ(edgesOf(readMesh(kPolygonPoints + lines)), edgesOf(curve)) << lines;
}

TEST(ObjCurve, LinesAreIgnoredIfThereAreFaces) {
    const std::string face = kPolygonPoints + "f 1 2 3 4\n";
    for (const char* lines : {"l 1 2\n", "l 0 9\n", "l\n", "l what\n"})
        expectSameMesh(readMesh(face + lines), readMesh(face));
}

TEST(ObjCurve, MayBeClosedDisconnectedOrBranched) {
    EXPECT_EQ(edgesOf(readMesh(kPolygonPoints + "l 1 2 3 4 1\n")),
              (Edges{{0, 1}, {1, 2}, {2, 3}, {3, 0}}));
    EXPECT_EQ(edgesOf(readMesh(kPolygonPoints + "l 1 2\nl 3 4\n")), (Edges{{0, 1}, {2, 3}}));
    EXPECT_EQ(edgesOf(readMesh(kPolygonPoints + "l 1 2 3\nl 2 4\n")),
              (Edges{{0, 1}, {1, 2}, {1, 3}}));
}

TEST(ObjCurve, HasTheTagsOfMeshes) {
    const Lattice curve =
        readMesh("t corner 1/1/0 1 10\n" + kPolygon + "t interpolateboundary 1/0/0 0\n");
    EXPECT_EQ(curve.marks, (far::Marks{.vertices = {{1, far::kInfinitelySharp}}}));
    EXPECT_EQ(curve.tags, RefinementTags{.boundary = Boundary::Open});
}

TEST(ObjCurve, IsWrittenAsLongestPossibleLines) {
    const auto linesOf = [](const std::string& lines) {
        const std::string written = writtenMesh(readMesh(kPolygonPoints + lines));
        EXPECT_EQ(written.substr(0, kPolygonPoints.size()), kPolygonPoints);
        return written.substr(kPolygonPoints.size());
    };
    EXPECT_EQ(linesOf("l 3 4\nl 2 3\nl 1 2\n"), "l 1 2 3 4\n");
    EXPECT_EQ(linesOf("l 2 3 4 1 2\n"), "l 1 4 3 2 1\n");
    EXPECT_EQ(linesOf("l 3 4\nl 1 2\n"), "l 1 2\nl 3 4\n");
    EXPECT_EQ(linesOf("l 1 2 3\nl 2 4\n"), "l 1 2\nl 2 3\nl 2 4\n");
    // A closed line with a tail comes back to its junction.
    EXPECT_EQ(linesOf("l 2 3 4 2\nl 1 2\n"), "l 1 2\nl 2 3 4 2\n");
}

TEST(ObjCurve, RoundTripIsExact) {
    Lattice curve =
        withAwkwardPositions(readMesh(kPolygonPoints + "v 5 5 5\nl 1 2 3 1\nl 3 4 5\n").complex);
    curve.marks.vertices = {{1, double{0.1F}}, {3, far::kInfinitelySharp}};
    curve.marks.edges = {{{1, 2}, double{2.5F}}};
    curve.tags = {Boundary::Open, far::Creasing::Chaikin, far::TriangleSubdivision::Catmark};
    const Lattice back = readMesh(writtenMesh(curve));
    EXPECT_EQ(far::topologyDifference(back.complex, curve.complex), std::nullopt);
    EXPECT_TRUE(bitsOf(back.positions) == bitsOf(curve.positions));
    EXPECT_EQ(back.marks, curve.marks);
    EXPECT_EQ(back.tags, curve.tags);
}

TEST(ObjCurve, ErrorsNameTheLine) {
    EXPECT_THAT(refusalOfMesh(kPolygonPoints + "l 1 2 5\n"),
                StartsWith(":5: a line names vertex 5"));
    EXPECT_THAT(refusalOfMesh(kPolygonPoints + "l 1 0\n"), StartsWith(":5: a line names vertex 0"));
    EXPECT_THAT(refusalOfMesh(kPolygonPoints + "l -5 1\n"),
                StartsWith(":5: a line names vertex -5; there are 4 before it"));
    EXPECT_THAT(refusalOfMesh(kPolygonPoints + "l 1 x\n"),
                StartsWith(":5: 'x' is not a corner of a line; expected v, v/vt"));
    EXPECT_THAT(refusalOfMesh(kPolygon + "l 1\n"),
                StartsWith(":6: a line names 1 vertex; expected two"));
    EXPECT_THAT(refusalOfMesh(kPolygonPoints + "l\n"),
                StartsWith(":5: a line names 0 vertices; expected two"));
    EXPECT_THAT(refusalOfMesh(kPolygon + "l 4 1\nl 2 1\n"),
                StartsWith(":7: vertex 1 and vertex 2 are joined twice"));
    EXPECT_THAT(refusalOfMesh(kPolygonPoints + "l 1 2 2 3 4\n"),
                StartsWith(":5: a line names vertex 2 twice in a row"));
    EXPECT_THAT(refusalOfMesh(kPolygon + "t hole 1/0/0 0\n"),
                StartsWith(":6: a tag names face 0; there are none"));
    EXPECT_THAT(refusalOfMesh(kPolygonPoints),
                StartsWith(": there is no face and no line, so neither a mesh nor a curve"));
}

}  // namespace
}  // namespace espalier::test
