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

// What is inside a compiled table.

namespace espalier::osd {

/// Rows of a group, at most, since a lattice of few cells has few sets of columns, of very many
/// rows.
inline constexpr std::size_t kMaxRowsPerGroup = 1024;

/// A table in three forms, each row in one of them.
template <class Real>
struct CompiledRows {
    /// Rows that share their columns: PanelRun, or ProductRun.
    struct Group {
        Offset firstColumn;  ///< in groupColumns
        Index columnCount;
        Offset firstNumber;  ///< in groupNumbers, which groups may share
        Offset firstRow;     ///< in groupRows
        Index rowCount;
        Index lowest, highest;      ///< row
        std::array<Index, 3> size;  ///< of a product; zeros if these are panels of weights
    };
    std::vector<Group> groups;
    /// For one thread after the other: task t is groups taskStarts[t] to taskStarts[t + 1] − 1.
    std::vector<Offset> taskStarts = {0};
    std::vector<Index> groupColumns;
    AlignedVector<Real> groupNumbers;  ///< weights, or factors of products
    std::vector<Index> groupRows;

    /// Rows of the same number of entries: RowRun.
    struct Run {
        Index length;
        Offset firstColumn;  ///< in columns
        Offset firstWeight;  ///< in weights
        bool isShared;       ///< whether the weights are those of each row
        Offset firstRow;     ///< in rows
        Index rowCount;
    };
    std::vector<Run> runs;
    std::vector<Index> columns;
    std::vector<Real> weights;
    std::vector<Index> rows;

    /// Memory that it takes.
    std::size_t byteCount() const {
        const auto bytes = [](const auto& values) { return values.size() * sizeof(values[0]); };
        return bytes(groups) + bytes(taskStarts) + bytes(groupColumns) + bytes(groupNumbers) +
               bytes(groupRows) + bytes(runs) + bytes(columns) + bytes(weights) + bytes(rows);
    }
};

/// Finds the form of each row of a table.
/// \cost O(entries + rows log rows)
template <class Real>
CompiledRows<Real> compileRows(const stencils::StencilTable<Real>& table);

/// The same table with these rows alone: the others are empty.
/// \cost O(entries)
template <class Real>
stencils::StencilTable<Real> rowsOnly(const stencils::StencilTable<Real>& table,
                                      std::span<const Index> rows);

/// Of each column of a table the places, ascending, in which it was found: in whatever a caller
/// counts by Place.
template <class Place>
class InverseIndex {
public:
    /// \param forEach calls what it is given with each column and place, places ascending; twice
    ///        the same
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
