// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/reference_evaluator.h>

namespace espalier::osd {

template <class Real>
void ReferenceEvaluator::evaluate(const stencils::StencilTable<Real>& table, Values<Real> source,
                                  const BufferDescriptor& sourceLayout,
                                  MutableValues<Real> destination,
                                  const BufferDescriptor& destinationLayout, RowRange rows) {
    checkEvaluation(table, source, sourceLayout, destination, destinationLayout, rows);
    const auto at = [](const BufferDescriptor& layout, Index entry, Offset component) {
        return static_cast<std::size_t>(layout.offset + entry * layout.stride + component);
    };
    for (Index row = rows.first; row < rows.last; ++row)
        for (Offset component = 0; component < sourceLayout.length; ++component) {
            Real sum = 0;
            for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                sum += table.weights(row)[k] *
                       source[at(sourceLayout, table.columns(row)[k], component)];
            destination[at(destinationLayout, row, component)] = sum;
        }
}

template void ReferenceEvaluator::evaluate(const stencils::StencilTable<float>&, Values<float>,
                                           const BufferDescriptor&, MutableValues<float>,
                                           const BufferDescriptor&, RowRange);
template void ReferenceEvaluator::evaluate(const stencils::StencilTable<double>&, Values<double>,
                                           const BufferDescriptor&, MutableValues<double>,
                                           const BufferDescriptor&, RowRange);

}  // namespace espalier::osd
