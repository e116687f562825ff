// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/table_compiler.h>

#include <algorithm>
#include <cstdint>

namespace espalier::osd {
namespace {

std::size_t at(Offset index) {
    return static_cast<std::size_t>(index);
}

/// Source entries as the kernels want them: where they do not lie so, a copy.
template <class Real>
class Points {
public:
    Points(Index count, Values<Real> source, const BufferDescriptor& layout)
        : stride_(paddedLength(layout.length)) {
        const Real* first = source.data() + layout.offset;
        if (layout.stride == stride_ && source.size() >= at(layout.offset + count * stride_) &&
            reinterpret_cast<std::uintptr_t>(first) % (kernels::kPadding * sizeof(Real)) == 0) {
            values_ = first;
            return;
        }
        copy_.resize(at(count * stride_));
        constexpr Offset kGrain = 8192;
        far::parallelFor(count, kGrain, [&](Offset begin, Offset end) {
            for (Offset i = begin; i < end; ++i)
                std::copy_n(first + i * layout.stride, layout.length, copy_.data() + i * stride_);
        });
        values_ = copy_.data();
    }

    const Real* data() const { return values_; }
    Offset stride() const { return stride_; }

private:
    Offset stride_;
    AlignedVector<Real> copy_;
    const Real* values_;
};

}  // namespace

template <class Real>
struct CompiledTable<Real>::Data {
    Index rowCount, columnCount;
    kernels::Kernels<Real> kernels;
    CompiledRows<Real> rows;

    void evaluateGroups(Offset first, Offset last, const Points<Real>& points,
                        const kernels::Destination<Real>& to) const {
        const Offset stride = points.stride();
        AlignedVector<Real> own;
        for (Offset g = first; g < last; ++g) {
            const auto& group = rows.groups[at(g)];
            if (group.highest < to.first || group.lowest >= to.last) continue;
            own.resize(at(group.columnCount * stride));
            for (Index k = 0; k < group.columnCount; ++k)
                std::copy_n(points.data() + rows.groupColumns[at(group.firstColumn + k)] * stride,
                            stride, own.data() + k * stride);
            const Real* numbers = rows.groupNumbers.data() + group.firstNumber;
            const Index* rowNumbers = rows.groupRows.data() + group.firstRow;
            if (group.size[0] == 0)
                kernels.panels(
                    {numbers, own.data(), stride, group.columnCount, rowNumbers, group.rowCount},
                    to);
            else
                kernels.products({numbers,
                                  own.data(),
                                  stride,
                                  {group.size[0], group.size[1], group.size[2]},
                                  rowNumbers,
                                  group.rowCount},
                                 to);
        }
    }

    void evaluateRuns(Offset first, Offset last, const Points<Real>& points,
                      const kernels::Destination<Real>& to) const {
        for (Offset r = first; r < last; ++r) {
            const auto& run = rows.runs[at(r)];
            kernels.rows({rows.weights.data() + run.firstWeight, run.isShared,
                          rows.columns.data() + run.firstColumn, run.length, points.data(),
                          points.stride(), rows.rows.data() + run.firstRow, run.rowCount},
                         to);
        }
    }
};

template <class Real>
CompiledTable<Real>::CompiledTable(const stencils::StencilTable<Real>& table, Simd simd) {
    if (!hasSimd(simd)) throw Error("this processor lacks the vector instructions asked for");
    data_ = std::make_unique<const Data>(Data{table.rowCount(), table.columnCount(),
                                              kernels::kernelsFor<Real>(simd), compileRows(table)});
}

template <class Real>
CompiledTable<Real>::~CompiledTable() = default;
template <class Real>
CompiledTable<Real>::CompiledTable(CompiledTable&&) noexcept = default;
template <class Real>
CompiledTable<Real>& CompiledTable<Real>::operator=(CompiledTable&&) noexcept = default;

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
void CompiledTable<Real>::evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                                   MutableValues<Real> destination,
                                   const BufferDescriptor& destinationLayout, RowRange rows) const {
    checkEvaluation(rowCount(), columnCount(), source.size(), sourceLayout, destination.size(),
                    destinationLayout, rows);
    const Points<Real> points(columnCount(), source, sourceLayout);
    const kernels::Destination<Real> to = {destination.data() + destinationLayout.offset,
                                           destinationLayout.stride,
                                           destinationLayout.length,
                                           rows.first,
                                           rows.last,
                                           rows.first == 0 && rows.last == rowCount()};
    const auto& starts = data_->rows.taskStarts;
    far::parallelFor(static_cast<Offset>(starts.size()) - 1, 1, [&](Offset first, Offset last) {
        data_->evaluateGroups(starts[at(first)], starts[at(last)], points, to);
    });
    far::parallelFor(
        static_cast<Offset>(data_->rows.runs.size()), 1,
        [&](Offset first, Offset last) { data_->evaluateRuns(first, last, points, to); });
}

template class CompiledTable<float>;
template class CompiledTable<double>;

}  // namespace espalier::osd
