// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/table_builder.h>

#include <numeric>
#include <string>

namespace espalier::stencils {
namespace {

using far::CellComplex;
using far::Entity;
using far::Strata;

/// Calls visit(entity) for the entities of dimension `dimension` that are or contain `entity`, in
/// the sub-complex of its own stratum.
template <class Visit>
void forEachAround(const far::Level& level, const Entity& entity, int dimension, Visit visit) {
    const int stratum = level.strata.of(entity);
    for (const Index index : level.complex.relation(entity.dimension, dimension)[entity.index])
        if (level.strata.of({dimension, index}) <= stratum) visit(Entity{dimension, index});
}

Index countAround(const far::Level& level, const Entity& entity, int dimension) {
    Index count = 0;
    forEachAround(level, entity, dimension, [&](const Entity&) { ++count; });
    return count;
}

/// Adds the row of the new point of `entity`: of each average in its mask, the centroids; of each
/// centroid, the vertices.
void addRow(const far::Level& level, Rules rules, const Entity& entity, RowAccumulator& row) {
    const int stratum = level.strata.of(entity);
    // n of the rules: faces at an edge of the volume, edges at a vertex of the surface.
    const bool needsValence = entity.dimension == stratum - 2;
    const Index valence = needsValence ? countAround(level, entity, entity.dimension + 1) : 0;
    const Mask mask = refinementMask(rules, entity.dimension, stratum, valence);
    for (int dimension = entity.dimension; dimension <= stratum; ++dimension) {
        const double weight = mask[static_cast<std::size_t>(dimension)];
        if (weight == 0) continue;
        const Index count = countAround(level, entity, dimension);
        forEachAround(level, entity, dimension, [&](const Entity& around) {
            const auto vertices = level.complex.relation(dimension, 0)[around.index];
            const double share = weight / (count * static_cast<double>(vertices.size()));
            for (const Index vertex : vertices) row.add(vertex, share);
        });
    }
}

}  // namespace

StencilTable<double> buildLevelTable(const far::TopologyRefiner& refiner, int level, Rules rules,
                                     std::span<const Index> vertices) {
    const far::Level& parent = refiner.level(level - 1);
    const far::Refinement& refinement = refiner.refinement(level);
    const Index count = refinement.child().count(0);
    for (const Index vertex : vertices)
        if (vertex < 0 || vertex >= count)
            throw Error("there is no vertex " + std::to_string(vertex) + " on level " +
                        std::to_string(level) + ", which has " + std::to_string(count));
    return buildTable<double>(
        static_cast<Index>(vertices.size()), parent.complex.count(0),
        [&](Index row, RowAccumulator& accumulator) {
            const Index vertex = vertices[static_cast<std::size_t>(row)];
            addRow(parent, rules, refinement.parentOf({0, vertex}).upper, accumulator);
        });
}

StencilTable<double> buildLevelTable(const far::TopologyRefiner& refiner, int level, Rules rules) {
    std::vector<Index> all(static_cast<std::size_t>(refiner.level(level).complex.count(0)));
    std::iota(all.begin(), all.end(), Index{0});
    return buildLevelTable(refiner, level, rules, all);
}

}  // namespace espalier::stencils
