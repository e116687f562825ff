// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/padding.h>

#include <algorithm>
#include <string>
#include <utility>

namespace espalier::osd {
namespace {

using stencils::FactoredTable;
using stencils::StencilTable;

/// Compiles tables, the first first.
template <class Step, class Real>
std::vector<Step> compiled(std::span<const StencilTable<Real>> tables, Simd simd) {
    if (tables.empty()) throw Error("a chain needs at least one table");
    std::vector<Step> steps;
    for (std::size_t i = 0; i < tables.size(); ++i) {
        if (i > 0 && tables[i].columnCount() != tables[i - 1].rowCount())
            throw Error("table " + std::to_string(i + 1) + " of the chain has " +
                        std::to_string(tables[i].columnCount()) + " columns; the one before has " +
                        std::to_string(tables[i - 1].rowCount()) + " rows");
        steps.emplace_back(tables[i], simd);
    }
    return steps;
}

template <class Step, class Real>
std::vector<Step> compiled(const FactoredTable<Real>& table, Simd simd) {
    if (table.points.columnCount() != table.vertices.rowCount())
        throw Error("the points are of " + std::to_string(table.points.columnCount()) +
                    " vertices; the table of these has " +
                    std::to_string(table.vertices.rowCount()));
    std::vector<Step> steps;
    steps.emplace_back(table.vertices, simd);
    steps.emplace_back(table.points, simd);
    return steps;
}

/// The same, the last first.
template <class Step>
std::vector<Step> reversed(std::vector<Step> steps) {
    std::reverse(steps.begin(), steps.end());
    return steps;
}

template <class Step>
std::size_t bytesOf(std::span<const Step> steps) {
    std::size_t bytes = 0;
    for (const Step& step : steps) bytes += step.byteCount();
    return bytes;
}

template <class Real, class Step>
void evaluateInTurn(std::span<const Step> steps, Values<Real> source,
                    const BufferDescriptor& sourceLayout, MutableValues<Real> destination,
                    const BufferDescriptor& destinationLayout, RowRange rows) {
    checkEvaluation(steps.back().rowCount(), steps.front().columnCount(), source.size(),
                    sourceLayout, destination.size(), destinationLayout, rows);
    // Between the tables, entries lie as the kernels want them.
    const BufferDescriptor between{0, sourceLayout.length, paddedLength(sourceLayout.length)};
    Values<Real> values = source;
    BufferDescriptor layout = sourceLayout;
    AlignedVector<Real> held;
    for (const Step& step : steps.first(steps.size() - 1)) {
        AlignedVector<Real> next(static_cast<std::size_t>(step.rowCount() * between.stride));
        step.evaluate(values, layout, next, between, {0, step.rowCount()});
        held = std::move(next);
        values = held;
        layout = between;
    }
    steps.back().evaluate(values, layout, destination, destinationLayout, rows);
}

}  // namespace

template <class Real>
CompiledChain<Real>::CompiledChain(std::span<const StencilTable<Real>> tables, Simd simd)
    : steps_(compiled<CompiledTable<Real>>(tables, simd)) {}

template <class Real>
CompiledChain<Real>::CompiledChain(const FactoredTable<Real>& table, Simd simd)
    : steps_(compiled<CompiledTable<Real>>(table, simd)) {}

template <class Real>
std::size_t CompiledChain<Real>::byteCount() const {
    return bytesOf(std::span(steps_));
}

template <class Real>
void CompiledChain<Real>::evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                                   MutableValues<Real> destination,
                                   const BufferDescriptor& destinationLayout, RowRange rows) const {
    evaluateInTurn<Real>(std::span(steps_), source, sourceLayout, destination, destinationLayout,
                         rows);
}

template <class Real>
CompiledAdjointChain<Real>::CompiledAdjointChain(std::span<const StencilTable<Real>> tables,
                                                 Simd simd)
    : steps_(reversed(compiled<CompiledAdjoint<Real>>(tables, simd))) {}

template <class Real>
CompiledAdjointChain<Real>::CompiledAdjointChain(const FactoredTable<Real>& table, Simd simd)
    : steps_(reversed(compiled<CompiledAdjoint<Real>>(table, simd))) {}

template <class Real>
std::size_t CompiledAdjointChain<Real>::byteCount() const {
    return bytesOf(std::span(steps_));
}

template <class Real>
void CompiledAdjointChain<Real>::evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                                          MutableValues<Real> destination,
                                          const BufferDescriptor& destinationLayout,
                                          RowRange rows) const {
    evaluateInTurn<Real>(std::span(steps_), source, sourceLayout, destination, destinationLayout,
                         rows);
}

template class CompiledChain<float>;
template class CompiledChain<double>;
template class CompiledAdjointChain<float>;
template class CompiledAdjointChain<double>;

}  // namespace espalier::osd
