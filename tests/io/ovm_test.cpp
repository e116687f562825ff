// SPDX-License-Identifier: Apache-2.0
#include "lattice_samples.h"
#include "support/test.h"

namespace espalier::test {
namespace {

/// A tetrahedron as OpenVolumeMesh itself writes it: normals of half-faces point inwards.
const std::string kTetrahedron =
    "OVM ASCII\n"
    "Vertices\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    "Edges\n6\n0 1\n1 2\n2 0\n0 3\n3 1\n3 2\n"
    "Faces\n4\n3 0 2 4\n3 6 8 1\n3 9 10 3\n3 11 7 5\n"
    "Polyhedra\n1\n4 0 2 4 6\n";

Lattice read(const std::string& text) {
    return latticeOf("a.ovm", text);
}

std::string refusal(const std::string& text) {
    return refusalOf("a.ovm", text);
}

/// Returns the text of the tetrahedron with one line replaced.
std::string changed(const std::string& line, const std::string& by) {
    std::string text = kTetrahedron;
    const std::size_t at = text.find("\n" + line + "\n") + 1;
    EXPECT_NE(at, 0u) << line;
    return text.replace(at, line.size(), by);
}

TEST(Ovm, ReadsATetrahedron) {
    const Lattice lattice = read(kTetrahedron);
    EXPECT_EQ(lattice.complex.count(0), 4);
    EXPECT_EQ(lattice.complex.count(1), 6);
    EXPECT_EQ(lattice.complex.count(2), 4);
    EXPECT_EQ(lattice.positions[3], (Point3{0, 0, 1}));
    // Face 0 has the vertices 0, 1, 2 and its normal points up, into the tetrahedron. Seen from
    // outside it is 0, 2, 1.
    EXPECT_EQ(orientedCells(lattice.complex)[0][1], (std::vector<Index>{0, 2, 1}));
    EXPECT_EQ(orientedCells(lattice.complex)[0],
              (std::vector<std::vector<Index>>{{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}}));
}

TEST(Ovm, TheHeadNeedNotSayAscii) {
    const std::string whole = kTetrahedron;
    const std::string rest = whole.substr(whole.find("Vertices"));
    for (const std::string head : {"", "OVM\n", "OVM # by a program\n"})
        EXPECT_EQ(read(head + rest).positions, read(whole).positions) << head;
}

TEST(Ovm, WritesWhatItReads) {
    EXPECT_EQ(writtenLattice("a.ovm", read(writtenLattice("a.ovm", read(kTetrahedron)))),
              writtenLattice("a.ovm", read(kTetrahedron)));
    EXPECT_THAT(writtenLattice("a.ovm", read(kTetrahedron)),
                StartsWith("OVM ASCII\nVertices\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\nEdges\n6\n"));
}

TEST(Ovm, IgnoresCommentsAndCase) {
    std::string text = "# by hand\n" + kTetrahedron;
    text.replace(text.find("OVM ASCII"), 9, "ovm Ascii   # header");
    text.replace(text.find("Edges"), 5, "EDGES # 6 of them\n#\n");
    text.replace(text.find("Polyhedra"), 9, "\n\n  polyhedra");
    expectSameLattice(read(text), read(kTetrahedron));
    // The first line may be missing, as OpenVolumeMesh allows, and lines may end as on Windows.
    std::string windows;
    for (const char c : kTetrahedron.substr(10)) windows += c == '\n' ? "\r\n" : std::string(1, c);
    expectSameLattice(read(windows), read(kTetrahedron));
}

TEST(Ovm, VertexPropertiesBecomeAttributes) {
    const Lattice lattice =
        read(kTetrahedron +
             "VProp int \"level\"\n1\n-2\n3\n4\n"
             "vprop float \"heat\"\n0.1\n2\n3\n4\n"
             "Vertex_Property double \"a \"quoted\" name\"\n0.1\n2\n3\n4\n"
             "VProp vec2d \"uv\"\n1 2\n3 4\n5 6\n7 8\n"
             "VProp vec3f \"n\"\n1 0 0\n1 0 0\n1 0 0\n1 0 0\n"
             "VProp vec4d \"q\"\n1 0 0 0\n1 0 0 0\n1 0 0 0\n1 0 0 5\n"
             "VProp vector_double \"even\"\n2\n1\n2\n2\n3\n4\n2\n5\n6\n2\n7\n8\n"
             "VProp vector_double \"odd\"\n1\n1\n0\n2\n5\n6\n1\n7\n");
    std::vector<std::string> names;
    for (const auto& attribute : lattice.attributes) names.push_back(attribute.name);
    EXPECT_THAT(names, ElementsAre("heat", "a \"quoted\" name", "uv", "n", "q", "even"));
    EXPECT_EQ(lattice.integers.at(0).name, "level");
    EXPECT_EQ(lattice.integers[0].type, IntegerType::Int32);
    EXPECT_THAT(lattice.integers[0].values, ElementsAre(1, -2, 3, 4));
    EXPECT_THAT(lattice.attributes[0].values, ElementsAre(double{0.1f}, 2, 3, 4));
    EXPECT_THAT(lattice.attributes[1].values, ElementsAre(0.1, 2, 3, 4));
    EXPECT_THAT(lattice.attributes[2].values, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
    EXPECT_EQ(lattice.attributes[4].components, 4);
    EXPECT_THAT(lattice.attributes[5].values, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
}

TEST(Ovm, OtherPropertiesAreSkipped) {
    const Lattice lattice =
        read(kTetrahedron +
             "VProp bool \"selected\"\n1\n0\n1\n0\n"
             // A string that looks like a property, one with an empty line, and two empty ones.
             "VProp string \"labels\"\n16:VProp double \"x\"\n3:\n\n#\n0:\n0:\n"
             "HEProp int \"h\"\n0\n1\n2\n3\n4\n5\n6\n7\n8\n9\n10\n11\n"
             "FProp vec3d \"normal\"\n0 0 1\n0 0 1\n0 0 1\n0 0 1\n"
             "MProp map_heh_int \"map\"\n2\n0\n1\n2\n3\n"
             "CProp string \"name\"\n3:tet\n"
             "EProp double \"length\"\n1\n1\n1\n2\n2\n2\n"
             "VProp double \"last\"\n1\n2\n3\n4\n");
    ASSERT_EQ(lattice.attributes.size(), 1u);
    EXPECT_EQ(lattice.attributes[0].name, "last");
    EXPECT_THAT(lattice.attributes[0].values, ElementsAre(1, 2, 3, 4));
}

TEST(Ovm, MarksAreProperties) {
    const Lattice lattice =
        read(kTetrahedron + "EProp double \"espalier:edge_sharpness\"\n-1\n-1\n0\n-1\n10\n2.5\n" +
             "VProp double \"espalier:vertex_sharpness\"\n1e9\n-1\n-1\n0\n");
    EXPECT_TRUE(lattice.attributes.empty());
    // Edges 2, 4 and 5 are 2–0, 3–1 and 3–2.
    EXPECT_EQ(lattice.marks.edges,
              (std::vector<far::Marks::Edge>{
                  {{0, 2}, 0}, {{1, 3}, far::kInfinitelySharp}, {{2, 3}, 2.5}}));
    EXPECT_EQ(lattice.marks.vertices,
              (std::vector<far::Marks::Vertex>{{0, far::kInfinitelySharp}, {3, 0}}));
}

TEST(Ovm, NaNMarksAreRefused) {
    EXPECT_THAT(
        refusal(kTetrahedron + "VProp double \"espalier:vertex_sharpness\"\n1e9\n-1\nnan\n0\n"),
        HasSubstr("value 2 of 'espalier:vertex_sharpness', counted from 0, is NaN; expected"));
    EXPECT_THAT(refusal(kTetrahedron +
                        "EProp double \"espalier:edge_sharpness\"\n-1\n-nan\n0\n-1\n10\n2.5\n"),
                HasSubstr("value 1 of 'espalier:edge_sharpness', counted from 0, is NaN"));
}

TEST(Ovm, RefusesAttributesWithReservedNames) {
    EXPECT_THAT(refusal(kTetrahedron + "VProp double \"espalier:colour\"\n1\n2\n3\n4\n"),
                StartsWith(": the attribute 'espalier:colour' has 1 components and is not a known "
                           "mark; names that begin with 'espalier:' are reserved for marks: rename "
                           "the attribute"));
}

TEST(Ovm, ErrorsNameTheOffender) {
    EXPECT_THAT(refusal("OVM BINARY\n"), StartsWith(":1: is an OVM file of kind 'binary'; only"));
    EXPECT_THAT(refusal("solid\n"), StartsWith(":1: is not an OVM file: expected Vertices"));
    EXPECT_THAT(refusal(changed("0 0 1", "0 0 x")), StartsWith(":7: 'x' is not a number"));
    EXPECT_THAT(refusal(changed("0 0 1", "0 0 inf")), HasSubstr("point 3 is not finite"));
    EXPECT_THAT(refusal(changed("Edges", "Kanten")),
                StartsWith(":8: expected Edges, got 'Kanten'"));
    EXPECT_THAT(refusal(changed("3 2", "3 4")), HasSubstr("a vertex of an edge is 4; there are 4"));
    EXPECT_THAT(refusal(changed("3 2", "3 -1")), HasSubstr("'-1' is not a number"));
    EXPECT_THAT(refusal(changed("3 11 7 5", "3 12 7 5")),
                HasSubstr("a half-edge is 12; there are 12"));
    EXPECT_THAT(refusal(changed("3 11 7 5", "3 10 7 5")),
                StartsWith(":21: the half-edges of face 3 do not form a loop"));
    EXPECT_THAT(refusal(changed("3 11 7 5", "2 11 7")), HasSubstr("face 3 do not form a loop"));
    EXPECT_THAT(refusal(changed("4 0 2 4 6", "4 0 2 4 8")),
                HasSubstr("a half-face is 8; there are 8"));
    EXPECT_THAT(refusal(kTetrahedron + "heat 1 2 3 4\n"),
                HasSubstr("expected a property, got 'heat'"));
    EXPECT_THAT(refusal(kTetrahedron + "VProp int heat\n1 2 3 4\n"),
                HasSubstr("has no name in quotes"));
    EXPECT_THAT(refusal(kTetrahedron + "VProp int \"heat\"\n1 2 3"),
                HasSubstr("the number of values of a property is 4, but only"));
    EXPECT_THAT(refusal(kTetrahedron + "VProp string \"name\"\n9:abc\n"),
                HasSubstr("expected a string"));
    EXPECT_THAT(refusal(kTetrahedron + "VProp string \"name\"\nabc\n"), HasSubstr("and a colon"));
}

TEST(Ovm, UnusedPartsAreDroppedWithANote) {
    // A cell without its last face is open.
    EXPECT_THAT(refusal(changed("4 0 2 4 6", "3 0 2 4")), HasSubstr("cell 0 is open"));
    std::string more = changed("3 2", "3 2\n0 1\n1 2");
    more.replace(more.find("Edges\n6"), 7, "Edges\n8");
    more.replace(more.find("Faces\n4"), 7, "Faces\n5");
    more.insert(more.find("Polyhedra"), "3 0 2 4\n");
    io::ReadNotes unused;
    expectSameLattice(io::readLattice("a.ovm", more, &unused), read(kTetrahedron));
    EXPECT_EQ(io::describe("a.ovm", unused),
              "a.ovm: dropped 2 edges of no face (the first is edge 6); dropped 1 face of no "
              "polyhedron (face 4)");
    EXPECT_THAT(
        refusal(more + "EProp double \"espalier:edge_sharpness\"\n0\n0\n0\n0\n0\n0\n-1\n-1\n"), "");
    std::string vertex = changed("0 0 1", "0 0 1\n9 9 9");
    vertex.replace(vertex.find("Vertices\n4"), 10, "Vertices\n5");
    io::ReadNotes notes;
    expectSameLattice(io::readLattice("a.ovm", vertex, &notes), read(kTetrahedron));
    EXPECT_THAT(notes.droppedVertices, ElementsAre(4));
}

TEST(Ovm, TopologyErrorsKeepTheirCauseAndNameTheFile) {
    const TemporaryFolder folder;
    // The same without face 3.
    std::string open = changed("4 0 2 4 6", "3 0 2 4");
    open.replace(open.find("Faces\n4"), 7, "Faces\n3");
    open.erase(open.find("3 11 7 5\n"), 9);
    putLatticeFile(folder / "open.ovm", open);
    const auto error = topologyErrorOf([&] { io::readLattice(folder / "open.ovm"); });
    EXPECT_EQ(error.cause(), far::TopologyCause::OpenCell);
    EXPECT_EQ(error.entity(), (Entity{3, 0}));
    EXPECT_THAT(error.what(), StartsWith((folder / "open.ovm").string() + ": cell 0 is open"));
}

TEST(Ovm, ClaimedSizesAreCheckedBeforeAllocating) {
    for (const std::string claim : {"18446744073709551615", "3000000000", "100"}) {
        for (const char* section : {"Vertices\n4", "Edges\n6", "Faces\n4", "Polyhedra\n1"}) {
            std::string text = kTetrahedron;
            const std::string before = section;
            text.replace(text.find(before), before.size(),
                         before.substr(0, before.find('\n') + 1) + claim);
            EXPECT_NE(refusal(text), "") << section;
        }
        EXPECT_NE(refusal(changed("3 11 7 5", claim + " 11 7 5")), "");
        EXPECT_NE(refusal(changed("4 0 2 4 6", claim + " 0 2 4 6")), "");
        EXPECT_NE(refusal(kTetrahedron + "VProp string \"s\"\n" + claim + ":abc\n"), "");
        EXPECT_NE(refusal(kTetrahedron + "VProp vector_double \"v\"\n" + claim + "\n1\n"), "");
    }
}

TEST(Ovm, RefusesToWriteNamesWithLineEnds) {
    Lattice lattice = boxLattice();
    lattice.attributes = {{"a\nb", 1, std::vector<double>(12)}};
    EXPECT_THROW(writtenLattice("a.ovm", lattice), io::FileError);
}

}  // namespace
}  // namespace espalier::test
