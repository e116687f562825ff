// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/lattice.h>

#include <span>
#include <utility>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::test {

/// Upper bound of rounding errors in sums of a few hundred terms of size 10.
inline constexpr double kRounding = 1e-12;

/// Numbers of vertices, edges, faces and cells.
using Counts = std::array<Index, 4>;

inline Counts countsOf(const CellComplex& complex) {
    return {complex.count(0), complex.count(1), complex.count(2), complex.count(3)};
}

/// Returns the counts of a swept mesh. Each entity of the mesh is copied to each layer, and sweeps
/// an entity of the next dimension in each row of cells.
inline Counts sweptCounts(Index vertices, Index edges, Index faces, Index rows, bool closed) {
    const Index layers = closed ? rows : rows + 1;
    return {layers * vertices, layers * edges + rows * vertices, layers * faces + rows * edges,
            rows * faces};
}

/// The same for a mesh that is a disk: V - E + F = 1.
inline Counts sweptDiskCounts(Index vertices, Index faces, Index rows, bool closed = false) {
    return sweptCounts(vertices, vertices + faces - 1, faces, rows, closed);
}

inline Point3 at(const Lattice& lattice, Index vertex) {
    return lattice.positions[vertex];
}

inline Point3 minus(const Point3& a, const Point3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline double triple(const Point3& a, const Point3& b, const Point3& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

inline double norm(const Point3& a) {
    return std::hypot(a[0], a[1], a[2]);
}

/// Returns the volume of a cell by the divergence theorem, with each face split into triangles at
/// its centroid. It is negative if the faces run clockwise seen from outside.
inline double signedVolume(const Lattice& lattice, Index cell) {
    const CellComplex& complex = lattice.complex;
    const auto faces = complex.boundary(3)[cell];
    const auto signs = complex.boundary(3).signs(cell);
    const Point3 origin = at(lattice, complex.relation(3, 0)[cell][0]);
    double volume = 0;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto loop = complex.relation(2, 0)[faces[f]];
        Point3 centre = {0, 0, 0};
        for (const Index vertex : loop)
            for (std::size_t axis = 0; axis < 3; ++axis)
                centre[axis] += at(lattice, vertex)[axis] / double(loop.size());
        for (std::size_t i = 0; i < loop.size(); ++i)
            volume += signs[f] *
                      triple(minus(centre, origin), minus(at(lattice, loop[i]), origin),
                             minus(at(lattice, loop[(i + 1) % loop.size()]), origin)) /
                      6;
    }
    return volume;
}

inline double totalVolume(const Lattice& lattice) {
    double volume = 0;
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell)
        volume += signedVolume(lattice, cell);
    return volume;
}

/// Expects of a lattice what the inventory promises: it is valid at levels 0 to 2 with its marks,
/// has no duplicate vertices, and has cells of positive volume.
inline void expectValid(const Lattice& lattice) {
    ASSERT_EQ(lattice.positions.size(), std::size_t(lattice.complex.count(0)));
    std::vector<Point3> sorted = lattice.positions;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end());
    for (Index cell = 0; cell < lattice.complex.count(3); ++cell)
        EXPECT_GT(signedVolume(lattice, cell), 0) << "cell " << cell;
    far::RefinerOptions options;
    options.marks = lattice.marks;
    TopologyRefiner refiner = test::refined(lattice.complex, 2, options);
    for (int level = 0; level <= 2; ++level) {
        EXPECT_NO_THROW(far::validate(refiner.level(level).complex)) << "level " << level;
        EXPECT_EQ(refiner.level(level).complex.eulerCharacteristic(),
                  lattice.complex.eulerCharacteristic());
    }
}

/// Returns true if two complexes are equal, entity by entity.
inline bool sameTopology(const CellComplex& a, const CellComplex& b) {
    if (a.dimension() != b.dimension() || a.count(0) != b.count(0)) return false;
    for (int d = 1; d <= a.dimension(); ++d) {
        if (a.count(d) != b.count(d)) return false;
        for (Index index = 0; index < a.count(d); ++index) {
            const auto rowA = a.boundary(d)[index];
            const auto rowB = b.boundary(d)[index];
            const auto signsA = a.boundary(d).signs(index);
            const auto signsB = b.boundary(d).signs(index);
            if (!std::equal(rowA.begin(), rowA.end(), rowB.begin(), rowB.end()) ||
                !std::equal(signsA.begin(), signsA.end(), signsB.begin(), signsB.end()))
                return false;
        }
    }
    return true;
}

/// Returns the edge that joins two vertices; it must exist.
inline Index edgeBetween(const CellComplex& complex, Index a, Index b) {
    for (const Index edge : complex.relation(0, 1)[a])
        if (far::contains(complex.relation(1, 0)[edge], b)) return edge;
    ADD_FAILURE() << "no edge (" << a << ", " << b << ")";
    return 0;
}

/// Returns the number n of edges of a cell at one of its vertices. Refinement makes a type-n cell
/// there.
inline std::size_t valenceInCell(const CellComplex& complex, Index cell, Index vertex) {
    std::size_t valence = 0;
    for (const Index edge : complex.relation(3, 1)[cell])
        valence += far::contains(complex.relation(1, 0)[edge], vertex) ? 1 : 0;
    return valence;
}

}  // namespace espalier::test
