// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/far/topology_refiner.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::stencils {

/// An order of the rows of a table in which rows of the same group are consecutive: rows that share
/// columns, or that will share columns after a product. Without groups, the rows keep the order of
/// the table.
class ESPALIER_API RowOrder {
public:
    RowOrder() = default;

    /// \param groups one per row: the number of the row's group, 0 to `groupCount` − 1
    RowOrder(std::span<const Index> groups, Index groupCount);

    /// The rows in this order; empty if the rows keep the order of the table.
    std::span<const Index> rows() const { return rows_; }

    Index row(Offset position) const {
        return rows_.empty() ? static_cast<Index>(position) : rows_[position];
    }

    bool isSameGroup(Offset a, Offset b) const {
        return rows_.empty() || groups_[row(a)] == groups_[row(b)];
    }

private:
    std::vector<Index> rows_;
    std::vector<Index> groups_;
};

/// Tells for each entity of a level which base entity contains it in its interior. Base entities
/// are numbered consecutively over all dimensions, vertices first. Entities in the same base entity
/// depend on the same base vertices: the vertices around the base entity.
class ESPALIER_API BaseEntities {
public:
    explicit BaseEntities(const far::CellComplex& base);

    /// Replaces the level by the next one.
    void refine(const far::Refinement& refinement);

    /// Number of entities of the base, of all dimensions.
    Index count() const { return begins_.back(); }

    /// Returns the base entity of a number.
    Entity entity(Index number) const;

    std::span<const Index> of(int dimension) const { return numbers_[dimension]; }
    Index of(const Entity& entity) const { return of(entity.dimension)[entity.index]; }

private:
    /// The first number of each dimension, and the total.
    std::array<Index, kMaxDimension + 2> begins_ = {};
    ByEntity<Index> numbers_;
};

/// Returns the base entities of levels 0 to `level`.
ESPALIER_API std::vector<BaseEntities> baseEntities(const far::TopologyRefiner& refiner, int level);

}  // namespace espalier::stencils
