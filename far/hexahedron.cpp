// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/hexahedron.h>

#include <algorithm>

namespace espalier::far {
namespace {

/// In a face of a hexahedron that holds the edge (corner, next): the other neighbour of `corner`.
std::optional<Index> otherNeighbour(std::span<const Index> loop, Index corner, Index next) {
    const std::size_t n = loop.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (loop[i] != corner) continue;
        const Index after = loop[(i + 1) % n], before = loop[(i + n - 1) % n];
        if (after == next) return before;
        if (before == next) return after;
    }
    return std::nullopt;
}

}  // namespace

std::optional<std::array<Index, 8>> hexahedronVertices(const CellComplex& complex, CellId cell) {
    const auto faces = complex.relation(3, 2)[cell.value];
    const Incidence& loops = complex.relation(2, 0);
    if (faces.size() != 6 || std::any_of(faces.begin(), faces.end(),
                                         [&](Index face) { return loops[face].size() != 4; }))
        return std::nullopt;

    std::array<Index, 8> vertices;
    std::copy_n(loops[faces[0]].begin(), 4, vertices.begin());
    // From inside, the loop must run anticlockwise.
    if (complex.boundary(3).signs(cell.value)[0] > 0) std::swap(vertices[1], vertices[3]);
    for (std::size_t i = 0; i < 4; ++i) {
        const Index corner = vertices[i], next = vertices[(i + 1) % 4];
        std::optional<Index> above;
        for (std::size_t f = 1; f < 6 && !above; ++f)
            above = otherNeighbour(loops[faces[f]], corner, next);
        if (!above) return std::nullopt;
        vertices[4 + i] = *above;
    }
    // Six quadrilaterals are a hexahedron only if three of them meet in each vertex.
    for (const Index vertex : vertices)
        if (std::count_if(faces.begin(), faces.end(),
                          [&](Index face) { return contains(loops[face], vertex); }) != 3)
            return std::nullopt;
    return vertices;
}

}  // namespace espalier::far
