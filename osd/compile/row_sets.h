// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/stencil_table.h>

#include <span>
#include <vector>

#include "inverse_index.h"

namespace espalier::osd {

/// The rows of a table, grouped by their columns: the rows of a set have the same columns. Sets are
/// in the order of their first rows.
///
/// The columns of a set may include all columns of other sets: the set is then their superset. A
/// superset has no superset other than itself. Each of its subsets has at least a third of its
/// columns.
///
/// Near the planes between base cells, rows have fewer columns than rows in the middle of a cell,
/// and each of these columns is also a column of the rows in the middle. So the sets near the
/// planes become subsets of the set in the middle.
class RowSets {
public:
    /// \param table must outlive it
    /// \cost O(entries + columns); at most 256 candidates for a superset are tried
    template <class Real>
    explicit RowSets(const stencils::StencilTable<Real>& table);

    Index count() const { return rows_.count(); }
    /// The columns of a set, in the table.
    std::span<const Index> columnsOf(Index set) const { return columns_[set]; }
    /// The rows of a set, ascending.
    std::span<const Index> rowsOf(Index set) const { return rows_.of(set); }
    /// The sets that have this superset, ascending. A set without a superset is its own.
    std::span<const Index> subsetsOf(Index superset) const { return subsets_.of(superset); }

private:
    std::vector<std::span<const Index>> columns_;
    InverseIndex<Index> rows_;
    InverseIndex<Index> subsets_;
};

}  // namespace espalier::osd
