// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/solids.h>

#include <utility>
#include <vector>

#include "support/mesh_shapes.h"
#include "support/zoo.h"

// The closed meshes for which Azlan & Misro show the refinement and its counts.
namespace espalier::test {

/// Returns sixty golden rhombi: five around each of 12 vertices, four around each of 30 and three
/// around each of 20.
///
/// Let the vectors A, B, C be the vertices of a face of the icosahedron. The rhombus A, A + B, A +
/// B + C, A + C is spanned by B and C from A. Its angle at A is the angle between B and C, arctan
/// 2, so its diagonals have the golden ratio. Each face gives three rhombi, one from each of its
/// vertices. So each vertex, edge and face of the icosahedron gives one vertex, at the sum of its
/// ends or corners; the vertices are numbered in this order.
inline Lattice rhombicHexecontahedron() {
    const Lattice icosahedron = surfaceOf(shapes::icosahedron());
    const CellComplex& complex = icosahedron.complex;
    std::vector<Point3> positions;
    for (int d = 0; d <= 2; ++d)
        for (Index i = 0; i < complex.count(d); ++i) {
            Point3 sum = {0, 0, 0};
            for (const Index vertex : complex.relation(d, 0)[i])
                for (std::size_t c = 0; c < 3; ++c) sum[c] += icosahedron.positions[vertex][c];
            positions.push_back(sum);
        }
    const Index firstEdge = complex.count(0), firstFace = firstEdge + complex.count(1);
    Loops loops;
    for (Index face = 0; face < complex.count(2); ++face) {
        // Edge i joins vertices i and i + 1 of the loop.
        const auto vertices = complex.relation(2, 0)[face], edges = complex.relation(2, 1)[face];
        for (std::size_t i = 0; i < 3; ++i)
            loops.push_back({vertices[i], firstEdge + edges[i], firstFace + face,
                             firstEdge + edges[(i + 2) % 3]});
    }
    return mesh(std::move(positions), loops);
}

/// Returns the four polyhedra of the paper's tables as closed meshes, anticlockwise from outside:
/// cube, pyramid (on a square), dodecahedron and rhombic hexecontahedron.
inline std::vector<NamedLattice> namedPolyhedra() {
    return {{"cube", surfaceOf(shapes::cube())},
            {"pyramid", surfaceOf(shapes::pyramid())},
            {"dodecahedron", surfaceOf(shapes::dodecahedron())},
            {"rhombic hexecontahedron", rhombicHexecontahedron()}};
}

}  // namespace espalier::test
