// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/osd/compiled_chain.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "kernels/room.h"

namespace espalier::osd {

/// What the steps of a chain do in memory of somebody else's.
struct ChainSteps {
    template <class Real>
    static std::size_t roomFor(const CompiledTable<Real>& step, Offset length, bool isPadded) {
        return step.roomFor(length, isPadded);
    }
    template <class Real>
    static std::size_t roomFor(const CompiledAdjoint<Real>& step, Offset length, bool) {
        return step.roomFor(length);
    }
    template <class Step, class... Arguments>
    static void evaluate(const Step& step, const Arguments&... arguments) {
        step.evaluateIn(arguments...);
    }
};

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

/// Room for the values between the steps, of so many components, and for each step in its turn.
/// Those before and after a step are held at once.
template <class Real>
struct ChainRoom {
    std::array<Offset, 2> held = {0, 0};  ///< numbers after every other step
    std::size_t ofStep = 0;

    template <class Step>
    ChainRoom(std::span<const Step> steps, Offset length) {
        for (std::size_t i = 0; i < steps.size(); ++i) {
            if (i + 1 < steps.size())
                held[i % 2] = std::max(held[i % 2], steps[i].rowCount() * paddedLength(length));
            ofStep = std::max(ofStep, ChainSteps::roomFor(steps[i], length, i > 0));
        }
    }

    std::size_t bytes() const { return roomOf<Real>(held[0]) + roomOf<Real>(held[1]) + ofStep; }
};

template <class Real, class Step>
void evaluateInTurn(std::span<const Step> steps, Workspace& workspace, Values<Real> source,
                    const BufferDescriptor& sourceLayout, MutableValues<Real> destination,
                    const BufferDescriptor& destinationLayout, RowRange rows) {
    checkEvaluation(steps.back().rowCount(), steps.front().columnCount(), source.size(),
                    sourceLayout, destination.size(), destinationLayout, rows);
    const ChainRoom<Real> needed(steps, sourceLayout.length);
    Room room(workspace.reserve(needed.bytes()));
    const std::span<Real> held[] = {room.take<Real>(needed.held[0]),
                                    room.take<Real>(needed.held[1])};
    std::byte* const own = room.take<std::byte>(static_cast<Offset>(needed.ofStep)).data();
    // Between the tables, entries lie as the kernels want them.
    const BufferDescriptor between{0, sourceLayout.length, paddedLength(sourceLayout.length)};
    Values<Real> values = source;
    BufferDescriptor layout = sourceLayout;
    for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
        const auto next = held[i % 2].first(steps[i].rowCount() * between.stride);
        // Behind the components no numbers that happen to be slow: denormal ones.
        if (between.stride > between.length) std::fill(next.begin(), next.end(), Real{0});
        ChainSteps::evaluate(steps[i], own, values, layout, next, between,
                             RowRange{0, steps[i].rowCount()});
        values = next;
        layout = between;
    }
    ChainSteps::evaluate(steps.back(), own, values, layout, destination, destinationLayout, rows);
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
Workspace CompiledChain<Real>::workspace(Offset length) const {
    checkLength(length);
    return Workspace(ChainRoom<Real>(std::span(steps_), length).bytes());
}

template <class Real>
void CompiledChain<Real>::evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                                   MutableValues<Real> destination,
                                   const BufferDescriptor& destinationLayout, RowRange rows) const {
    Workspace workspace;
    evaluate(source, sourceLayout, destination, destinationLayout, rows, workspace);
}

template <class Real>
void CompiledChain<Real>::evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                                   MutableValues<Real> destination,
                                   const BufferDescriptor& destinationLayout, RowRange rows,
                                   Workspace& workspace) const {
    evaluateInTurn<Real>(std::span(steps_), workspace, source, sourceLayout, destination,
                         destinationLayout, rows);
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
Workspace CompiledAdjointChain<Real>::workspace(Offset length) const {
    checkLength(length);
    return Workspace(ChainRoom<Real>(std::span(steps_), length).bytes());
}

template <class Real>
void CompiledAdjointChain<Real>::evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                                          MutableValues<Real> destination,
                                          const BufferDescriptor& destinationLayout,
                                          RowRange rows) const {
    Workspace workspace;
    evaluate(source, sourceLayout, destination, destinationLayout, rows, workspace);
}

template <class Real>
void CompiledAdjointChain<Real>::evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                                          MutableValues<Real> destination,
                                          const BufferDescriptor& destinationLayout, RowRange rows,
                                          Workspace& workspace) const {
    evaluateInTurn<Real>(std::span(steps_), workspace, source, sourceLayout, destination,
                         destinationLayout, rows);
}

template class CompiledChain<float>;
template class CompiledChain<double>;
template class CompiledAdjointChain<float>;
template class CompiledAdjointChain<double>;

}  // namespace espalier::osd
