// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/sort_unique.h>
#include <espalier/far/star.h>

#include <algorithm>
#include <string>

namespace espalier::far {
namespace {

/// Returns the entities that contain one of some vertices, and all entities that these contain;
/// ascending.
ByEntity<Index> entitiesAround(const CellComplex& complex, std::span<const Index> vertices) {
    ByEntity<Index> entities;
    for (int d = complex.dimension(); d >= 0; --d) {
        auto& of = entities[d];
        const auto add = [&](std::span<const Index> row) {
            of.insert(of.end(), row.begin(), row.end());
        };
        // Every face and edge of a lattice is in a cell.
        if (d == complex.dimension() || complex.dimension() < kMaxDimension)
            for (const Index vertex : vertices) add(complex.relation(0, d)[vertex]);
        if (d < complex.dimension())
            for (const Index upper : entities[d + 1]) add(complex.boundary(d + 1)[upper]);
        sortUnique(of);
    }
    return entities;
}

CellComplex complexOf(const CellComplex& complex, const ByEntity<Index>& entities) {
    CellComplex::Boundaries boundaries;
    for (int d = 1; d <= complex.dimension(); ++d) {
        const SignedIncidence& boundary = complex.boundary(d);
        const auto& parts = entities[d - 1];
        Rows<Signed> rows;
        for (const Index entity : entities[d]) {
            for (std::size_t i = 0; i < boundary[entity].size(); ++i)
                rows.values.push_back(
                    {indexIn(parts, boundary[entity][i]), boundary.signs(entity)[i]});
            rows.offsets.push_back(static_cast<Offset>(rows.values.size()));
        }
        boundaries[d - 1] = SignedIncidence(rows);
    }
    return {complex.dimension(), static_cast<Index>(entities[0].size()), std::move(boundaries)};
}

}  // namespace

Star starOf(const Level& level, std::span<const Index> vertices, int rings) {
    for (const Index vertex : vertices)
        if (vertex < 0 || vertex >= level.complex.count(0))
            throw Error(concat("there is no vertex ", vertex, " to take the star of"));
    Star star;
    star.entities = entitiesAround(level.complex, vertices);
    if (rings > 1) star.entities = entitiesAround(level.complex, star.entities[0]);
    star.level.complex = complexOf(level.complex, star.entities);
    star.level.strata = level.strata.select(star.entities);
    return star;
}

int ringsAround(const Level& level, Creasing creasing) {
    return creasing == Creasing::Chaikin && level.strata.hasSemiSharp() ? 2 : 1;
}

}  // namespace espalier::far
