// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/rats.h>

#include <algorithm>

namespace espalier::stencils {

using far::Level;

namespace {

constexpr int kCornerStratum = 0, kBorderStratum = 1;

/// Returns true if the entity has a part of dimension `dimension` with a stratum of at most
/// `maxStratum`.
bool hasPart(const Level& level, const Entity& entity, int dimension, int maxStratum) {
    const auto parts = level.complex.relation(entity.dimension, dimension)[entity.index];
    return std::any_of(parts.begin(), parts.end(), [&](Index part) {
        return level.strata.of({dimension, part}) <= maxStratum;
    });
}

std::vector<Entity> verticesOf(const Level& level, const Entity& entity) {
    std::vector<Entity> vertices;
    for (const Index vertex : level.complex.relation(entity.dimension, 0)[entity.index])
        vertices.push_back({0, vertex});
    return vertices;
}

/// Returns the inner edges of a face that share a vertex with one of its border edges.
std::vector<Entity> edgesAtTheBorder(const Level& level, const Entity& face) {
    const auto edges = level.complex.relation(2, 1)[face.index];
    std::vector<Index> onBorder;
    std::vector<Entity> inner;
    for (const Index edge : edges) {
        const auto ends = level.complex.relation(1, 0)[edge];
        if (level.strata.of({1, edge}) <= kBorderStratum)
            onBorder.insert(onBorder.end(), ends.begin(), ends.end());
        else
            inner.push_back({1, edge});
    }
    std::erase_if(inner, [&](const Entity& edge) {
        const auto ends = level.complex.relation(1, 0)[edge.index];
        return std::none_of(ends.begin(), ends.end(), [&](Index end) {
            return std::find(onBorder.begin(), onBorder.end(), end) != onBorder.end();
        });
    });
    return inner;
}

RatsPoint edgePoint(const Level& level, const Entity& edge) {
    if (level.strata.of(edge) <= kBorderStratum)
        return hasPart(level, edge, 0, kCornerStratum) ? RatsPoint::EAlpha : RatsPoint::EBeta;
    return hasPart(level, edge, 0, kBorderStratum) ? RatsPoint::EGamma : RatsPoint::EDelta;
}

RatsPoint facePoint(const Level& level, const Entity& face) {
    if (hasPart(level, face, 0, kCornerStratum)) return RatsPoint::FAlpha;
    return hasPart(level, face, 1, kBorderStratum) ? RatsPoint::FBeta : RatsPoint::FGamma;
}

}  // namespace

RatsPoint ratsPoint(const Level& level, Entity entity) {
    if (entity.dimension == 2) return facePoint(level, entity);
    if (entity.dimension == 1) return edgePoint(level, entity);
    switch (level.strata.of(entity)) {
        case kCornerStratum:
            return RatsPoint::VAlpha;
        case kBorderStratum:
            return RatsPoint::VBeta;
        default:
            return RatsPoint::VGamma;
    }
}

std::vector<Entity> ratsSources(const Level& level, Entity entity) {
    switch (ratsPoint(level, entity)) {
        case RatsPoint::EBeta:
        case RatsPoint::EDelta:
        case RatsPoint::FGamma:
            return verticesOf(level, entity);
        case RatsPoint::FBeta: {
            std::vector<Entity> edges = edgesAtTheBorder(level, entity);
            if (!edges.empty()) return edges;
            return {entity};
        }
        default:
            return {entity};
    }
}

}  // namespace espalier::stencils
