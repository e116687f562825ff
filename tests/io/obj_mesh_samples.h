// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_match.h>
#include <espalier/io/lattice_file.h>
#include <espalier/io/models/obj_mesh.h>
#include <io/lattice_samples.h>

#include <optional>
#include <string>

// Meshes to write and to read as OBJ, and their comparison.

namespace espalier::test {

// Two squares side by side:
//
//     3 --- 4 --- 5
//     |  0  |  1  |
//     0 --- 1 --- 2
//
inline const std::string kVertices = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n";
inline const std::string kSquares = kVertices + "f 1 2 5 4\nf 2 3 6 5\n";  // 8 lines
inline const Loops kSquareLoops = {{0, 1, 4, 3}, {1, 2, 5, 4}};

inline Lattice readMesh(const std::string& text) {
    const TemporaryFolder folder;
    putLatticeFile(folder / "a.obj", text);
    return io::readRefinable(folder / "a.obj");
}

/// Returns the message, after the path, with which a mesh is refused; empty if it is accepted.
inline std::string refusalOfMesh(const std::string& text) {
    return refusalOf("a.obj", text, [](const std::string& path) { io::readRefinable(path); });
}

inline std::string writtenMesh(const Lattice& mesh) {
    const TemporaryFolder folder;
    io::writeObjMesh(folder / "a.obj", mesh);
    return io::readFile(folder / "a.obj");
}

inline Loops loopsOf(const far::CellComplex& mesh) {
    Loops loops;
    for (Index face = 0; face < mesh.count(2); ++face) {
        const auto loop = mesh.relation(2, 0)[face];
        loops.emplace_back(loop.begin(), loop.end());
    }
    return loops;
}

inline void expectSameMesh(const Lattice& got, const Lattice& expected) {
    EXPECT_EQ(far::topologyDifference(got.complex, expected.complex), std::nullopt);
    EXPECT_TRUE(loopsOf(got.complex) == loopsOf(expected.complex));
    EXPECT_TRUE(bitsOf(got.positions) == bitsOf(expected.positions));
    EXPECT_EQ(got.marks, expected.marks);
    EXPECT_EQ(got.tags, expected.tags);
    EXPECT_THAT(got.attributes, IsEmpty());
}

/// A mesh with marks of all kinds, in canonical form.
inline Lattice taggedMesh() {
    Lattice mesh = withAwkwardPositions(readMesh(kSquares + "v 7 7 7\nf 6 5 7\n").complex);
    mesh.marks.edges = {
        {{0, 1}, far::kInfinitelySharp}, {{1, 4}, double{4.7F}}, {{4, 6}, double{1e-42F}}};
    mesh.marks.vertices = {{0, double{0.1F}}, {6, far::kInfinitelySharp}};
    mesh.marks.holes = {0, 2};
    return mesh;
}

}  // namespace espalier::test
