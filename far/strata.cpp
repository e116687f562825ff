// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/far/strata.h>

#include <algorithm>
#include <vector>

namespace espalier::far {

Strata::Strata(const CellComplex& complex, Numbers smoothStrata, Numbers isOpen,
               SharpnessValues sharpness)
    : smoothStrata_(std::move(smoothStrata)),
      strata_(smoothStrata_),
      isOpen_(std::move(isOpen)),
      sharpness_(std::move(sharpness)) {
    // Counts the sharp edges at each vertex; for a vertex on the surface, only those on the
    // surface.
    std::vector<Index> sharpEdges(sharpness_.vertices.size(), 0);
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        checkCancelledEvery(edge, 14);
        if (sharpness_.edges[edge] == kSmooth) continue;
        strata_[1][edge] = 1;
        for (const Index vertex : complex.relation(1, 0)[edge])
            if (inSubcomplex({0, vertex}, 1, {1, edge})) ++sharpEdges[vertex];
    }
    for (std::size_t vertex = 0; vertex < sharpEdges.size(); ++vertex) {
        if (sharpness_.vertices[vertex] > kSmooth || sharpEdges[vertex] > 2)
            strata_[0][vertex] = 0;
        else if (sharpEdges[vertex] == 2)
            strata_[0][vertex] = 1;
    }
    findSemiSharp();
}

void Strata::findSemiSharp() {
    const auto anySemiSharp = [](const std::vector<float>& values) {
        return std::any_of(values.begin(), values.end(), isSemiSharp);
    };
    hasSemiSharp_ = anySemiSharp(sharpness_.vertices) || anySemiSharp(sharpness_.edges);
}

Strata Strata::select(const ByEntity<Index>& entities) const {
    const auto chosen = [](const auto& values, const std::vector<Index>& numbers) {
        std::remove_cvref_t<decltype(values)> result;
        if (values.empty()) return result;
        result.reserve(numbers.size());
        for (const Index number : numbers) result.push_back(values[number]);
        return result;
    };
    Strata part;
    for (std::size_t d = 0; d < entities.size(); ++d) {
        part.smoothStrata_[d] = chosen(smoothStrata_[d], entities[d]);
        part.strata_[d] = chosen(strata_[d], entities[d]);
        part.isOpen_[d] = chosen(isOpen_[d], entities[d]);
    }
    part.sharpness_ = {chosen(sharpness_.vertices, entities[0]),
                       chosen(sharpness_.edges, entities[1])};
    part.findSemiSharp();
    return part;
}

Index Strata::count(int dimension, int stratum) const {
    const auto& strata = strata_[dimension];
    return static_cast<Index>(
        std::count(strata.begin(), strata.end(), static_cast<std::uint8_t>(stratum)));
}

Marks marksFor(const CellComplex& complex, const Strata& strata, Boundary boundary) {
    const Strata automatic = classify(complex, boundary, SharpEdges::SingleCell, {});
    Marks marks;
    const auto toMark = [&](Entity entity) {
        if (strata.isOpen(entity)) return false;  // Refinement omits it, whatever its sharpness.
        return strata.sharpness(entity) != automatic.sharpness(entity) ||
               (entity.dimension == complex.dimension() - 1 && automatic.isOpen(entity));
    };
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        checkCancelledEvery(edge, 14);
        if (!toMark({1, edge})) continue;
        const auto ends = complex.relation(1, 0)[edge];
        marks.edges.push_back({{ends[0], ends[1]}, strata.sharpness({1, edge})});
    }
    for (Index vertex = 0; vertex < complex.count(0); ++vertex)
        if (toMark({0, vertex})) marks.vertices.push_back({vertex, strata.sharpness({0, vertex})});
    return marks;
}

namespace {

/// Returns the edges at a vertex whose sharpness affects `entity`, which is the vertex or an edge
/// at the vertex.
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
