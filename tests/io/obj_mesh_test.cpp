// SPDX-License-Identifier: Apache-2.0
#include "obj_mesh_samples.h"
#include "support/test.h"

namespace espalier::test {
namespace {

using far::Creasing;
using far::kInfinitelySharp;
using far::TriangleSubdivision;

using EdgeMarks = std::vector<far::Marks::Edge>;
using VertexMarks = std::vector<far::Marks::Vertex>;

/// Returns the message with which the two squares are refused, with this line as line 9.
std::string refusalOfLine(const std::string& line) {
    return refusalOfMesh(kSquares + line + "\n# the end\n");
}

/// Returns the sharpness that is read from a tag of one crease; nothing if it is no mark.
std::optional<double> sharpnessOf(const std::string& text) {
    const auto edges = readMesh(kSquares + "t crease 2/1/0 1 4 " + text + "\n").marks.edges;
    EXPECT_LE(edges.size(), 1u);
    if (edges.empty()) return std::nullopt;
    return edges[0].sharpness;
}

TEST(ObjMesh, FacesKeepTheirOrderFirstVertexAndWinding) {
    const Lattice mesh = readMesh(kSquares);
    EXPECT_EQ(mesh.complex.dimension(), 2);
    EXPECT_EQ(loopsOf(mesh.complex), kSquareLoops);
    EXPECT_EQ(mesh.complex.count(1), 7);
    EXPECT_THAT(mesh.positions, ElementsAre(Point3{0, 0, 0}, Point3{1, 0, 0}, Point3{2, 0, 0},
                                            Point3{0, 1, 0}, Point3{1, 1, 0}, Point3{2, 1, 0}));
    EXPECT_TRUE(mesh.marks.empty());
    EXPECT_EQ(mesh.tags, RefinementTags{});
    EXPECT_THAT(mesh.attributes, IsEmpty());
    // A face keeps its first vertex and its winding.
    EXPECT_EQ(loopsOf(readMesh(kVertices + "f 4 5 2 1\nf 6 5 2 3\n").complex),
              (Loops{{3, 4, 1, 0}, {5, 4, 1, 2}}));
}

TEST(ObjMesh, AcceptsAllSpellingsOfFaces) {
    for (const char* faces :
         {"f 1/1 2/2 5/5 4/4\nf 2//1 3//2 6//3 5//4\n",
          "f 1/1/9 2/2/9 5/-5/9 4/4/-9\nf 2 3/7 6//1 5/1/2\n",
          // Negative numbers count back from vertex 6, the last one so far.
          "f -6 -5 -2 -3\nf -5 3 -1/-1/-1 5\n", "f 1 2 \\\n 5 4\nf 2\t3   6 5 # the right one\n",
          "f +1 2 5 4\nf 2/ 3/1/ 6 5\n",
          // Old files have the keyword fo.
          "fo 1 2 5 4\nfo 2 3 6 5\n"})
        EXPECT_EQ(loopsOf(readMesh(kVertices + faces).complex), kSquareLoops) << faces;
    EXPECT_EQ(loopsOf(readMesh(kVertices + "f 1 2 3 6 5 4\nf 1 2 5\n").complex),
              (Loops{{0, 1, 2, 5, 4, 3}, {0, 1, 4}}));
}

TEST(ObjMesh, RelativeNumbersCountFromTheirOwnFace) {
    EXPECT_EQ(loopsOf(readMesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n"
                               "v 0 0 1\nv 1 0 1\nv 0 1 1\nf -3 -2 -1\n")
                          .complex),
              (Loops{{0, 1, 2}, {3, 4, 5}}));
}

TEST(ObjMesh, StatementsMayBeInAnyOrder) {
    const std::string text =
        "t crease 2/1/0 1 4 2\nt hole 1/0/0 1\nt corner 1/1/0 0 10\nf 1 2 5 4\n" + kVertices +
        "f 2 3 6 5\n";
    const Lattice mesh = readMesh(text);
    EXPECT_EQ(loopsOf(mesh.complex), kSquareLoops);
    EXPECT_EQ(mesh.marks, (far::Marks{{{{1, 4}, 2}}, {{0, kInfinitelySharp}}, {1}}));
}

TEST(ObjMesh, RefusesUnknownKeywords) {
    for (const char* line : {"1 2 3", "T hole 1/0/0 0", "F 1 2 3"})
        EXPECT_REFUSED(io::FileError, "is not a keyword of OBJ files",
                       readMesh(kVertices + line + "\nf 1 2 5 4\n"))
            << line;
}

TEST(ObjMesh, SkipsLinesThatItDoesNotKnow) {
    io::ReadNotes notes;
    const Lattice mesh =
        io::readRefinable("a.obj", kVertices + "foo bar\nf 1 2 5 4\nf 2 3 6 5\n", &notes);
    EXPECT_EQ(loopsOf(mesh.complex), kSquareLoops);
    EXPECT_EQ(io::describe("a.obj", notes),
              "a.obj: skipped 1 line whose first word no OBJ has ('foo' in line 7)");
}

TEST(ObjMesh, OtherStatementsAreIgnored) {
    const std::string text =
        "\xEF\xBB\xBF# t crease 2/1/0 0 1 1\nmtllib a.mtl\no a\ng b \\\nf 1 2 3\n"
        "v 0 0 0 1.5\nv 1 0 0 0.1 0.2 0.3\nv 2 0 0 # a comment\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
        "vt 0 0.5\nvn 0 0 1\nvp 1\nusemtl m\ns off\nl 1 2\np 1\n\nf 1 2 5 4\nf 2 3 6 5\n"
        "curv 0 1 1 2\nshadow_obj a.obj";
    for (const char* end : {"\n", "\r\n"}) {
        std::string withEnds;
        for (const char c : text) withEnds += c == '\n' ? end : std::string(1, c);
        expectSameMesh(readMesh(withEnds), readMesh(kSquares));
    }
}

TEST(ObjMesh, MayBeNonManifold) {
    // Three triangles on one edge, two squares back to back, and two triangles that share only a
    // vertex.
    const std::string text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nv 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\n"
        "v 7 1 0\nv 7 2 0\n"
        "f 1 2 3\nf 1 2 4\nf 2 1 5\nf 6 7 8 9\nf 9 8 7 6\nf 8 10 11\n";
    const Lattice mesh = readMesh(text);
    EXPECT_EQ(mesh.complex.count(2), 6);
    // 3 · 3 − 2 edges around the shared edge, 4 of the squares, 3 of the last triangle.
    EXPECT_EQ(mesh.complex.count(1), 7 + 4 + 3);
    EXPECT_EQ(writtenMesh(mesh), text);
    expectSameMesh(readMesh(writtenMesh(mesh)), mesh);
}

TEST(ObjMesh, AcceptsDegenerateFacesAndUnusedVertices) {
    const std::string text = kSquares + "v 9 9 9\nf 1 2 2 5\n";
    const Lattice mesh = readMesh(text);
    EXPECT_EQ(loopsOf(mesh.complex)[2], (std::vector<Index>{0, 1, 1, 4}));
    EXPECT_EQ(mesh.complex.count(0), 7);
    EXPECT_EQ(mesh.positions[6], (Point3{9, 9, 9}));
    expectSameMesh(readMesh(writtenMesh(mesh)), mesh);
}

TEST(ObjMesh, CreasesAreEdgeMarks) {
    const auto edges = [](const std::string& tag) { return readMesh(kSquares + tag).marks.edges; };
    EXPECT_EQ(edges("t crease 2/1/0 1 4 2.5\n"), (EdgeMarks{{{1, 4}, 2.5}}));
    EXPECT_EQ(edges("t crease 2/1/0 4 1 2.5\n"), (EdgeMarks{{{1, 4}, 2.5}}));
    EXPECT_EQ(edges("t crease 4/1/0 4 5 0 1 3\n"), (EdgeMarks{{{0, 1}, 3}, {{4, 5}, 3}}));
    EXPECT_EQ(edges("t crease 4/2/0 4 5 0 1 3 0.5\n"), (EdgeMarks{{{0, 1}, 0.5}, {{4, 5}, 3}}));
    EXPECT_EQ(edges("t crease 2/1/0 \\\n 1 4 1\nt crease 2/1/0 0 1 2 # more\n"),
              (EdgeMarks{{{0, 1}, 2}, {{1, 4}, 1}}));
}

TEST(ObjMesh, CornersAreVertexMarks) {
    const auto vertices = [](const std::string& tag) {
        return readMesh(kSquares + tag).marks.vertices;
    };
    EXPECT_EQ(vertices("t corner 1/1/0 5 0.75\n"), (VertexMarks{{5, 0.75}}));
    EXPECT_EQ(vertices("t corner 3/1/0 5 0 2 1\n"), (VertexMarks{{0, 1}, {2, 1}, {5, 1}}));
    EXPECT_EQ(vertices("t corner 3/3/0 5 0 2 1 2 3\n"), (VertexMarks{{0, 2}, {2, 3}, {5, 1}}));
}

TEST(ObjMesh, HolesAreFaceMarksWithoutDuplicates) {
    EXPECT_THAT(readMesh(kSquares + "t hole 1/0/0 1\n").marks.holes, ElementsAre(1));
    EXPECT_THAT(readMesh(kSquares + "t hole 3/0/0 1 0 1\nt hole 1/0/0 0\n").marks.holes,
                ElementsAre(0, 1));
}

TEST(ObjMesh, TagsSetRefinementOptions) {
    const auto tags = [](const std::string& text) { return readMesh(kSquares + text).tags; };
    EXPECT_EQ(tags("t interpolateboundary 1/0/0 0\n"), RefinementTags{.boundary = Boundary::Open});
    EXPECT_EQ(tags("t interpolateboundary 1/0/0 1\n"), RefinementTags{.boundary = Boundary::Sharp});
    EXPECT_EQ(tags("t interpolateboundary 1/0/0 2\n"),
              RefinementTags{.boundary = Boundary::EdgeOnly});
    EXPECT_EQ(tags("t creasemethod 0/0/1 normal\n"), RefinementTags{.creasing = Creasing::Uniform});
    EXPECT_EQ(tags("t creasemethod 0/0/1 chaikin\n"),
              RefinementTags{.creasing = Creasing::Chaikin});
    EXPECT_EQ(tags("t smoothtriangles 0/0/1 catmark\n"),
              RefinementTags{.triangles = TriangleSubdivision::Catmark});
    EXPECT_EQ(tags("t smoothtriangles 0/0/1 smooth\n"),
              RefinementTags{.triangles = TriangleSubdivision::Smooth});
    for (const auto& [word, mode] : far::kFaceVaryingLinearWords)
        EXPECT_EQ(tags("t facevaryinginterpolateboundary 1/0/0 " +
                       std::to_string(static_cast<int>(mode)) + "\n"),
                  RefinementTags{.faceVarying = mode})
            << word;
    // OpenSubdiv numbers its modes so.
    EXPECT_EQ(tags("t facevaryinginterpolateboundary 1/0/0 0\n").faceVarying,
              far::FaceVaryingLinear::None);
    EXPECT_EQ(tags("t facevaryinginterpolateboundary 1/0/0 2\n").faceVarying,
              far::FaceVaryingLinear::CornersPlus1);
    EXPECT_EQ(tags("t facevaryinginterpolateboundary 1/0/0 5\n").faceVarying,
              far::FaceVaryingLinear::All);
    // The later tag wins.
    EXPECT_EQ(tags("t interpolateboundary 1/0/0 1\nt interpolateboundary 1/0/0 2\n"),
              RefinementTags{.boundary = Boundary::EdgeOnly});
}

TEST(ObjMesh, UnknownTagsAreIgnored) {
    expectSameMesh(readMesh(kSquares + "t facevaryingpropagatecorners 1/0/0 1\n"
                                       "t vertexedit 1/0/0\nt creases 2/1/0 0 99 x\nt Crease\n"),
                   readMesh(kSquares));
}

TEST(ObjMesh, SharpnessIsRoundedToStoredPrecision) {
    EXPECT_EQ(sharpnessOf("1.5"), 1.5);
    EXPECT_EQ(sharpnessOf("4.7"), double{4.7F});
    // This number is above the middle between the floats 1 and 1 + 2⁻²³ by less than the precision
    // of a double.
    EXPECT_EQ(sharpnessOf("1.00000005960464477539062500001"), 1 + 0x1p-23);
    EXPECT_EQ(sharpnessOf("9.9"), double{9.9F});
    for (const char* infinite : {"10", "10.0", "12", "9.99999999", "1e39", "inf"})
        EXPECT_EQ(sharpnessOf(infinite), kInfinitelySharp) << infinite;
    for (const char* none : {"0", "0.0", "-1", "-inf", "-1e39", "1e-60"})
        EXPECT_EQ(sharpnessOf(none), std::nullopt) << none;
}

TEST(ObjMesh, LaterMarksWin) {
    const Lattice mesh =
        readMesh(kSquares +
                 "t crease 4/1/0 1 4 0 1 3\nt crease 2/1/0 4 1 1\nt crease 2/1/0 0 1 0\n"
                 "t corner 2/1/0 0 1 3\nt corner 2/2/0 0 1 -1 12\n");
    EXPECT_EQ(mesh.marks.edges, (EdgeMarks{{{1, 4}, 1}}));
    EXPECT_EQ(mesh.marks.vertices, (VertexMarks{{1, kInfinitelySharp}}));
}

TEST(ObjMesh, ErrorsNameTheLineAndTheExpectation) {
    struct Case {
        const char* line;
        const char* cause;
    };
    for (const Case& bad : {
             Case{"v 1 2", "the line ends; expected z of a vertex"},
             {"v 1 2 z", "'z' is not a number; expected z of a vertex"},
             {"v 1 2 nan", "'nan' is not finite; expected z of a vertex"},
             {"v 1 2 3 red", "'red' is not a number; expected w or a colour after x y z"},
             {"f 1 2 x", "'x' is not a corner of a face; expected v, v/vt, v//vn or v/vt/vn"},
             {"f 1 2 5.", "'5.' is not a corner"},
             {"f 1 2 /5", "'/5' is not a corner"},
             {"f 1 2 5/x", "'5/x' is not a corner"},
             {"f 1 2 5/1/x", "'5/1/x' is not a corner"},
             {"f 1 2 5/1/1/1", "'5/1/1/1' is not a corner"},
             {"f 1 2 99999999999999999999", "'99999999999999999999' is not a corner"},
             {"f 1 2 0", "a face names vertex 0; expected 1 or more, or less than 0 to count back"},
             {"f 1 2 7", "a face names vertex 7; the file has 6"},
             {"f 1 2 5000000000", "a face names vertex 5000000000; the file has 6"},
             {"f 1 2 -7", "a face names vertex -7; there are 6 before it"},
             {"t", "the line ends; expected the name of a tag"},
             {"t crease", "the tag crease has counts ''; expected 2k/1/0 or 2k/k/0 for k edges"},
             {"t crease 2/1 0 1 1", "the tag crease has counts '2/1'; expected"},
             {"t crease 2/1/x 0 1 1", "the tag crease has counts '2/1/x'; expected"},
             {"t crease 2/1/0/0 0 1 1", "the tag crease has counts '2/1/0/0'; expected"},
             {"t crease 2/-1/0 0 1 1", "the tag crease has counts '2/-1/0'; expected"},
             {"t crease 3/1/0 0 1 4 1", "the tag crease has counts '3/1/0'; expected"},
             {"t crease 0/1/0 1", "the tag crease has counts '0/1/0'; expected"},
             {"t crease 2/0/0 0 1", "the tag crease has counts '2/0/0'; expected"},
             {"t crease 2/2/0 0 1 1 1", "the tag crease has counts '2/2/0'; expected"},
             {"t crease 6/2/0 0 1 1 2 3 4 1 1", "the tag crease has counts '6/2/0'; expected"},
             {"t crease 2/1/1 0 1 1 a", "the tag crease has counts '2/1/1'; expected"},
             {"t crease 2/1/0 0 1", "the tag crease ends after 2 words; expected 3"},
             {"t crease 2/1/0 0 1 1 1", "goes on with '1' after 3 words; expected no more"},
             {"t crease 4000000000/1/0 0 1", "ends after 2 words; expected 4000000001"},
             {"t crease 2/1/0 0 1.5 1", "the tag crease has '1.5'; expected a whole number"},
             {"t crease 2/1/0 0 1 hard", "the tag crease has 'hard'; expected a sharpness"},
             {"t crease 2/1/0 0 1 nan", "the tag crease has 'nan'; expected a sharpness"},
             {"t crease 2/1/0 0 6 1", "a tag names vertex 6; expected 0 to 5"},
             {"t crease 2/1/0 -1 0 1", "a tag names vertex -1; expected 0 to 5"},
             {"t crease 2/1/0 0 4 1",
              "a tag names edge (0, 4); expected two neighbouring vertices of a face"},
             {"t crease 2/1/0 0 0 1", "a tag names edge (0, 0); expected"},
             {"t crease 2/1/0 0 4 0", "a tag names edge (0, 4); expected"},
             {"t corner 2/0/0 0 1",
              "the tag corner has counts '2/0/0'; expected k/1/0 or k/k/0 for k vertices"},
             {"t corner 3/2/0 0 1 2 1 1", "the tag corner has counts '3/2/0'; expected"},
             {"t corner 1/1/0 6 1", "a tag names vertex 6; expected 0 to 5"},
             {"t corner 1/1/0 5000000000 1", "a tag names vertex 5000000000; expected 0 to 5"},
             {"t hole 0/0/0", "the tag hole has counts '0/0/0'; expected k/0/0 for k faces"},
             {"t hole 1/1/0 0 1", "the tag hole has counts '1/1/0'; expected"},
             {"t hole 1/0/0 2", "a tag names face 2; expected 0 to 1"},
             {"t interpolateboundary 1/0/0 3",
              "the tag interpolateboundary is 3; expected 0, 1 or 2"},
             {"t interpolateboundary 1/0/0 -1", "the tag interpolateboundary is -1; expected"},
             {"t interpolateboundary 0/0/0", "has counts '0/0/0'; expected 1/0/0"},
             {"t facevaryinginterpolateboundary 1/0/0 6",
              "the tag facevaryinginterpolateboundary is 6; expected 0 to 5"},
             {"t facevaryinginterpolateboundary 1/0/0 -1", "is -1; expected 0 to 5"},
             {"t facevaryinginterpolateboundary 0/0/1 all", "has counts '0/0/1'; expected 1/0/0"},
             {"t creasemethod 0/0/1 uniform",
              "the tag creasemethod is 'uniform'; expected normal or chaikin"},
             {"t creasemethod 1/0/0 1", "has counts '1/0/0'; expected 0/0/1"},
             {"t smoothtriangles 0/0/1 loop",
              "the tag smoothtriangles is 'loop'; expected catmark or smooth"},
             {"t smoothtriangles 0/0/1", "the tag smoothtriangles ends after 0 words; expected 1"},
         }) {
        const std::string refused = refusalOfLine(bad.line);
        EXPECT_THAT(refused, StartsWith(":9: ")) << bad.line;
        EXPECT_THAT(refused, HasSubstr(bad.cause)) << bad.line;
    }
    // Messages give the line on which the statement begins; continued lines count.
    EXPECT_THAT(refusalOfMesh("g a \\\n b\n" + kSquares + "t hole 1/0/0 \\\n 7\n"),
                StartsWith(":11: "));
}

TEST(ObjMesh, TopologyErrorsNameTheLineAndKeepTheirCause) {
    const auto expectRefused = [](far::TopologyCause cause, Entity entity, const std::string& what,
                                  const std::string& text) {
        const TemporaryFolder folder;
        const std::string path = (folder / "a.obj").string();
        putLatticeFile(path, text);
        const auto error = topologyErrorOf([&] { io::readRefinable(path); });
        EXPECT_EQ(error.cause(), cause);
        EXPECT_EQ(error.entity(), entity);
        EXPECT_THAT(error.what(), StartsWith(path + what));
    };
    expectRefused(far::TopologyCause::TooFewVertices, {2, 2}, ":9: face 2: loop (0, 1) has fewer",
                  kSquares + "f 1 2\n");
    expectRefused(far::TopologyCause::TooFewVertices, {2, 2}, ":9: face 2: loop () has fewer",
                  kSquares + "f\n");
    expectRefused(far::TopologyCause::EmptyComplex, {2, 0}, ": there is no face", kVertices);
    expectRefused(far::TopologyCause::EmptyComplex, {2, 0}, ": there is no face", "");
}

}  // namespace
}  // namespace espalier::test
