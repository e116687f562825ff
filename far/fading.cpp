// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/fading.h>

#include <algorithm>
#include <vector>

namespace espalier::far {
namespace {

/// The edges at a vertex whose sharpness counts there for `entity`, the vertex or an edge at it.
std::vector<Index> sharpEdgesAt(const CellComplex& complex, const Strata& strata, Index vertex,
                                const Entity& entity) {
    std::vector<Index> edges;
    for (const Index edge : complex.relation(0, 1)[vertex])
        if (strata.sharpness({1, edge}) > kSmooth && strata.inSubcomplex(entity, 1, {1, edge}))
            edges.push_back(edge);
    return edges;
}

std::vector<float> sharpnessOf(const Strata& strata, std::span<const Index> edges) {
    std::vector<float> values;
    values.reserve(edges.size());
    for (const Index edge : edges) values.push_back(strata.sharpness({1, edge}));
    return values;
}

}  // namespace

float childSharpness(const CellComplex& complex, const Strata& strata, Creasing creasing,
                     const Entity& edge, Index vertex) {
    const float sharpness = strata.sharpness(edge);
    if (creasing == Creasing::Uniform) return subdivideSharpness(sharpness);
    return subdivideEdgeSharpness(creasing, sharpness,
                                  sharpnessOf(strata, sharpEdgesAt(complex, strata, vertex, edge)));
}

namespace {

std::optional<Fading> fadingOfEdge(const CellComplex& complex, const Strata& strata,
                                   Creasing creasing, const Entity& edge) {
    const float sharpness = strata.sharpness(edge);
    if (!isSemiSharp(sharpness)) return std::nullopt;
    for (const Index end : complex.relation(1, 0)[edge.index])
        if (childSharpness(complex, strata, creasing, edge, end) == kSmooth)
            return Fading{strata.smoothStratum(edge), sharpness, {}};
    return std::nullopt;
}

std::optional<Fading> fadingOfVertex(const CellComplex& complex, const Strata& strata,
                                     Creasing creasing, const Entity& vertex) {
    const int stratum = strata.of(vertex);
    if (stratum == strata.smoothStratum(vertex)) return std::nullopt;
    const float own = strata.sharpness(vertex), ownChild = subdivideSharpness(own);
    const std::vector<Index> edges = sharpEdgesAt(complex, strata, vertex.index, vertex);
    const std::vector<float> around = sharpnessOf(strata, edges);

    Fading fading;
    float sum = 0;
    int fadeCount = 0, sharpCount = 0;
    std::array<Index, 2> staySharp = {};
    const auto fade = [&](float sharpness) {
        sum += sharpness;
        ++fadeCount;
    };
    if (own > kSmooth && ownChild == kSmooth) fade(own);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        if (subdivideEdgeSharpness(creasing, around[i], around) == kSmooth)
            fade(around[i]);
        else if (sharpCount++ < 2)
            staySharp[sharpCount - 1] = edges[i];
    }
    fading.next = ownChild > kSmooth || sharpCount > 2 ? 0
                  : sharpCount == 2                    ? 1
                                                       : strata.smoothStratum(vertex);
    if (fading.next == stratum) return std::nullopt;
    if (fading.next == 1 && sharpCount == 2) fading.staySharp = staySharp;
    fading.weight = std::min(sum / static_cast<float>(fadeCount), 1.0F);
    return fading;
}

}  // namespace

std::optional<Fading> fadingOf(const CellComplex& complex, const Strata& strata, Creasing creasing,
                               const Entity& entity) {
    if (!strata.hasSemiSharp() || entity.dimension > 1) return std::nullopt;
    return entity.dimension == 1 ? fadingOfEdge(complex, strata, creasing, entity)
                                 : fadingOfVertex(complex, strata, creasing, entity);
}

}  // namespace espalier::far
