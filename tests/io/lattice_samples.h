// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/standard_cells.h>
#include <espalier/io/files/file.h>
#include <espalier/io/lattice_file.h>
#include <support/complexes.h>
#include <support/lattice_identity.h>
#include <support/temporary_folder.h>

#include <bit>
#include <cstdint>
#include <fstream>

#include "support/test.h"

// Lattices to write and to read, and their comparison.

namespace espalier::test {

inline void putLatticeFile(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

/// Reads bytes as a lattice; the extension of `name` gives the format.
inline Lattice latticeOf(const std::string& name, const std::string& bytes) {
    const TemporaryFolder folder;
    putLatticeFile(folder / name, bytes);
    return io::readLattice(folder / name);
}

/// Returns the message, after the path, with which read(path) refuses these bytes; empty if it
/// accepts them.
template <class Read>
std::string refusalOf(const std::string& name, const std::string& bytes, Read read) {
    const TemporaryFolder folder;
    const std::string path = (folder / name).string();
    putLatticeFile(path, bytes);
    try {
        read(path);
    } catch (const Error& error) {
        const std::string what = error.what();
        EXPECT_EQ(what.rfind(path, 0), 0u) << "the message lacks the path: " << what;
        EXPECT_EQ(what.find('\n'), std::string::npos) << "not one line: " << what;
        return what.substr(std::min(what.size(), path.size()));
    }
    return "";
}

inline std::string refusalOf(const std::string& name, const std::string& bytes) {
    return refusalOf(name, bytes, [](const std::string& path) { io::readLattice(path); });
}

/// Returns the bytes of the file to which a lattice is written.
inline std::string writtenLattice(const std::string& name, const Lattice& lattice,
                                  const io::WriteLatticeOptions& options = {}) {
    const TemporaryFolder folder;
    io::writeLattice(folder / name, lattice, options);
    return io::readFile(folder / name);
}

/// Returns a number that does not survive careless formatting.
inline double awkwardNumber(std::size_t i) {
    constexpr double kNumbers[] = {0.1, -1.0 / 3,          5e-324, -0.0, 1e300, 1e-17, 16777217,
                                   2.5, 1.0000000000000002};
    return kNumbers[i % std::size(kNumbers)];
}

inline Lattice withAwkwardPositions(CellComplex complex) {
    Lattice lattice;
    lattice.complex = std::move(complex);
    lattice.positions.resize(lattice.complex.count(0));
    std::size_t i = 0;
    for (Point3& position : lattice.positions)
        for (double& coordinate : position) coordinate = awkwardNumber(i++);
    return lattice;
}

/// 2 × 1 × 1 hexahedra.
inline Lattice boxLattice() {
    far::ComplexBuilder builder(3, 12);
    builder.addCell(far::StandardCell::Hexahedron, {0, 1, 4, 3, 6, 7, 10, 9});
    builder.addCell(far::StandardCell::Hexahedron, {1, 2, 5, 4, 7, 8, 11, 10});
    return withAwkwardPositions(builder.build());
}

/// A hexahedron, a pyramid on it, a wedge beside it and a tetrahedron on that.
inline Lattice mixedLattice() {
    return withAwkwardPositions(mixedCells());
}

/// A prism over a pentagon (not a standard cell) and a hexahedron beside it, with faces wound
/// either way.
inline Lattice polyhedralLattice() {
    far::ComplexBuilder builder(3, 14);
    const std::vector<std::vector<Index>> prism = {{4, 3, 2, 1, 0}, {5, 6, 7, 8, 9}, {0, 1, 6, 5},
                                                   {1, 2, 7, 6},    {8, 7, 2, 3},    {3, 4, 9, 8},
                                                   {5, 9, 4, 0}};
    builder.addCell(prism);
    builder.addCell(far::StandardCell::Hexahedron, {0, 10, 11, 1, 5, 12, 13, 6});
    return withAwkwardPositions(builder.build());
}

/// Adds marks and attributes of all kinds to a lattice.
inline Lattice withMarksAndAttributes(Lattice lattice) {
    const auto edge = [&](Index e) {
        const auto ends = lattice.complex.relation(1, 0)[e];
        return std::array<Index, 2>{std::min(ends[0], ends[1]), std::max(ends[0], ends[1])};
    };
    lattice.marks.edges = {{edge(3), far::kInfinitelySharp}, {edge(5), 0}, {edge(1), 2.5}};
    std::sort(lattice.marks.edges.begin(), lattice.marks.edges.end(),
              [](const auto& a, const auto& b) { return a.vertices < b.vertices; });
    lattice.marks.vertices = {{0, 0}, {2, far::kInfinitelySharp}, {7, 0.1}};
    for (const int components : {1, 2, 3, 4, 6}) {
        VertexAttribute attribute{"a & <b> " + std::to_string(components), components, {}};
        for (std::size_t i = 0; i < lattice.positions.size() * std::size_t(components); ++i)
            attribute.values.push_back(awkwardNumber(3 * i + 1));
        attribute.values[1] = kInfinity;
        attribute.values[2] = kNan;
        lattice.attributes.push_back(attribute);
    }
    return lattice;
}

inline std::vector<Lattice> sampleLattices() {
    return {boxLattice(),
            mixedLattice(),
            polyhedralLattice(),
            withMarksAndAttributes(boxLattice()),
            withMarksAndAttributes(mixedLattice()),
            withMarksAndAttributes(polyhedralLattice())};
}

inline void expectSameLattice(const Lattice& got, const Lattice& expected) {
    for (int d = 0; d <= 3; ++d) EXPECT_EQ(got.complex.count(d), expected.complex.count(d));
    EXPECT_EQ(orientedCells(got.complex), orientedCells(expected.complex));
    EXPECT_EQ(bitsOf(got.positions), bitsOf(expected.positions));
    EXPECT_EQ(got.marks, expected.marks);
    ASSERT_EQ(got.attributes.size(), expected.attributes.size());
    for (std::size_t i = 0; i < got.attributes.size(); ++i) {
        EXPECT_EQ(got.attributes[i].name, expected.attributes[i].name);
        EXPECT_EQ(got.attributes[i].components, expected.attributes[i].components);
        EXPECT_EQ(bitsOf(got.attributes[i].values), bitsOf(expected.attributes[i].values));
    }
    ASSERT_EQ(got.integers.size(), expected.integers.size());
    for (std::size_t i = 0; i < got.integers.size(); ++i) {
        EXPECT_EQ(got.integers[i].name, expected.integers[i].name);
        EXPECT_EQ(got.integers[i].components, expected.integers[i].components);
        EXPECT_EQ(got.integers[i].type, expected.integers[i].type);
        EXPECT_EQ(got.integers[i].values, expected.integers[i].values);
    }
}

}  // namespace espalier::test
