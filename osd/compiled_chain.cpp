// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/padding.h>

#include <string>
#include <utility>

namespace espalier::osd {

template <class Real>
CompiledChain<Real>::CompiledChain(std::span<const stencils::StencilTable<Real>> tables,
                                   Simd simd) {
    if (tables.empty()) throw Error("a chain needs at least one table");
    for (std::size_t i = 0; i < tables.size(); ++i) {
        if (i > 0 && tables[i].columnCount() != tables[i - 1].rowCount())
            throw Error("table " + std::to_string(i + 1) + " of the chain has " +
                        std::to_string(tables[i].columnCount()) + " columns; the one before has " +
                        std::to_string(tables[i - 1].rowCount()) + " rows");
        steps_.emplace_back(tables[i], simd);
    }
}

template <class Real>
CompiledChain<Real>::CompiledChain(const stencils::FactoredTable<Real>& table, Simd simd) {
    if (table.points.columnCount() != table.vertices.rowCount())
        throw Error("the points are of " + std::to_string(table.points.columnCount()) +
                    " vertices; the table of these has " +
                    std::to_string(table.vertices.rowCount()));
    steps_.emplace_back(table.vertices, simd);
    steps_.emplace_back(table.points, simd);
}

template <class Real>
std::size_t CompiledChain<Real>::byteCount() const {
    std::size_t bytes = 0;
    for (const CompiledTable<Real>& step : steps_) bytes += step.byteCount();
    return bytes;
}

template <class Real>
void CompiledChain<Real>::evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                                   MutableValues<Real> destination,
                                   const BufferDescriptor& destinationLayout, RowRange rows) const {
    checkEvaluation(rowCount(), columnCount(), source.size(), sourceLayout, destination.size(),
                    destinationLayout, rows);
    // Between the tables, entries lie as the kernels want them.
    const BufferDescriptor between{0, sourceLayout.length, paddedLength(sourceLayout.length)};
    Values<Real> values = source;
    BufferDescriptor layout = sourceLayout;
    AlignedVector<Real> held;
    for (const CompiledTable<Real>& step : std::span(steps_).first(steps_.size() - 1)) {
        AlignedVector<Real> next(static_cast<std::size_t>(step.rowCount() * between.stride));
        step.evaluate(values, layout, next, between, {0, step.rowCount()});
        held = std::move(next);
        values = held;
        layout = between;
    }
    steps_.back().evaluate(values, layout, destination, destinationLayout, rows);
}

template class CompiledChain<float>;
template class CompiledChain<double>;

}  // namespace espalier::osd
