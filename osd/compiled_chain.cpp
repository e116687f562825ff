// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/osd/compiled_chain.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "compiled_form.h"

namespace espalier::osd {
namespace {

using stencils::FactoredTable;
using stencils::StencilTable;

/// Returns the steps in the order of evaluation. That of an adjoint is the reverse.
template <class Real>
std::vector<CompiledTable<Real>> inEvaluationOrder(std::vector<CompiledTable<Real>> steps) {
    return steps;
}
template <class Real>
std::vector<CompiledAdjoint<Real>> inEvaluationOrder(std::vector<CompiledAdjoint<Real>> steps) {
    std::reverse(steps.begin(), steps.end());
    return steps;
}

/// Compiles the tables and returns them in the order of evaluation.
template <class Step, class Real>
std::vector<Step> compiled(std::span<const StencilTable<Real>> tables, Simd simd) {
    if (tables.empty()) throw Error("a chain needs at least one table");
    std::vector<Step> steps;
    for (std::size_t i = 0; i < tables.size(); ++i) {
        if (i > 0 && tables[i].columnCount() != tables[i - 1].rowCount())
            throw Error(concat("table ", i + 1, " of the chain has ", tables[i].columnCount(),
                               " columns; the one before has ", tables[i - 1].rowCount(), " rows"));
        steps.emplace_back(tables[i], simd);
    }
    return inEvaluationOrder(std::move(steps));
}

template <class Step, class Real>
std::vector<Step> compiled(const FactoredTable<Real>& table, Simd simd) {
    if (table.points.columnCount() != table.vertices.rowCount())
        throw Error(concat("the table of points has ", table.points.columnCount(),
                           " columns; the table of vertices has ", table.vertices.rowCount(),
                           " rows"));
    std::vector<Step> steps;
    steps.emplace_back(table.vertices, simd);
    steps.emplace_back(table.points, simd);
    return inEvaluationOrder(std::move(steps));
}

/// The temporary memory of a chain: the intermediate values between two steps, for entries of
/// `length` components, and the workspace of one step at a time. The source and the result of a
/// step exist at once, so intermediate values alternate between two buffers.
template <class Real>
struct ChainScratch {
    std::array<Offset, 2> sizes = {0, 0};  ///< size of each of the two buffers, in numbers
    std::size_t stepBytes = 0;

    template <class Step>
    ChainScratch(const std::vector<Step>& steps, Offset length) {
        for (std::size_t i = 0; i < steps.size(); ++i) {
            if (i + 1 < steps.size())
                sizes[i % 2] = std::max(sizes[i % 2], steps[i].rowCount() * paddedLength(length));
            stepBytes = std::max(stepBytes, steps[i].workspaceBytes(length, i > 0));
        }
    }

    std::size_t bytes() const {
        return scratchBytes<Real>(sizes[0]) + scratchBytes<Real>(sizes[1]) + stepBytes;
    }
};

}  // namespace

template <class Step, class Real>
StepChain<Step, Real>::StepChain(std::span<const StencilTable<Real>> tables, Simd simd)
    : steps_(compiled<Step>(tables, simd)) {}

template <class Step, class Real>
StepChain<Step, Real>::StepChain(const FactoredTable<Real>& table, Simd simd)
    : steps_(compiled<Step>(table, simd)) {}

template <class Step, class Real>
std::size_t StepChain<Step, Real>::byteCount() const {
    std::size_t bytes = 0;
    for (const Step& step : steps_) bytes += step.byteCount();
    return bytes;
}

template <class Step, class Real>
std::size_t StepChain<Step, Real>::workspaceBytes(Offset length, bool) const {
    return ChainScratch<Real>(steps_, length).bytes();
}

template <class Step, class Real>
void StepChain<Step, Real>::evaluateIn(std::byte* memory, Values<Real> source,
                                       const BufferDescriptor& sourceLayout,
                                       MutableValues<Real> destination,
                                       const BufferDescriptor& destinationLayout, RowRange rows,
                                       const Addend<Real>& addend) const {
    const ChainScratch<Real> needed(steps_, sourceLayout.length);
    Scratch scratch(memory);
    const std::span<Real> buffers[] = {scratch.take<Real>(needed.sizes[0]),
                                       scratch.take<Real>(needed.sizes[1])};
    std::byte* const stepMemory =
        scratch.take<std::byte>(static_cast<Offset>(needed.stepBytes)).data();
    // Intermediate values have the padded layout, which the kernels read without a copy.
    const BufferDescriptor between{0, sourceLayout.length, paddedLength(sourceLayout.length)};
    Values<Real> values = source;
    BufferDescriptor layout = sourceLayout;
    for (std::size_t i = 0; i + 1 < steps_.size(); ++i) {
        const auto next = buffers[i % 2].first(steps_[i].rowCount() * between.stride);
        // Clears the padding: denormal numbers in it would slow the kernels down.
        if (between.stride > between.length) std::fill(next.begin(), next.end(), Real{0});
        steps_[i].evaluateIn(stepMemory, values, layout, next, between, {0, steps_[i].rowCount()},
                             {});
        values = next;
        layout = between;
    }
    steps_.back().evaluateIn(stepMemory, values, layout, destination, destinationLayout, rows,
                             addend);
}

#define ESPALIER_INSTANTIATE(Step, Real)                            \
    template class CompiledForm<StepChain<Step<Real>, Real>, Real>; \
    template class StepChain<Step<Real>, Real>;
ESPALIER_INSTANTIATE(CompiledTable, float)
ESPALIER_INSTANTIATE(CompiledTable, double)
ESPALIER_INSTANTIATE(CompiledAdjoint, float)
ESPALIER_INSTANTIATE(CompiledAdjoint, double)
#undef ESPALIER_INSTANTIATE

}  // namespace espalier::osd
