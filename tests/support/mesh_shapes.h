// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/lattice.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "support/complexes.h"

// Meshes to which meshes.h adds features.
namespace espalier::test {

inline Lattice mesh(std::vector<Point3> positions, const Loops& loops) {
    far::CellComplex complex = far::buildMesh(Index(positions.size()), loops);
    return {std::move(complex), std::move(positions), {}, {}};
}

inline Loops loopsOf(const Lattice& mesh) {
    Loops loops;
    for (Index face = 0; face < mesh.complex.count(2); ++face) {
        const auto row = mesh.complex.relation(2, 0)[face];
        loops.emplace_back(row.begin(), row.end());
    }
    return loops;
}

/// Returns the same mesh with some faces reversed.
template <class IsTurned>
Lattice turned(const Lattice& given, IsTurned isTurned) {
    Loops loops = loopsOf(given);
    for (std::size_t face = 0; face < loops.size(); ++face)
        if (isTurned(Index(face))) std::reverse(loops[face].begin(), loops[face].end());
    Lattice result = given;
    result.complex = mesh(given.positions, loops).complex;
    return result;
}

/// Joins two meshes to one mesh of two pieces, with the second moved along x.
inline Lattice together(const Lattice& first, const Lattice& second, double distance) {
    Loops loops = loopsOf(first);
    std::vector<Point3> positions = first.positions;
    for (std::vector<Index> loop : loopsOf(second)) {
        for (Index& vertex : loop) vertex += first.complex.count(0);
        loops.push_back(std::move(loop));
    }
    for (const Point3& p : second.positions) positions.push_back({p[0] + distance, p[1], p[2]});
    return mesh(std::move(positions), loops);
}

/// Returns the boundary of a lattice as a mesh, wound anticlockwise from outside. Vertices keep
/// their order, and their numbers if the lattice has no interior vertex. Marks and tags are not
/// copied.
inline Lattice surfaceOf(const Lattice& solid) {
    Loops loops;
    std::vector<char> isUsed(solid.complex.count(0), 0);
    for (Index cell = 0; cell < solid.complex.count(3); ++cell) {
        const auto faces = solid.complex.relation(3, 2)[cell];
        const Loops cellLoops = far::outwardLoops(solid.complex, CellId(cell));
        for (std::size_t i = 0; i < cellLoops.size(); ++i) {
            if (solid.complex.relation(2, 3)[faces[i]].size() == 2) continue;
            for (const Index vertex : cellLoops[i]) isUsed[vertex] = 1;
            loops.push_back(cellLoops[i]);
        }
    }
    std::vector<Index> names(isUsed.size(), 0);
    std::vector<Point3> positions;
    for (std::size_t vertex = 0; vertex < isUsed.size(); ++vertex)
        if (isUsed[vertex] != 0) {
            names[vertex] = Index(positions.size());
            positions.push_back(solid.positions[vertex]);
        }
    for (auto& loop : loops)
        for (Index& vertex : loop) vertex = names[vertex];
    return mesh(std::move(positions), loops);
}

/// Returns a cube. Vertices 0 to 3 are the bottom, 4 to 7 are above them; the first face is the
/// bottom, the second the top.
inline Lattice cubeSurface() {
    return mesh(
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
        {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

/// Returns a mesh of n × n quadrilaterals. If isSplit(i, j) is true, quadrilateral (i, j) is cut
/// into two triangles from (i, j) to (i + 1, j + 1). Vertex (i, j) is i + (n + 1) j; without cuts,
/// face (i, j) is i + n j.
template <class IsSplit>
Lattice patch(Index n, IsSplit isSplit) {
    std::vector<Point3> positions;
    for (Index j = 0; j <= n; ++j)
        for (Index i = 0; i <= n; ++i)
            positions.push_back({double(i), double(j), 0.1 * double(i * j % 4)});
    Loops loops;
    for (Index j = 0; j < n; ++j)
        for (Index i = 0; i < n; ++i) {
            const Index a = i + (n + 1) * j, b = a + 1, c = b + n + 1, d = a + n + 1;
            if (isSplit(i, j)) {
                loops.push_back({a, b, c});
                loops.push_back({a, c, d});
            } else {
                loops.push_back({a, b, c, d});
            }
        }
    return mesh(std::move(positions), loops);
}
inline Lattice patch(Index n) {
    return patch(n, [](Index, Index) { return false; });
}

/// Returns patch(6) with the four faces around its middle vertex joined to an octagon, which is the
/// last face. Vertices after the middle vertex have one number less.
inline Lattice octagonPatch() {
    const Lattice whole = patch(6);
    const Index middle = 24;
    Loops loops;
    for (const auto& loop : loopsOf(whole))
        if (!far::contains(loop, middle)) loops.push_back(loop);
    loops.push_back({16, 17, 18, 25, 32, 31, 30, 23});
    for (auto& loop : loops)
        for (Index& vertex : loop) vertex -= vertex > middle;
    std::vector<Point3> positions = whole.positions;
    positions.erase(positions.begin() + middle);
    return mesh(std::move(positions), loops);
}

/// Returns a disk of faces with the given numbers of sides around a vertex, and optionally a second
/// disk below it, around another vertex. The rim has vertices 0, 1, ...; the middle vertices
/// follow. A rim vertex that is only in two faces, one above and one below, has valence 2.
inline Lattice polygonDisk(const std::vector<Index>& above, const std::vector<Index>& below = {}) {
    Index rim = 0;
    for (const Index sides : above) rim += sides - 2;
    std::vector<Point3> positions;
    for (Index i = 0; i < rim; ++i) {
        const double angle = 2 * std::numbers::pi * i / rim;
        positions.push_back({std::cos(angle), std::sin(angle), 0});
    }
    Loops loops;
    const auto addSide = [&](const std::vector<Index>& polygons, double height) {
        const auto middle = Index(positions.size());
        positions.push_back({0, 0, height});
        Index start = 0;
        for (const Index sides : polygons) {
            std::vector<Index> loop = {middle};
            for (Index i = 0; i <= sides - 2; ++i) loop.push_back((start + i) % rim);
            if (height < 0) std::reverse(loop.begin(), loop.end());
            loops.push_back(std::move(loop));
            start += sides - 2;
        }
    };
    addSide(above, 0.5);
    if (!below.empty()) addSide(below, -0.5);
    return mesh(std::move(positions), loops);
}

/// Returns two polygons back to back, so that every vertex has valence 2.
inline Lattice lens(Index sides) {
    std::vector<Point3> positions;
    std::vector<Index> loop;
    for (Index i = 0; i < sides; ++i) {
        const double angle = 2 * std::numbers::pi * i / sides;
        positions.push_back({std::cos(angle), std::sin(angle), 0.2 * (i % 2)});
        loop.push_back(i);
    }
    return mesh(std::move(positions), {loop, {loop.rbegin(), loop.rend()}});
}

/// Returns a cone of triangles around vertex `sides`, over vertices 0 to sides − 1. It is closed
/// from below by a polygon, or by another cone around vertex sides + 1.
inline Lattice pole(Index sides, bool hasFlatBottom) {
    Loops loops = bipyramidLoops(sides);
    std::vector<Point3> positions = lens(sides).positions;
    positions.push_back({0, 0, 1});
    if (hasFlatBottom) {
        std::erase_if(loops, [&](const auto& loop) { return far::contains(loop, sides + 1); });
        std::vector<Index> bottom;
        for (Index i = sides; i > 0; --i) bottom.push_back(i - 1);
        loops.push_back(std::move(bottom));
    } else {
        positions.push_back({0, 0, -1});
    }
    return mesh(std::move(positions), loops);
}

/// Returns fans of triangles around vertex 0: a path p₀ p₁ p₂ ... makes the triangles (0, p₀, p₁),
/// (0, p₁, p₂), ... A path that ends at its first vertex makes a closed fan.
inline Lattice fans(const Loops& paths) {
    Loops loops;
    Index count = 1;
    for (const auto& path : paths)
        for (std::size_t i = 1; i < path.size(); ++i) {
            loops.push_back({0, path[i - 1], path[i]});
            count = std::max({count, path[i - 1] + 1, path[i] + 1});
        }
    std::vector<Point3> positions = {{0, 0, 0}};
    for (Index i = 1; i < count; ++i)
        positions.push_back({std::cos(2.0 * i), std::sin(2.0 * i), 0.3 * i - 1});
    return mesh(std::move(positions), loops);
}

/// Returns fins along a chain of edges: edge i has vertices i and i + 1 and counts[i]
/// quadrilaterals, which all run along it in the same direction.
inline Lattice fins(const std::vector<Index>& counts) {
    const auto length = Index(counts.size());
    const Index most = *std::max_element(counts.begin(), counts.end());
    std::vector<Point3> positions;
    for (Index i = 0; i <= length; ++i) positions.push_back({double(i), 0, 0.1 * double(i * i)});
    Loops loops;
    for (Index fin = 0; fin < most; ++fin) {
        const double angle = 2 * std::numbers::pi * fin / most;
        Index last = -2;  // position on the chain up to which this fin is complete
        for (Index i = 0; i < length; ++i) {
            if (fin >= counts[i]) continue;
            for (Index at = last == i ? i + 1 : i; at <= i + 1; ++at)
                positions.push_back({double(at), std::cos(angle), std::sin(angle)});
            const auto end = Index(positions.size());
            loops.push_back({i, i + 1, end - 1, end - 2});
            last = i + 1;
        }
    }
    return mesh(std::move(positions), loops);
}

/// Returns a strip of n × width quadrilaterals, joined to itself with a half twist. At the seam,
/// adjacent faces run in the same direction along their common edges.
inline Lattice moebiusStrip(Index n, Index width) {
    std::vector<Point3> positions;
    for (Index i = 0; i < n; ++i)
        for (Index j = 0; j <= width; ++j) {
            const double angle = 2 * std::numbers::pi * i / n, across = double(j) / width - 0.5;
            const double radius = 2 + across * std::cos(angle / 2);
            positions.push_back(
                {radius * std::cos(angle), radius * std::sin(angle), across * std::sin(angle / 2)});
        }
    const auto vertexAt = [&](Index i, Index j) { return i < n ? i * (width + 1) + j : width - j; };
    Loops loops;
    for (Index i = 0; i < n; ++i)
        for (Index j = 0; j < width; ++j)
            loops.push_back(
                {vertexAt(i, j), vertexAt(i + 1, j), vertexAt(i + 1, j + 1), vertexAt(i, j + 1)});
    return mesh(std::move(positions), loops);
}

}  // namespace espalier::test
