// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/surface_fans.h>

#include <algorithm>
#include <utility>

namespace espalier::far {

SurfaceFans::SurfaceFans(const CellComplex& complex, std::vector<std::uint8_t> isSurfaceFace)
    : complex_(complex), isSurfaceFace_(std::move(isSurfaceFace)) {
    edgeKinds_.reserve(static_cast<std::size_t>(complex.count(1)));
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        const std::vector<Index> faces = surfaceFaces(edge);
        if (faces.empty())
            edgeKinds_.push_back(EdgeKind::None);
        else if (isDegenerate(edge))
            edgeKinds_.push_back(EdgeKind::NonManifold);
        else if (faces.size() == 1)
            edgeKinds_.push_back(EdgeKind::Boundary);
        else if (faces.size() == 2 && areCoherent(edge, faces[0], faces[1]))
            edgeKinds_.push_back(EdgeKind::Manifold);
        else
            edgeKinds_.push_back(EdgeKind::NonManifold);
    }
}

std::vector<Index> SurfaceFans::surfaceFaces(Index edge) const {
    std::vector<Index> faces;
    for (const Index face : complex_.relation(1, 2)[edge])
        if (isSurfaceFace_[static_cast<std::size_t>(face)] != 0) faces.push_back(face);
    return faces;
}

Index SurfaceFans::faceCount(Index edge) const {
    return static_cast<Index>(surfaceFaces(edge).size());
}

bool SurfaceFans::areCoherent(Index edge, Index first, Index second) const {
    // The boundary of a lattice is oriented by its cells, however its faces are wound.
    if (complex_.dimension() == 3) return true;
    const SignedIncidence& boundary = complex_.boundary(2);
    const auto signIn = [&](Index face) {
        const auto row = boundary[face];
        const auto at = std::find(row.begin(), row.end(), edge) - row.begin();
        return boundary.signs(face)[static_cast<std::size_t>(at)];
    };
    return signIn(first) != signIn(second);
}

bool SurfaceFans::isDegenerate(Index edge) const {
    if (complex_.dimension() == 3) return false;
    const auto ends = complex_.relation(1, 0)[edge];
    if (ends[0] == ends[1]) return true;
    for (const Index face : complex_.relation(1, 2)[edge])
        for (const Index other : complex_.relation(2, 1)[face]) {
            const auto otherEnds = complex_.relation(1, 0)[other];
            if (other != edge && std::is_permutation(ends.begin(), ends.end(), otherEnds.begin()))
                return true;
        }
    return false;
}

SurfaceFans::VertexKind SurfaceFans::vertex(Index vertex) const {
    std::vector<Index> faces;
    for (const Index face : complex_.relation(0, 2)[vertex])
        if (isSurfaceFace_[static_cast<std::size_t>(face)] != 0) faces.push_back(face);
    if (faces.empty()) return VertexKind::None;

    int fanCount = 0;
    bool hasBoundary = false, hasNonManifold = false, allBetweenTheSame = true;
    std::vector<Index> creaseEnds;  // of the first fan
    std::vector<Index> reached;
    for (const Index start : faces) {
        if (contains(reached, start)) continue;
        ++fanCount;
        // Cross from face to face over manifold edges; the edges that stop it are the fan's ends.
        std::vector<Index> ends;
        std::size_t next = reached.size();
        reached.push_back(start);
        for (; next < reached.size(); ++next)
            for (const Index edge : complex_.relation(2, 1)[reached[next]]) {
                if (!contains(complex_.relation(1, 0)[edge], vertex)) continue;
                if (this->edge(edge) != EdgeKind::Manifold) {
                    ends.push_back(edge);
                    continue;
                }
                for (const Index face : surfaceFaces(edge))
                    if (!contains(reached, face)) reached.push_back(face);
            }
        for (const Index end : ends) {
            hasBoundary |= edge(end) == EdgeKind::Boundary;
            hasNonManifold |= edge(end) == EdgeKind::NonManifold;
        }
        std::sort(ends.begin(), ends.end());
        if (fanCount == 1) creaseEnds = ends;
        allBetweenTheSame &= ends.size() == 2 && ends[0] != ends[1] && ends == creaseEnds;
    }
    if (!hasNonManifold && fanCount == 1) return VertexKind::Fan;
    if (hasNonManifold && !hasBoundary && allBetweenTheSame && fanCount > 2)
        return VertexKind::Crease;
    return VertexKind::NonManifold;
}

}  // namespace espalier::far
