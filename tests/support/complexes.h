// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_refiner.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace espalier::test {

using far::Boundary;
using far::CellComplex;
using far::TopologyRefiner;

using Loops = std::vector<std::vector<Index>>;

/// Returns a lattice of the given cells, each a list of loops.
inline CellComplex lattice(Index vertexCount, const std::vector<Loops>& cells) {
    far::ComplexBuilder builder(3, vertexCount);
    for (const Loops& loops : cells) builder.addCell(loops);
    return builder.build();
}

inline CellComplex singleCell(far::StandardCell cell) {
    far::ComplexBuilder builder(3, far::vertexCount(cell));
    std::vector<Index> vertices(far::vertexCount(cell));
    for (std::size_t i = 0; i < vertices.size(); ++i) vertices[i] = Index(i);
    builder.addCell(cell, vertices);
    return builder.build();
}

/// Returns vertex (i, j, k) of an nx × ny × nz grid of cells; i runs fastest.
inline Index gridVertex(const std::array<Index, 3>& cells, Index i, Index j, Index k) {
    return (k * (cells[1] + 1) + j) * (cells[0] + 1) + i;
}

/// Returns the vertices of grid cell (i, j, k), as a hexahedron.
inline std::array<Index, 8> gridCell(const std::array<Index, 3>& n, Index i, Index j, Index k) {
    return {gridVertex(n, i, j, k),
            gridVertex(n, i + 1, j, k),
            gridVertex(n, i + 1, j + 1, k),
            gridVertex(n, i, j + 1, k),
            gridVertex(n, i, j, k + 1),
            gridVertex(n, i + 1, j, k + 1),
            gridVertex(n, i + 1, j + 1, k + 1),
            gridVertex(n, i, j + 1, k + 1)};
}

inline CellComplex grid(const std::array<Index, 3>& n) {
    far::ComplexBuilder builder(3, (n[0] + 1) * (n[1] + 1) * (n[2] + 1));
    for (Index k = 0; k < n[2]; ++k)
        for (Index j = 0; j < n[1]; ++j)
            for (Index i = 0; i < n[0]; ++i)
                builder.addCell(far::StandardCell::Hexahedron, gridCell(n, i, j, k));
    return builder.build();
}

/// Returns a bipyramid over an n-gon. Vertices 0 to n − 1 are the n-gon, of valence 4; vertices n
/// and n + 1 are the apexes, of valence n.
inline Loops bipyramidLoops(Index n) {
    Loops loops;
    for (Index i = 0; i < n; ++i) {
        const Index next = (i + 1) % n;
        loops.push_back({i, next, n});
        loops.push_back({next, i, n + 1});
    }
    return loops;
}

inline CellComplex bipyramid(Index n) {
    return lattice(n + 2, {bipyramidLoops(n)});
}

/// Returns a hexahedron with a pyramid on top, a wedge at its side and a tetrahedron on the wedge.
inline CellComplex mixedCells() {
    far::ComplexBuilder builder(3, 12);
    builder.addCell(far::StandardCell::Hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
    builder.addCell(far::StandardCell::Pyramid, {4, 5, 6, 7, 8});
    builder.addCell(far::StandardCell::Wedge, {1, 9, 5, 2, 10, 6});
    builder.addCell(far::StandardCell::Tetrahedron, {1, 9, 5, 11});
    return builder.build();
}

/// Returns a mesh of nx × ny quadrilaterals.
inline CellComplex gridMesh(Index nx, Index ny) {
    Loops loops;
    for (Index j = 0; j < ny; ++j)
        for (Index i = 0; i < nx; ++i) {
            const Index v = j * (nx + 1) + i;
            loops.push_back({v, v + 1, v + nx + 2, v + nx + 1});
        }
    return far::buildMesh((nx + 1) * (ny + 1), loops);
}

/// Returns the cells of a complex, as loops anticlockwise from outside.
inline std::vector<Loops> cellLoops(const CellComplex& complex) {
    std::vector<Loops> cells;
    for (Index cell = 0; cell < complex.count(3); ++cell)
        cells.push_back(far::outwardLoops(complex, CellId(cell)));
    return cells;
}

/// Returns a random permutation of 0 to count − 1.
inline std::vector<Index> shuffledIndices(Index count, unsigned seed) {
    std::vector<Index> order(count);
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = Index(i);
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    return order;
}

/// Returns the same lattice with vertex v renamed to names[v], cells and faces in random order, and
/// loops with random start and direction.
inline CellComplex relabelled(const CellComplex& complex, const std::vector<Index>& names,
                              unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Loops> cells = cellLoops(complex);
    std::shuffle(cells.begin(), cells.end(), random);
    for (Loops& loops : cells) {
        std::shuffle(loops.begin(), loops.end(), random);
        for (auto& loop : loops) {
            for (Index& vertex : loop) vertex = names[vertex];
            std::rotate(loop.begin(), loop.begin() + std::ptrdiff_t(random() % loop.size()),
                        loop.end());
            if (random() % 2 == 0) std::reverse(loop.begin(), loop.end());
        }
    }
    return lattice(complex.count(0), cells);
}

/// Returns the vertices of a cell as a set.
inline std::set<Index> vertexSet(const CellComplex& complex, Index cell) {
    const auto row = complex.relation(3, 0)[cell];
    return {row.begin(), row.end()};
}

/// Returns the refiner of a complex, refined to a level.
inline far::TopologyRefiner refined(CellComplex base, int level,
                                    const far::RefinerOptions& options = {}) {
    far::TopologyRefiner refiner(std::move(base), options);
    refiner.refineUniform(level);
    return refiner;
}

/// A refiner of the same base with other rules, refined to the same level.
inline TopologyRefiner withRules(const TopologyRefiner& refiner, far::Rules rules) {
    far::RefinerOptions options = refiner.options();
    options.rules = rules;
    return refined(refiner.level(0).complex, refiner.maxLevel(), options);
}

}  // namespace espalier::test
