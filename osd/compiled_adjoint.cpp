// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/osd/compiled_adjoint.h>

#include <algorithm>
#include <utility>

#include "compile/table_compiler.h"
#include "compiled_form.h"

namespace espalier::osd {

using stencils::StencilTable;

template <class Real>
struct CompiledAdjoint<Real>::Data {
    Index tableRowCount, tableColumnCount;
    kernels::Kernels<Real> kernels;
    CompiledRows<Real> rows;       ///< groups only; there are no runs
    InverseIndex<Offset> slots;    ///< column → its slots in groupColumns
    StencilTable<Real> ungrouped;  ///< all other rows, transposed
    Index maxColumns = 0;          ///< maximum number of columns of a group

    /// Buffers of the tasks: the partial sums of one group at a time.
    TaskBuffers<Real> taskBuffers() const {
        return {std::ssize(rows.taskStarts) - 1, kernels::adjointSumCount<Real>(maxColumns)};
    }

    /// Computes the sums of each group for its columns: `length` numbers for each slot of
    /// groupColumns.
    void sumGroups(const kernels::RowValues<Real>& source, const TaskBuffers<Real>& numbers,
                   std::span<Real> sums) const {
        const auto& starts = rows.taskStarts;
        parallelFor(std::ssize(starts) - 1, 1, [&](Offset task, Offset) {
            typename TaskBuffers<Real>::Local lanes(numbers, task);
            for (Offset g = starts[task]; g < starts[task + 1]; ++g) {
                const auto& group = rows.groups[g];
                kernels.adjoint({rows.groupNumbers.data() + group.firstNumber,
                                 {group.size[0], group.size[1], group.size[2]},
                                 group.columnCount,
                                 rows.groupRows.data() + group.firstRow,
                                 group.rowCount},
                                source, sums.data() + group.firstColumn * source.length,
                                lanes.data());
            }
        });
    }
};

template <class Real>
CompiledAdjoint<Real>::CompiledAdjoint(const StencilTable<Real>& table, Simd simd) {
    if (!hasSimd(simd)) throw Error("this processor lacks the vector instructions asked for");
    CompiledRows<Real> rows = compileRows(table, NumberOrder::Adjoint, simd);
    auto ungrouped = stencils::transposeTable(rowsOnly<Real>(table, rows.rows));
    // The ungrouped rows are kept in transposed form only. Assigning {} would not free the memory.
    rows.runs = decltype(rows.runs)();
    rows.columns = decltype(rows.columns)();
    rows.weights = decltype(rows.weights)();
    rows.rows = decltype(rows.rows)();
    Index maxColumns = 0;
    for (const auto& group : rows.groups) maxColumns = std::max(maxColumns, group.columnCount);
    InverseIndex<Offset> slots(table.columnCount(), [&](auto found) {
        for (Offset slot = 0; slot < std::ssize(rows.groupColumns); ++slot)
            found(rows.groupColumns[slot], slot);
    });
    data_ = std::make_shared<const Data>(Data{table.rowCount(), table.columnCount(),
                                              kernels::kernelsFor<Real>(simd), std::move(rows),
                                              std::move(slots), std::move(ungrouped), maxColumns});
}

template <class Real>
Index CompiledAdjoint<Real>::rowCount() const {
    return data_->tableColumnCount;
}

template <class Real>
Index CompiledAdjoint<Real>::columnCount() const {
    return data_->tableRowCount;
}

template <class Real>
std::size_t CompiledAdjoint<Real>::byteCount() const {
    return data_->rows.byteCount() + data_->slots.byteCount() +
           data_->ungrouped.offsets().size_bytes() + data_->ungrouped.columns().size_bytes() +
           data_->ungrouped.weights().size_bytes();
}

template <class Real>
std::size_t CompiledAdjoint<Real>::workspaceBytes(Offset length, bool) const {
    return data_->taskBuffers().bytes() +
           scratchBytes<Real>(std::ssize(data_->rows.groupColumns), length);
}

template <class Real>
void CompiledAdjoint<Real>::evaluateIn(std::byte* memory, Values<Real> source,
                                       const BufferDescriptor& sourceLayout,
                                       MutableValues<Real> destination,
                                       const BufferDescriptor& destinationLayout, RowRange rows,
                                       const Addend<Real>& addend) const {
    const Offset length = sourceLayout.length;
    const kernels::RowValues<Real> values = {source.data() + sourceLayout.offset,
                                             sourceLayout.stride, length};
    Scratch scratch(memory);
    TaskBuffers<Real> numbers = data_->taskBuffers();
    numbers.allocateFrom(scratch);
    const std::span<Real> sums = scratch.take<Real>(std::ssize(data_->rows.groupColumns) * length);
    data_->sumGroups(values, numbers, sums);
    constexpr Offset kGrain = 64;
    parallelFor(rows.last - rows.first, kGrain, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            const auto row = static_cast<Index>(rows.first + i);
            Real* const result =
                destination.data() + destinationLayout.offset + row * destinationLayout.stride;
            std::fill_n(result, length, Real{0});
            for (const Offset slot : data_->slots.of(row))
                for (Offset c = 0; c < length; ++c) result[c] += sums[slot * length + c];
            const auto columns = data_->ungrouped.columns(row);
            const auto weights = data_->ungrouped.weights(row);
            for (std::size_t k = 0; k < columns.size(); ++k)
                for (Offset c = 0; c < length; ++c)
                    result[c] += weights[k] * values.values[columns[k] * values.stride + c];
            addTo(result, length, row, addend);
        }
    });
}

template class CompiledForm<CompiledAdjoint<float>, float>;
template class CompiledForm<CompiledAdjoint<double>, double>;
template class CompiledAdjoint<float>;
template class CompiledAdjoint<double>;

}  // namespace espalier::osd
