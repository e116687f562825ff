// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/lattice.h>

#include <algorithm>
#include <random>
#include <span>
#include <vector>

#include "support/complexes.h"

namespace espalier::test {

/// Random numbers that are the same on every platform. The standard prescribes the numbers of
/// std::mt19937, but not the results of its distributions and of std::shuffle. Draw once per
/// statement, because the order of two draws in one expression may differ between compilers.
class Draws {
public:
    explicit Draws(unsigned seed) : engine_(seed) {}

    /// Returns a number from 0 to count − 1, nearly uniform for small counts.
    Index below(std::size_t count) { return Index(engine_() % count); }

    /// Returns true with probability 1 / count.
    bool oneIn(std::size_t count) { return below(count) == 0; }

    /// Returns a number from −1 to 1 that is exact in single precision.
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

/// Adds marks of random sharpness on the given edges and vertices: one in five is infinite, the
/// others are from 0.1 to 9.9, half of them below 3 so that they fade soon.
///
/// OpenSubdiv adds sharpness values in single precision, in an order that we do not know. To make
/// sums exact in any order, a mark that meets two other semi-sharp marks in a vertex gets a
/// multiple of 1/4; other marks get tenths. Creasing::Chaikin divides by the number of semi-sharp
/// edges at a vertex less one, so a fourth edge at a vertex gets no mark.
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

/// Returns the mesh with random sharpness on a third of its edges and an eighth of its vertices,
/// chosen at random.
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
