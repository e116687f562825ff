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
    for (const Index vertex : vertices)
        for (int upper = 0; upper <= complex.dimension(); ++upper)
            for (const Index entity : complex.relation(0, upper)[vertex])
                for (int d = 0; d <= upper; ++d) {
                    const auto parts = complex.relation(upper, d)[entity];
                    auto& of = entities[d];
                    of.insert(of.end(), parts.begin(), parts.end());
                }
    for (auto& of : entities) sortUnique(of);
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
                    {placeIn(parts, boundary[entity][i]), boundary.signs(entity)[i]});
            rows.offsets.push_back(static_cast<Offset>(rows.values.size()));
        }
        boundaries[d - 1] = SignedIncidence(rows);
    }
    return {complex.dimension(), static_cast<Index>(entities[0].size()), std::move(boundaries)};
}

Strata strataOf(const CellComplex& complex, const Strata& strata, const ByEntity<Index>& entities) {
    Strata::Numbers smooth, isOpen;
    SharpnessValues sharpness;
    for (int d = 0; d <= complex.dimension(); ++d)
        for (const Index index : entities[d]) {
            const Entity entity{d, index};
            smooth[d].push_back(static_cast<std::uint8_t>(strata.smoothStratum(entity)));
            isOpen[d].push_back(strata.isOpen(entity));
            if (d == 0) sharpness.vertices.push_back(strata.sharpness(entity));
            if (d == 1) sharpness.edges.push_back(strata.sharpness(entity));
        }
    return {complex, std::move(smooth), std::move(isOpen), std::move(sharpness)};
}

}  // namespace

Star starOf(const Level& level, Index vertex, int rings) {
    if (vertex < 0 || vertex >= level.complex.count(0))
        throw Error(concat("there is no vertex ", vertex, " to take the star of"));
    Star star;
    star.entities = entitiesAround(level.complex, {&vertex, 1});
    if (rings > 1) star.entities = entitiesAround(level.complex, star.entities[0]);
    star.vertex = placeIn(star.entities[0], vertex);
    star.level.complex = complexOf(level.complex, star.entities);
    star.level.strata = strataOf(star.level.complex, level.strata, star.entities);
    return star;
}

}  // namespace espalier::far
