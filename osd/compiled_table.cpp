// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>

#include <algorithm>
#include <utility>

#include "compile/compiled_table_data.h"
#include "compiled_form.h"

namespace espalier::osd {
namespace {

/// Buffers of the tasks: each holds the source entries of one group at a time.
template <class Data>
auto taskBuffers(const Data& data, Offset stride) {
    using Real = typename decltype(data.rows.weights)::value_type;
    return TaskBuffers<Real>(std::ssize(data.rows.taskStarts) - 1, data.maxColumns * stride);
}

}  // namespace

template <class Real>
CompiledTable<Real>::CompiledTable(const stencils::StencilTable<Real>& table, Simd simd) {
    if (!hasSimd(simd)) throw Error("this processor lacks the vector instructions asked for");
    CompiledRows<Real> rows = compileRows(table, NumberOrder::Panels, simd);
    Index maxColumns = 0;
    for (const auto& group : rows.groups) maxColumns = std::max(maxColumns, group.columnCount);
    data_ = std::make_shared<const Data>(Data{table.rowCount(), table.columnCount(),
                                              kernels::kernelsFor<Real>(simd), std::move(rows),
                                              maxColumns});
}

template <class Real>
Index CompiledTable<Real>::rowCount() const {
    return data_->rowCount;
}

template <class Real>
Index CompiledTable<Real>::columnCount() const {
    return data_->columnCount;
}

template <class Real>
Index CompiledTable<Real>::panelRowCount() const {
    return static_cast<Index>(data_->rows.groupRows.size());
}

template <class Real>
Index CompiledTable<Real>::productRowCount() const {
    Index count = 0;
    for (const auto& group : data_->rows.groups) count += group.size[0] > 0 ? group.rowCount : 0;
    return count;
}

template <class Real>
std::size_t CompiledTable<Real>::byteCount() const {
    return data_->rows.byteCount();
}

template <class Real>
std::size_t CompiledTable<Real>::workspaceBytes(Offset length, bool hasPaddedSource) const {
    const Offset stride = paddedLength(length);
    return taskBuffers(*data_, stride).bytes() +
           (hasPaddedSource ? 0 : scratchBytes<Real>(columnCount(), stride));
}

template <class Real>
void CompiledTable<Real>::evaluateIn(std::byte* memory, Values<Real> source,
                                     const BufferDescriptor& sourceLayout,
                                     MutableValues<Real> destination,
                                     const BufferDescriptor& destinationLayout, RowRange rows,
                                     const Addend<Real>& addend) const {
    Scratch scratch(memory);
    const Offset length = sourceLayout.length, stride = paddedLength(length);
    auto numbers = taskBuffers(*data_, stride);
    numbers.allocateFrom(scratch);
    const Real* entries = source.data() + sourceLayout.offset;
    if (!isPadded<Real>(columnCount(), source, sourceLayout)) {
        const std::span<Real> copy = scratch.take<Real>(columnCount() * stride);
        constexpr Offset kGrain = 8192;
        parallelFor(columnCount(), kGrain, [&](Offset first, Offset last) {
            for (Offset i = first; i < last; ++i)
                copyPadded(entries + i * sourceLayout.stride, length, stride,
                           copy.data() + i * stride);
        });
        entries = copy.data();
    }
    const auto to = destinationOf<Real>(destination, destinationLayout, rows, rowCount(), addend);
    const auto& starts = data_->rows.taskStarts;
    parallelFor(std::ssize(starts) - 1, 1, [&](Offset task, Offset) {
        typename TaskBuffers<Real>::Local own(numbers, task);
        for (Offset g = starts[task]; g < starts[task + 1]; ++g) {
            const auto& group = data_->rows.groups[g];
            if (group.highest < to.first || group.lowest >= to.last) continue;
            Real* next = own.data();
            for (const Index column : data_->columnsOf(group))
                next = std::copy_n(entries + column * stride, stride, next);
            data_->evaluateGroup(group, own.data(), stride, data_->rowsOf(group).data(), to);
        }
    });
    parallelFor(std::ssize(data_->rows.runs), 1, [&](Offset run, Offset) {
        data_->evaluateRun(data_->rows.runs[run], entries, stride, to);
    });
}

template class CompiledForm<CompiledTable<float>, float>;
template class CompiledForm<CompiledTable<double>, double>;
template class CompiledTable<float>;
template class CompiledTable<double>;

}  // namespace espalier::osd
