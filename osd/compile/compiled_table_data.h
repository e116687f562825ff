// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/compiled_table.h>

#include "table_compiler.h"

namespace espalier::osd {

/// Returns the destination of the kernels.
/// \param rowCount of the table
template <class Real>
kernels::Destination<Real> destinationOf(MutableValues<Real> values, const BufferDescriptor& layout,
                                         RowRange rows, Index rowCount,
                                         const Addend<Real>& addend) {
    const bool adds = addend.layout.length > 0;
    return {values.data() + layout.offset,
            layout.stride,
            layout.length,
            rows.first,
            rows.last,
            rows.first == 0 && rows.last == rowCount,
            adds ? addend.values.data() + addend.layout.offset : nullptr,
            addend.layout.stride,
            addend.layout.length};
}

/// The data of a compiled table, and the evaluation of its parts.
template <class Real>
struct CompiledTable<Real>::Data {
    using Rows = CompiledRows<Real>;

    Index rowCount, columnCount;
    kernels::Kernels<Real> kernels;
    Rows rows;
    Index maxColumns;  ///< maximum number of columns of a group

    std::span<const Index> columnsOf(const typename Rows::Group& group) const {
        return std::span(rows.groupColumns).subspan(group.firstColumn, group.columnCount);
    }
    std::span<const Index> rowsOf(const typename Rows::Group& group) const {
        return std::span(rows.groupRows).subspan(group.firstRow, group.rowCount);
    }

    /// \param entries source entries of the columns of the group, in their order, `stride` apart
    /// \param rowNumbers the rows of the group; rows outside the range of `to` are skipped
    void evaluateGroup(const typename Rows::Group& group, const Real* entries, Offset stride,
                       const Index* rowNumbers, const kernels::Destination<Real>& to) const {
        const Real* numbers = rows.groupNumbers.data() + group.firstNumber;
        if (group.size[0] == 0)
            kernels.panels(
                {numbers, entries, stride, group.columnCount, rowNumbers, group.rowCount}, to);
        else
            kernels.products({numbers,
                              entries,
                              stride,
                              {group.size[0], group.size[1], group.size[2]},
                              rowNumbers,
                              group.rowCount},
                             to);
    }

    /// \param entries all source entries, `stride` apart
    void evaluateRun(const typename Rows::Run& run, const Real* entries, Offset stride,
                     const kernels::Destination<Real>& to) const {
        kernels.rows({rows.weights.data() + run.firstWeight, run.isShared,
                      rows.columns.data() + run.firstColumn, run.length, entries, stride,
                      rows.rows.data() + run.firstRow, run.rowCount},
                     to);
    }

    /// Evaluates row i of a run from the source entries of its own columns.
    /// \param ascending 0, 1, …: the positions of its columns in `entries`
    void evaluateRow(const typename Rows::Run& run, Index i, const Real* entries, Offset stride,
                     const Index* ascending, const kernels::Destination<Real>& to) const {
        const Offset firstWeight = run.firstWeight + (run.isShared ? 0 : Offset{i} * run.length);
        kernels.rows({rows.weights.data() + firstWeight, run.isShared, ascending, run.length,
                      entries, stride, rows.rows.data() + run.firstRow + i, 1},
                     to);
    }
};

}  // namespace espalier::osd
