// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/osd/kernels/kernels.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "row_sets.h"

namespace espalier::osd {

/// The rows of a superset and of its subsets. A row has a slot: rows are numbered subset by
/// subset. A column has a position among the columns of the superset.
struct Superset {
    std::span<const Index> columns;
    std::vector<Index> rows;  ///< the row of each slot
    /// Subset s has slots subsets[s] to subsets[s + 1] − 1. One of the subsets is the superset.
    std::vector<Index> subsets;

    /// Takes over the rows of a superset, in the memory of the one before.
    void assign(const RowSets& sets, Index superset);
    std::size_t subsetCount() const { return subsets.size() - 1; }
};

/// How the rows of a superset are stored: which rows form which groups. A form has slots and
/// positions instead of rows and columns, so that all supersets with the same weights have the same
/// form. The faces of a regular surface are such supersets.
template <class Real>
struct SupersetForm {
    /// Rows that share their columns: panels of weights, or outer products.
    struct Group {
        Index firstPosition, columnCount;  ///< a range of positions
        Index firstSlot, rowCount;         ///< a range of slots
        std::size_t firstFactor;           ///< position in factors, of outer products
        std::array<Index, 3> size;  ///< sizes of an outer product; zeros for panels of weights
        std::uint64_t key;          ///< equal for groups with the same numbers
        Offset firstNumber;         ///< position in the compiled table: set by storeNumbers()

        /// Returns how many numbers the group has for each row.
        std::size_t length() const {
            return size[0] == 0 ? columnCount : size[0] + size[1] + size[2];
        }
    };
    std::vector<Group> groups;
    std::vector<Index> positions;  ///< positions of the columns of the groups
    std::vector<Index> slots;      ///< slots of the rows of the groups
    Array<Real> factors;           ///< factors of the outer products, row by row
    std::vector<Index> ungrouped;  ///< slots of the other rows

    Superset first;                      ///< the first superset with this form
    std::vector<Index> subsetPositions;  ///< positions of the columns of each subset of `first`

    /// Returns the numbers of row i of a group: its factors or its weights.
    /// \param spread gets the weights if the row lacks some columns of the group: there the weight
    ///        is 0
    std::span<const Real> numbersOf(const stencils::StencilTable<Real>& table, const Group& group,
                                    Index i, std::vector<Real>& spread) const;
};

/// The forms of some consecutive supersets.
template <class Real>
struct FormBlock {
    std::vector<Index> supersets;
    std::vector<Index> formOf;  ///< the index in `forms` of the form of each superset
    std::vector<SupersetForm<Real>> forms;
};

/// Finds the form of each superset of a block. Supersets with the same weights share one.
/// \cost O(entries)
template <class Real>
void findForms(const stencils::StencilTable<Real>& table, const RowSets& sets,
               const kernels::Kernels<Real>& kernels, FormBlock<Real>& block);

}  // namespace espalier::osd
