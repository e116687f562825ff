// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/surface_fans.h>

#include <espalier/base/disjoint_sets.h>
#include <espalier/base/progress.h>

#include <algorithm>
#include <utility>

namespace espalier::far {
SurfaceFans::SurfaceFans(const CellComplex& complex, std::vector<std::uint8_t> isSurfaceFace)
    : complex_(complex), isSurfaceFace_(std::move(isSurfaceFace)) {
    // For each edge, the number of faces that run along it from tail to head, minus the number of
    // faces that run from head to tail. The number stays 0 in a lattice: its cells orient the
    // boundary, however its faces are directed.
    std::vector<int> turns(complex.count(1), 0);
    if (complex.dimension() == 2)
        for (Index face = 0; face < complex.count(2); ++face)
            for (std::size_t i = 0; i < complex.boundary(2)[face].size(); ++i)
                turns[complex.boundary(2)[face][i]] += complex.boundary(2).signs(face)[i];

    edgeKinds_.reserve(complex.count(1));
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        checkCancelledEvery(edge, 12);
        const std::vector<Index> faces = surfaceFaces(edge);
        const bool isManifold = faces.size() == 2 && turns[edge] == 0;
        edgeKinds_.push_back(faces.empty()       ? EdgeKind::None
                             : faces.size() == 1 ? EdgeKind::Boundary
                             : isManifold        ? EdgeKind::Manifold
                                                 : EdgeKind::NonManifold);
    }
    // A face of a lattice has no vertex twice.
    if (complex.dimension() == 2) markDegenerate();

    // Groups the corners of the surface by vertex.
    const auto forEachCorner = [&](auto visit) {
        for (Index face = 0; face < complex.count(2); ++face) {
            checkCancelledEvery(face, 14);
            if (isSurfaceFace_[face] == 0) continue;
            const auto vertices = complex.relation(2, 0)[face];
            const auto edges = complex.relation(2, 1)[face];
            for (std::size_t i = 0; i < vertices.size(); ++i)
                visit(vertices[i], Corner{edges[(i + edges.size() - 1) % edges.size()], edges[i]});
        }
    };
    cornerOffsets_.assign(complex.count(0) + 1, 0);
    forEachCorner([&](Index vertex, const Corner&) { ++cornerOffsets_[vertex + 1]; });
    std::partial_sum(cornerOffsets_.begin(), cornerOffsets_.end(), cornerOffsets_.begin());
    corners_.resize(cornerOffsets_.back());
    std::vector<Offset> next = cornerOffsets_;
    forEachCorner([&](Index vertex, const Corner& corner) { corners_[next[vertex]++] = corner; });
}

std::vector<Index> SurfaceFans::surfaceFaces(Index edge) const {
    std::vector<Index> faces;
    for (const Index face : complex_.relation(1, 2)[edge])
        if (isSurfaceFace_[face] != 0) faces.push_back(face);
    return faces;
}

Index SurfaceFans::faceCount(Index edge) const {
    return static_cast<Index>(surfaceFaces(edge).size());
}

/// Marks edges as non-manifold if a face has several of them between the same two vertices, or if
/// they join a vertex to itself.
void SurfaceFans::markDegenerate() {
    std::vector<std::array<Index, 3>> sides;  // the two ends, and the edge
    for (Index face = 0; face < complex_.count(2); ++face) {
        sides.clear();
        for (const Index edge : complex_.relation(2, 1)[face]) {
            const auto ends = complex_.relation(1, 0)[edge];
            sides.push_back({std::min(ends[0], ends[1]), std::max(ends[0], ends[1]), edge});
        }
        std::sort(sides.begin(), sides.end());
        for (std::size_t i = 0; i < sides.size(); ++i) {
            const auto isSame = [&](std::size_t other) {
                return sides[i][0] == sides[other][0] && sides[i][1] == sides[other][1];
            };
            if (sides[i][0] == sides[i][1] || (i > 0 && isSame(i - 1)) ||
                (i + 1 < sides.size() && isSame(i + 1)))
                edgeKinds_[sides[i][2]] = EdgeKind::NonManifold;
        }
    }
}

SurfaceFans::VertexKind SurfaceFans::vertex(Index vertex) const {
    const std::size_t first = cornerOffsets_[vertex];
    const std::size_t count = cornerOffsets_[vertex + 1] - first;
    if (count == 0) return VertexKind::None;

    // The edges at the vertex, each with the corners that it bounds; a manifold edge has two.
    std::vector<std::pair<Index, std::size_t>> sides;
    for (std::size_t i = 0; i < count; ++i) {
        sides.emplace_back(corners_[first + i].entering, i);
        sides.emplace_back(corners_[first + i].leaving, i);
    }
    std::sort(sides.begin(), sides.end());

    DisjointSets fans(count);  // of corners
    for (std::size_t i = 0; i + 1 < sides.size(); ++i)
        if (sides[i].first == sides[i + 1].first && edge(sides[i].first) == EdgeKind::Manifold)
            fans.join(sides[i].second, sides[i + 1].second);

    // The edges at the ends of each fan, ascending, because the sides are ascending: an end is an
    // edge that joins the fan to no other corner.
    std::vector<std::vector<Index>> ends(count);
    bool hasBoundary = false, hasNonManifold = false;
    for (const auto& [side, corner] : sides) {
        if (edge(side) == EdgeKind::Manifold) continue;
        ends[fans.rootOf(corner)].push_back(side);
        hasBoundary |= edge(side) == EdgeKind::Boundary;
        hasNonManifold |= edge(side) == EdgeKind::NonManifold;
    }
    bool haveSameEnds = true;
    for (std::size_t corner = 0; corner < count; ++corner) {
        if (fans.rootOf(corner) != corner) continue;
        const std::vector<Index>& own = ends[corner];
        haveSameEnds &= own.size() == 2 && own[0] != own[1] && own == ends[fans.rootOf(0)];
    }
    if (fans.setCount() == 1 && !hasNonManifold) return VertexKind::Fan;
    if (fans.setCount() > 2 && haveSameEnds && !hasBoundary) return VertexKind::Crease;
    return VertexKind::NonManifold;
}

}  // namespace espalier::far
