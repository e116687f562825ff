// SPDX-License-Identifier: Apache-2.0
#include "edge_search.h"

namespace espalier::limit {

using Eigen::Vector3d;

void EdgeSearch::add(std::size_t i, Index cell) {
    const far::CellComplex& complex = level_.complex;
    starts_.resize(i + 1, edges_.size());
    for (const Index edge : complex.relation(3, 1)[cell]) {
        const auto around = complex.relation(1, 3)[edge];
        if (around.front() != cell || around.size() == 4 || level_.strata.of({1, edge}) != 3)
            continue;
        const auto ends = complex.relation(1, 0)[edge];
        edges_.emplace_back(edge, Vector3d(positions_[ends[0]].data()),
                            Vector3d(positions_[ends[1]].data()));
    }
    starts_.push_back(edges_.size());
}

std::shared_ptr<const EdgeRows> EdgeSearch::findOn(Index edge, const Vector3d& point) {
    const auto [place, isNew] = layered_.try_emplace(edge);
    if (isNew) place->second = layered(edge);
    if (!place->second) return nullptr;
    const auto& [refinement, layers, points] = *place->second;
    const auto at = refinement->find(points, point, distance_);
    if (!at) return nullptr;
    return std::make_shared<const EdgeRows>(refinement->rowsAt(layers, *at));
}

std::optional<EdgeSearch::LayeredEdge> EdgeSearch::layered(Index edge) const {
    auto layers = layersAround(level_, edge);
    if (!layers) return std::nullopt;
    const auto cellCount = level_.complex.relation(1, 3)[edge].size();
    const EdgeRefinement* refinement = refinements_.of(static_cast<Index>(cellCount));
    if (!refinement) return std::nullopt;
    const auto points = refinement->controlPoints(*layers, positions_);
    return LayeredEdge{refinement, std::move(*layers), points};
}

}  // namespace espalier::limit
