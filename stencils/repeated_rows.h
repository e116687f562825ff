// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/row_order.h>
#include <espalier/stencils/stencil_table.h>

#include <optional>
#include <span>
#include <vector>

namespace espalier::stencils {

/// Finds rows of S_level that have the same weights over different columns: rows inside base
/// entities whose surroundings have the same shape (surroundings.h). The caller computes one row of
/// each such set, and expand() copies it to the others. For S_4 of a torus of 1,600 quadrilaterals,
/// this takes 40 ns per row instead of 490.
class RepeatedRows {
public:
    /// Returns true if the rows of S_level depend on shapes only.
    static bool isApplicable(const far::TopologyRefiner& refiner, int level);

    /// \param origins of levels 0 to `level` − 1
    /// \param vertices of the level, whose rows are requested
    /// \cost O(vertices of the level + entries around the base entities that contain `vertices`)
    RepeatedRows(const far::TopologyRefiner& refiner, int level,
                 std::span<const BaseEntities> origins, std::span<const Index> vertices);

    /// One vertex for each set of equal rows, in the order of first occurrence.
    const std::vector<Index>& representatives() const { return representatives_; }

    /// Returns all rows.
    /// \param distinctRows the rows of S_level for representatives()
    /// \cost O(entries), in parallel
    template <class Real>
    StencilTable<Real> expand(const StencilTable<Real>& distinctRows) const;

private:
    /// A row that is a copy of row `first` of representatives(), over the vertices around a base
    /// entity.
    struct Copy {
        Index first;
        Index base;
    };
    /// A base entity that contains a row.
    struct Inside {
        Index firstSet;   ///< number of the first set of rows that belongs to this entity
        Offset vertices;  ///< the vertices around the entity begin at around_[vertices]
    };
    const Index* verticesAround(Index base) const {
        return around_.data() + insides_[base]->vertices;
    }
    template <class Real>
    Array<Index> slotsOf(const StencilTable<Real>& distinctRows) const;

    std::vector<Index> representatives_;
    std::vector<Index> baseEntities_;             ///< the base entity of each of representatives_
    Array<Copy> copies_;                          ///< one per row
    std::vector<std::optional<Inside>> insides_;  ///< one per base entity
    std::vector<Index> around_;
};

}  // namespace espalier::stencils
