// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/base/index.h>
#include <espalier/osd/kernels/simd.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "../kernels/scratch.h"
#include "inverse_index.h"

// The data of a compiled table, and the functions that make it.

namespace espalier::osd {

/// Maximum number of rows in a group. Without a limit, a lattice of few cells would have few groups
/// of very many rows, and too few tasks for all threads.
inline constexpr std::size_t kMaxRowsPerGroup = 1024;

/// The order in which the numbers of a group are stored.
enum class NumberOrder {
    Panels,  ///< the order that PanelRun and ProductRun read
    Adjoint  ///< the order that AdjointRun reads; outer products have weights if it takes no
             ///< factors
};

/// A table whose rows are stored in three forms: panels, outer products and runs. Each row is in
/// one.
template <class Real>
struct CompiledRows {
    /// Rows that share their columns; evaluated as PanelRun or ProductRun, or as AdjointRun.
    struct Group {
        Offset firstColumn;  ///< position in groupColumns
        Index columnCount;
        Offset firstNumber;  ///< position in groupNumbers, which groups may share
        Offset firstRow;     ///< position in groupRows
        Index rowCount;
        Index lowest, highest;      ///< row numbers
        std::array<Index, 3> size;  ///< sizes of an outer product; zeros for weights
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
        Offset firstColumn;  ///< position in columns
        Offset firstWeight;  ///< position in weights
        bool isShared;       ///< true if all rows have the same weights
        Offset firstRow;     ///< position in rows
        Index rowCount;
    };
    std::vector<Run> runs;
    Array<Index> columns;
    Array<Real> weights;
    std::vector<Index> rows;

    /// Memory in bytes.
    std::size_t byteCount() const {
        const auto bytes = [](const auto& values) { return values.size() * sizeof(values[0]); };
        return bytes(groups) + bytes(taskStarts) + bytes(groupColumns) + bytes(groupNumbers) +
               bytes(groupRows) + bytes(runs) + bytes(columns) + bytes(weights) + bytes(rows);
    }
};

/// Chooses the form of each row of a table and stores the row in it.
/// \param simd selects the kernels that split rows into factors. The result has the same bits for
///        all of them, except for NumberOrder::Adjoint: its order suits the kernels of `simd` only
/// \cost O(entries + rows log rows), in parallel; the result does not depend on the number of
/// threads
template <class Real>
CompiledRows<Real> compileRows(const stencils::StencilTable<Real>& table,
                               NumberOrder order = NumberOrder::Panels, Simd simd = bestSimd());

/// Returns the table with only the given rows; all other rows are empty.
/// \cost O(entries)
template <class Real>
stencils::StencilTable<Real> rowsOnly(const stencils::StencilTable<Real>& table,
                                      std::span<const Index> rows);

}  // namespace espalier::osd
