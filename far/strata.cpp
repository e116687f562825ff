// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/strata.h>

#include <algorithm>

namespace espalier::far {
Strata::Strata(const CellComplex& complex, Numbers smoothStrata, Numbers isOpen,
               SharpnessValues sharpness)
    : smoothStrata_(std::move(smoothStrata)),
      strata_(smoothStrata_),
      isOpen_(std::move(isOpen)),
      sharpness_(std::move(sharpness)) {
    // Sharp edges at each vertex, of the surface if the vertex lies on it.
    std::vector<Index> sharpEdges(sharpness_.vertices.size(), 0);
    for (Index edge = 0; edge < complex.count(1); ++edge) {
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
    const auto anySemiSharp = [](const std::vector<float>& values) {
        return std::any_of(values.begin(), values.end(), isSemiSharp);
    };
    hasSemiSharp_ = anySemiSharp(sharpness_.vertices) || anySemiSharp(sharpness_.edges);
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
        if (strata.isOpen(entity)) return false;  // It is left out, whatever its sharpness.
        return strata.sharpness(entity) != automatic.sharpness(entity) ||
               (entity.dimension == complex.dimension() - 1 && automatic.isOpen(entity));
    };
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        if (!toMark({1, edge})) continue;
        const auto ends = complex.relation(1, 0)[edge];
        marks.edges.push_back({{ends[0], ends[1]}, strata.sharpness({1, edge})});
    }
    for (Index vertex = 0; vertex < complex.count(0); ++vertex)
        if (toMark({0, vertex})) marks.vertices.push_back({vertex, strata.sharpness({0, vertex})});
    return marks;
}

}  // namespace espalier::far
