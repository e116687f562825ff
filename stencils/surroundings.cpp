// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/hash.h>
#include <espalier/stencils/surroundings.h>

#include <cstdint>
#include <optional>

namespace espalier::stencils {

std::size_t Surroundings::Hash::operator()(const std::vector<Index>& numbers) const {
    std::uint64_t hash = numbers.size();
    for (const Index number : numbers)
        hash = (hash ^ static_cast<std::uint32_t>(number)) * kHashFactor;
    return hash ^ (hash >> 32);
}

Surroundings::Surroundings(const far::Level& level)
    : level_(level),
      around_{IndexSet(level.complex.count(0)), IndexSet(level.complex.count(1)),
              IndexSet(level.complex.count(2)), IndexSet(level.complex.count(3))},
      vertices_(level.complex.count(0)) {
    const far::CellComplex& complex = level.complex;
    for (int d = 0; d <= complex.dimension(); ++d)
        relations_.push_back({&complex.relation(0, d), &complex.relation(d, 0),
                              d >= 2 ? &complex.boundary(d) : nullptr});
}

bool Surroundings::shapesDetermineRows(const far::Level& level,
                                       const far::RefinerOptions& options) {
    const bool seesShapesOnly = options.rules == far::Rules::Mlca
                                    ? level.complex.dimension() < kMaxDimension
                                    : options.rules != far::Rules::Rats;
    return seesShapesOnly && options.boundary != far::Boundary::Open &&
           !level.strata.hasSemiSharp();
}

Index Surroundings::shapeOf(const Entity& entity) {
    // Shapes that repeat occur early, so later shapes are not stored: each would take several
    // kilobytes.
    constexpr std::size_t kMaxRemembered = 4096;
    collect(entity);
    describe(entity);
    if (const auto known = shapes_.find(description_); known != shapes_.end()) return known->second;
    if (shapes_.size() < kMaxRemembered) shapes_.emplace(description_, shapeCount_);
    return shapeCount_++;
}

void Surroundings::collect(const Entity& entity) {
    const auto addNew = [](IndexSet& items, std::span<const Index> more) {
        for (const Index item : more)
            if (!items.has(item)) items.add(item);
    };
    vertices_.shrink(0);
    for (IndexSet& items : around_) items.shrink(0);
    addNew(around_[0], (*relations_[entity.dimension].toVertices)[entity.index]);
    addNew(vertices_, around_[0].items());
    around_[0].sort();
    for (std::size_t d = 1; d < relations_.size(); ++d) {
        IndexSet& items = around_[d];
        for (const Index vertex : around_[0].items())
            addNew(items, (*relations_[d].ofVertex)[vertex]);
        items.sort();
        for (const Index item : items.items()) addNew(vertices_, (*relations_[d].toVertices)[item]);
    }
    vertices_.sort();
}

void Surroundings::describe(const Entity& entity) {
    description_ = {entity.dimension, around_[entity.dimension].slotOf(entity.index)};
    for (int d = 0; d <= level_.complex.dimension(); ++d) {
        const auto& items = around_[d].items();
        description_.push_back(static_cast<Index>(items.size()));
        for (const Index item : items) describe(d, item);
    }
}

/// Appends an entity's strata, its vertices, and its boundary with signs.
void Surroundings::describe(int dimension, Index index) {
    const Entity entity{dimension, index};
    const far::Strata& strata = level_.strata;
    const Relations& relations = relations_[dimension];
    const auto vertices = (*relations.toVertices)[index];
    const bool isSharp = dimension <= 1 && strata.sharpness(entity) > far::kSmooth;
    description_.push_back(strata.of(entity) + 4 * strata.smoothStratum(entity) + 16 * isSharp);
    description_.push_back(static_cast<Index>(vertices.size()));
    for (const Index vertex : vertices) description_.push_back(vertices_.slotOf(vertex));
    if (dimension <= 1) return;  // An edge's vertices are in the order of its direction.
    const auto parts = (*relations.boundary)[index];
    const auto signs = relations.boundary->signs(index);
    description_.push_back(static_cast<Index>(parts.size()));
    const IndexSet& near = around_[dimension - 1];
    for (std::size_t i = 0; i < parts.size(); ++i)
        // Parts that do not touch the entity have no number here.
        description_.push_back(near.has(parts[i]) ? signs[i] * (near.slotOf(parts[i]) + 1) : 0);
}

ShapeGroups groupByShape(const far::TopologyRefiner& refiner, const far::Level& level,
                         std::span<const Index> vertices) {
    std::optional<Surroundings> surroundings;
    if (vertices.size() > 1 && Surroundings::shapesDetermineRows(level, refiner.options()))
        surroundings.emplace(level);
    ShapeGroups groups;
    std::map<Index, std::size_t> groupOfShape;
    for (const Index vertex : vertices) {
        const auto [entry, isNew] = groups.groupOf.emplace(vertex, groups.representatives.size());
        if (!isNew) continue;
        if (surroundings)
            entry->second = groupOfShape.emplace(surroundings->shapeOf({0, vertex}), entry->second)
                                .first->second;
        if (entry->second == groups.representatives.size())
            groups.representatives.push_back(vertex);
    }
    return groups;
}

}  // namespace espalier::stencils
