// SPDX-License-Identifier: Apache-2.0
#include "smoothness_report.h"

#include <espalier/base/parallel.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/limit/vertex_ring.h>

#include <algorithm>

namespace espalier::cli {
namespace {

/// The number of points in the ring of a vertex: one for each entity that contains it.
Index ringPointsAt(const far::CellComplex& complex, Index vertex) {
    std::size_t count = 0;
    for (int d = 0; d <= complex.dimension(); ++d) count += complex.relation(0, d)[vertex].size();
    return static_cast<Index>(count);
}

/// The number of vertices of the cells at a vertex, all of which its ring is refined with.
std::size_t cornersAt(const far::CellComplex& complex, Index vertex) {
    std::size_t count = 0;
    for (const Index cell : complex.relation(0, 3)[vertex])
        count += complex.relation(3, 0)[cell].size();
    return count;
}

Smoothness smoothnessOf(const Entity& entity, const far::Level& level, Index vertex,
                        const far::RefinerOptions& options, stencils::Rules rules) {
    constexpr std::size_t kMostEigenvalues = 6;
    Smoothness result{entity, level.strata.of({0, vertex}), ringPointsAt(level.complex, vertex)};
    if (result.ringPoints > kMaxRingPoints ||
        cornersAt(level.complex, vertex) > static_cast<std::size_t>(kMaxRingPoints))
        return result;
    const auto ring = limit::ringOf(level, options, rules, vertex);
    auto values = limit::eigenvalues(ring);
    values.erase(values.begin());
    values.resize(std::min(values.size(), kMostEigenvalues));
    result.isKnown = true;
    result.eigenvalues = std::move(values);
    const Eigen::VectorXd mask = limit::limitMask(ring);
    for (std::size_t i = 0; i < ring.entities.size(); ++i)
        result.mask[ring.entities[i].dimension] += mask[static_cast<Eigen::Index>(i)];
    return result;
}

}  // namespace

std::vector<Smoothness> reportSmoothness(const far::TopologyRefiner& lattice,
                                         stencils::Rules rules) {
    far::TopologyRefiner refiner(lattice.level(0), lattice.options());
    refiner.refineUniform(1);
    const far::Level& level = refiner.level(1);
    std::vector<std::pair<Entity, Index>> irregular;
    for (int d = 0; d <= 1; ++d)
        for (Index index = 0; index < refiner.level(0).complex.count(d); ++index) {
            const Entity entity{d, index};
            const auto point = refiner.refinement(1).childOf({entity, entity});
            if (point && !level.strata.isOpen(*point) &&
                !embed::isRegularVertex(level, point->index))
                irregular.emplace_back(entity, point->index);
        }
    std::vector<Smoothness> result(irregular.size());
    parallelFor(std::ssize(irregular), 1, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            const auto& [entity, vertex] = irregular[i];
            result[i] = smoothnessOf(entity, level, vertex, refiner.options(), rules);
        }
    });
    return result;
}

}  // namespace espalier::cli
