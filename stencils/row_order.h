// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/far/topology_refiner.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::stencils {

/// An order of the rows of a table in which those come one after the other that share columns, or
/// will after a product. Without groups, the order of the table.
class ESPALIER_API RowOrder {
public:
    RowOrder() = default;

    /// \param groups one a row: rows of the same number belong together. Numbers 0 to
    ///        `groupCount` − 1
    RowOrder(std::span<const Index> groups, Index groupCount);

    /// The rows in this order; empty where it is that of the table.
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

/// Of each entity of a level, the entity of the base in whose interior it lies: numbered through
/// the dimensions, vertices first. Entities of the same one are refined from the same base
/// vertices, those around it.
class ESPALIER_API BaseEntities {
public:
    explicit BaseEntities(const far::CellComplex& base);

    /// Goes on to the next level.
    void refine(const far::Refinement& refinement);

    /// Number of entities of the base, of all dimensions.
    Index count() const { return begins_.back(); }

    /// The entity of the base that a number stands for.
    Entity entity(Index number) const;

    std::span<const Index> of(int dimension) const { return numbers_[dimension]; }
    Index of(const Entity& entity) const { return of(entity.dimension)[entity.index]; }

private:
    /// The numbers of the dimensions, one after the other.
    std::array<Index, kMaxDimension + 2> begins_ = {};
    ByEntity<Index> numbers_;
};

/// Those of levels 0 to `level`.
ESPALIER_API std::vector<BaseEntities> baseEntities(const far::TopologyRefiner& refiner, int level);

}  // namespace espalier::stencils
