// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "../kernels/scratch.h"

// The data of a compiled table, and the functions that make it.

namespace espalier::osd {

/// Maximum number of rows in a group. Without a limit, a lattice of few cells would have few groups
/// of very many rows, and too few tasks for all threads.
inline constexpr std::size_t kMaxRowsPerGroup = 1024;

/// A table whose rows are stored in three forms: panels, outer products and runs. Each row is in
/// one.
template <class Real>
struct CompiledRows {
    /// Rows that share their columns; evaluated as PanelRun or ProductRun.
    struct Group {
        Offset firstColumn;  ///< in groupColumns
        Index columnCount;
        Offset firstNumber;  ///< in groupNumbers, which groups may share
        Offset firstRow;     ///< in groupRows
        Index rowCount;
        Index lowest, highest;      ///< row numbers
        std::array<Index, 3> size;  ///< of an outer product; zeros for panels of weights
    };
    std::vector<Group> groups;
    /// Task t is groups taskStarts[t] to taskStarts[t + 1] − 1. One thread evaluates a task.
    std::vector<Offset> taskStarts = {0};
    std::vector<Index> groupColumns;
    AlignedVector<Real> groupNumbers;  ///< weights, or factors of outer products
    std::vector<Index> groupRows;

    /// Rows of equal length; evaluated as RowRun.
    struct Run {
        Index length;
        Offset firstColumn;  ///< in columns
        Offset firstWeight;  ///< in weights
        bool isShared;       ///< true if all rows have the same weights
        Offset firstRow;     ///< in rows
        Index rowCount;
    };
    std::vector<Run> runs;
    std::vector<Index> columns;
    std::vector<Real> weights;
    std::vector<Index> rows;

    /// Memory in bytes.
    std::size_t byteCount() const {
        const auto bytes = [](const auto& values) { return values.size() * sizeof(values[0]); };
        return bytes(groups) + bytes(taskStarts) + bytes(groupColumns) + bytes(groupNumbers) +
               bytes(groupRows) + bytes(runs) + bytes(columns) + bytes(weights) + bytes(rows);
    }
};

/// Chooses the form of each row of a table and stores the row in it.
/// \cost O(entries + rows log rows)
template <class Real>
CompiledRows<Real> compileRows(const stencils::StencilTable<Real>& table);

/// Returns the table with only the given rows; all other rows are empty.
/// \cost O(entries)
template <class Real>
stencils::StencilTable<Real> rowsOnly(const stencils::StencilTable<Real>& table,
                                      std::span<const Index> rows);

/// An inverse index: for each column of a table, the places that refer to it, ascending. `Place` is
/// any type in which the caller counts them.
template <class Place>
class InverseIndex {
public:
    /// \param forEach calls its argument with each pair of column and place, places ascending. It
    ///        is called twice and must produce the same pairs both times
    template <class ForEach>
    InverseIndex(Index columnCount, ForEach forEach) : offsets_(columnCount + 1, 0) {
        forEach([&](Index column, Place) { ++offsets_[column + 1]; });
        std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
        places_.resize(offsets_.back());
        std::vector<Offset> next(offsets_.begin(), offsets_.end() - 1);
        forEach([&](Index column, Place place) { places_[next[column]++] = place; });
    }

    std::span<const Place> of(Index column) const {
        return std::span(places_).subspan(offsets_[column],
                                          offsets_[column + 1] - offsets_[column]);
    }

    std::size_t byteCount() const {
        return offsets_.size() * sizeof(Offset) + places_.size() * sizeof(Place);
    }

private:
    std::vector<Offset> offsets_;
    std::vector<Place> places_;
};

}  // namespace espalier::osd
