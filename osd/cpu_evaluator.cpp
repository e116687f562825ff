// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/osd/cpu_evaluator.h>

#include <algorithm>

#include "kernels/scratch.h"

namespace espalier::osd {

template <class Real>
void CpuEvaluator::evaluate(const stencils::StencilTable<Real>& table, Values<Real> source,
                            const BufferDescriptor& sourceLayout, MutableValues<Real> destination,
                            const BufferDescriptor& destinationLayout, RowRange rows,
                            const Addend<std::type_identity_t<Real>>& addend) {
    checkEvaluation(table, source, sourceLayout, destination, destinationLayout, rows);
    checkAddend(addend.values.size(), addend.layout, destinationLayout, rows);
    constexpr Offset kGrain = 2048;
    const Offset length = sourceLayout.length;
    parallelFor(rows.last - rows.first, kGrain, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            const Index row = rows.first + static_cast<Index>(i);
            const auto columns = table.columns(row);
            const auto weights = table.weights(row);
            Real* result =
                destination.data() + destinationLayout.offset + row * destinationLayout.stride;
            std::fill_n(result, length, Real{0});
            // The loop over components is the inner one, so that each source entry is read once and
            // contiguously.
            for (std::size_t k = 0; k < columns.size(); ++k) {
                const Real* entry =
                    source.data() + sourceLayout.offset + columns[k] * sourceLayout.stride;
                for (Offset c = 0; c < length; ++c) result[c] += weights[k] * entry[c];
            }
            addTo(result, length, row, addend);
        }
    });
}

template void CpuEvaluator::evaluate(const stencils::StencilTable<float>&, Values<float>,
                                     const BufferDescriptor&, MutableValues<float>,
                                     const BufferDescriptor&, RowRange, const Addend<float>&);
template void CpuEvaluator::evaluate(const stencils::StencilTable<double>&, Values<double>,
                                     const BufferDescriptor&, MutableValues<double>,
                                     const BufferDescriptor&, RowRange, const Addend<double>&);

template <class Real>
void ReferenceEvaluator::evaluate(const stencils::StencilTable<Real>& table, Values<Real> source,
                                  const BufferDescriptor& sourceLayout,
                                  MutableValues<Real> destination,
                                  const BufferDescriptor& destinationLayout, RowRange rows,
                                  const Addend<std::type_identity_t<Real>>& addend) {
    checkEvaluation(table, source, sourceLayout, destination, destinationLayout, rows);
    checkAddend(addend.values.size(), addend.layout, destinationLayout, rows);
    const auto at = [](const BufferDescriptor& layout, Index entry, Offset component) {
        return layout.offset + entry * layout.stride + component;
    };
    for (Index row = rows.first; row < rows.last; ++row)
        for (Offset component = 0; component < sourceLayout.length; ++component) {
            Real sum = 0;
            for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                sum += table.weights(row)[k] *
                       source[at(sourceLayout, table.columns(row)[k], component)];
            if (addend.layout.length > 0)
                sum += addend.values[at(addend.layout, row, component % addend.layout.length)];
            destination[at(destinationLayout, row, component)] = sum;
        }
}

template void ReferenceEvaluator::evaluate(const stencils::StencilTable<float>&, Values<float>,
                                           const BufferDescriptor&, MutableValues<float>,
                                           const BufferDescriptor&, RowRange, const Addend<float>&);
template void ReferenceEvaluator::evaluate(const stencils::StencilTable<double>&, Values<double>,
                                           const BufferDescriptor&, MutableValues<double>,
                                           const BufferDescriptor&, RowRange,
                                           const Addend<double>&);

}  // namespace espalier::osd
