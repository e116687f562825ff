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

/// Reverses the steps of an adjoint.
template <class Real>
std::vector<CompiledTable<Real>> inOrder(std::vector<CompiledTable<Real>> steps) {
    return steps;
}
template <class Real>
std::vector<CompiledAdjoint<Real>> inOrder(std::vector<CompiledAdjoint<Real>> steps) {
    std::reverse(steps.begin(), steps.end());
    return steps;
}

/// Compiles tables, and puts them in the order of their evaluation.
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
    return inOrder(std::move(steps));
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
    return inOrder(std::move(steps));
}

/// Room for the values between the steps, of so many components, and for each step in its turn.
/// Those before and after a step are held at once.
template <class Real>
struct ChainRoom {
    std::array<Offset, 2> held = {0, 0};  ///< numbers after every other step
    std::size_t ofStep = 0;

    template <class Step>
    ChainRoom(const std::vector<Step>& steps, Offset length) {
        for (std::size_t i = 0; i < steps.size(); ++i) {
            if (i + 1 < steps.size())
                held[i % 2] = std::max(held[i % 2], steps[i].rowCount() * paddedLength(length));
            ofStep = std::max(ofStep, steps[i].roomFor(length, i > 0));
        }
    }

    std::size_t bytes() const { return roomOf<Real>(held[0]) + roomOf<Real>(held[1]) + ofStep; }
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
std::size_t StepChain<Step, Real>::roomFor(Offset length, bool) const {
    return ChainRoom<Real>(steps_, length).bytes();
}

template <class Step, class Real>
void StepChain<Step, Real>::evaluateIn(std::byte* memory, Values<Real> source,
                                       const BufferDescriptor& sourceLayout,
                                       MutableValues<Real> destination,
                                       const BufferDescriptor& destinationLayout,
                                       RowRange rows) const {
    const ChainRoom<Real> needed(steps_, sourceLayout.length);
    Room room(memory);
    const std::span<Real> held[] = {room.take<Real>(needed.held[0]),
                                    room.take<Real>(needed.held[1])};
    std::byte* const own = room.take<std::byte>(static_cast<Offset>(needed.ofStep)).data();
    // Between the tables, entries lie as the kernels want them.
    const BufferDescriptor between{0, sourceLayout.length, paddedLength(sourceLayout.length)};
    Values<Real> values = source;
    BufferDescriptor layout = sourceLayout;
    for (std::size_t i = 0; i + 1 < steps_.size(); ++i) {
        const auto next = held[i % 2].first(steps_[i].rowCount() * between.stride);
        // Behind the components no numbers that happen to be slow: denormal ones.
        if (between.stride > between.length) std::fill(next.begin(), next.end(), Real{0});
        steps_[i].evaluateIn(own, values, layout, next, between, {0, steps_[i].rowCount()});
        values = next;
        layout = between;
    }
    steps_.back().evaluateIn(own, values, layout, destination, destinationLayout, rows);
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
