// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/lattice.h>

#include <algorithm>
#include <random>
#include <span>
#include <vector>

#include "support/complexes.h"

namespace espalier::test {

/// Random numbers that are the same everywhere: those of std::mt19937 are prescribed, what the
/// standard distributions and std::shuffle make of them is not. Draw once in a statement: the order
/// of two draws in one expression may differ between compilers.
class Draws {
public:
    explicit Draws(unsigned seed) : engine_(seed) {}

    /// From 0 to count − 1. (All but uniform, for these small counts.)
    Index below(std::size_t count) { return Index(engine_() % count); }

    /// True once in `count` times.
    bool oneIn(std::size_t count) { return below(count) == 0; }

    /// From −1 to 1, exact in single precision.
    double fromMinusToOne() { return double(below(1 << 21)) / (1 << 20) - 1; }

    template <class T>
    void shuffle(std::vector<T>& values) {
        for (std::size_t i = values.size(); i > 1; --i) {
            const auto other = std::size_t(below(i));
            std::swap(values[i - 1], values[other]);
        }
    }

private:
    std::mt19937 engine_;
};

/// Adds marks of random sharpness on the given edges and vertices: one in five infinite, the others
/// from 0.1 to 9.9, half of these below 3 so that they run out soon.
///
/// OpenSubdiv adds up sharpness in single precision, in an order of its own. So that sums are exact
/// and do not depend on it, what meets two other semi-sharp things in a vertex has multiples of
/// 1/4; the rest tenths. Under Creasing::Chaikin, which divides by the number of semi-sharp edges
/// at a vertex less one, an edge that would be the fourth is left out.
inline void addRandomSharpness(Lattice& lattice, std::span<const Index> edges,
                               std::span<const Index> vertices, far::Creasing creasing,
                               Draws& draws) {
    const auto ends = [&](Index edge) { return lattice.complex.relation(1, 0)[edge]; };
    const auto vertexCount = std::size_t(lattice.complex.count(0));
    std::vector<int> semiSharpEdges(vertexCount, 0), semiSharp(vertexCount, 0);
    const auto countAt = [](std::vector<int>& counts, Index vertex) -> int& {
        return counts[vertex];
    };
    std::vector<Index> semiSharpOnes;
    for (const Index edge : edges) {
        if (draws.oneIn(5)) {
            lattice.marks.edges.push_back({{ends(edge)[0], ends(edge)[1]}, 10});
            continue;
        }
        const bool isFull = std::any_of(ends(edge).begin(), ends(edge).end(), [&](Index end) {
            return countAt(semiSharpEdges, end) == 3;
        });
        if (creasing == far::Creasing::Chaikin && isFull) continue;
        semiSharpOnes.push_back(edge);
        for (const Index end : ends(edge)) {
            ++countAt(semiSharpEdges, end);
            ++countAt(semiSharp, end);
        }
    }
    std::vector<Index> semiSharpVertices;
    for (const Index vertex : vertices) {
        if (draws.oneIn(5)) {
            lattice.marks.vertices.push_back({vertex, 10});
        } else {
            semiSharpVertices.push_back(vertex);
            ++countAt(semiSharp, vertex);
        }
    }
    const auto draw = [&](bool isCrowded) {
        const bool isLow = draws.oneIn(2);
        return isCrowded ? (1 + draws.below(isLow ? 11 : 39)) / 4.0
                         : (1 + draws.below(isLow ? 29 : 99)) / 10.0;
    };
    for (const Index edge : semiSharpOnes) {
        const Index tail = ends(edge)[0], head = ends(edge)[1];
        const bool isCrowded = countAt(semiSharp, tail) > 2 || countAt(semiSharp, head) > 2;
        lattice.marks.edges.push_back({{tail, head}, draw(isCrowded)});
    }
    for (const Index vertex : semiSharpVertices)
        lattice.marks.vertices.push_back({vertex, draw(countAt(semiSharp, vertex) > 2)});
}

/// The same mesh with a third of its edges and an eighth of its vertices, at random, given random
/// sharpness.
inline Lattice randomCreases(Lattice mesh, unsigned seed, far::Creasing creasing) {
    Draws draws(seed);
    std::vector<Index> edges, vertices;
    for (Index edge = 0; edge < mesh.complex.count(1); ++edge)
        if (draws.oneIn(3)) edges.push_back(edge);
    for (Index vertex = 0; vertex < mesh.complex.count(0); ++vertex)
        if (draws.oneIn(8)) vertices.push_back(vertex);
    draws.shuffle(edges);
    addRandomSharpness(mesh, edges, vertices, creasing, draws);
    mesh.tags.creasing = creasing;
    return mesh;
}

}  // namespace espalier::test
