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

/// Rows of S_level of which many are the same weights over other columns: those inside base
/// entities with surroundings of the same shape (surroundings.h). Of each such set of rows one is
/// made, by whoever uses this, and copied to the others: S_4 of a torus of 1,600 quadrilaterals
/// takes 40 ns a row instead of 490.
class RepeatedRows {
public:
    /// Whether shapes decide the rows of S_level.
    static bool areIn(const far::TopologyRefiner& refiner, int level);

    /// \param origins of the levels 0 to `level` − 1
    /// \param vertices of the level: whose rows are asked for
    /// \cost O(vertices of the level + entries around the base entities that these lie in)
    RepeatedRows(const far::TopologyRefiner& refiner, int level,
                 std::span<const BaseEntities> origins, std::span<const Index> vertices);

    /// One vertex of each set of rows, in the order in which they are met.
    const std::vector<Index>& firsts() const { return firsts_; }

    /// All the rows.
    /// \param firstRows the rows of S_level for firsts()
    /// \cost O(entries), in parallel
    StencilTable<double> expand(const StencilTable<double>& firstRows) const;

private:
    /// A row: what the `first`-th of firsts() is, over the vertices around a base entity.
    struct Copy {
        Index first;
        Index base;
    };
    /// What is known of a base entity that a row lies in.
    struct Inside {
        Index firstSet;   ///< the rows inside belong to sets of this number on
        Offset vertices;  ///< those around the entity are around_[vertices] on
    };
    const Index* verticesAround(Index base) const {
        return around_.data() + insides_[base]->vertices;
    }
    Array<Index> placesOf(const StencilTable<double>& firstRows) const;

    std::vector<Index> firsts_;
    std::vector<Index> firstBases_;               ///< the base entity of each of firsts_
    Array<Copy> copies_;                          ///< one a row
    std::vector<std::optional<Inside>> insides_;  ///< one a base entity
    std::vector<Index> around_;
};

}  // namespace espalier::stencils
