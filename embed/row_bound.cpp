// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/row_bound.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace espalier::embed {
namespace {

double absoluteSum(std::span<const double> weights) {
    double sum = 0;
    for (const double weight : weights) sum += std::abs(weight);
    return sum;
}

/// Returns the rows for which isUnbounded(row) is true, ascending.
template <class IsUnbounded>
std::vector<Index> rowsThatAre(Index rowCount, IsUnbounded isUnbounded) {
    Array<std::uint8_t> flags(rowCount);
    parallelFor(rowCount, 4096, [&](Offset first, Offset last) {
        for (Offset row = first; row < last; ++row)
            flags[row] = isUnbounded(static_cast<Index>(row));
    });
    std::vector<Index> rows;
    for (Index row = 0; row < rowCount; ++row)
        if (flags[row]) rows.push_back(row);
    return rows;
}

}  // namespace

std::vector<Index> unboundedRows(const stencils::StencilTable<double>& table) {
    return rowsThatAre(table.rowCount(), [&](Index row) {
        // A weight that is not finite makes the comparison false.
        return !(absoluteSum(table.weights(row)) <= kMaxRowSum);
    });
}

stencils::StencilTable<double> emptyRows(stencils::StencilTable<double> table,
                                         std::span<const Index> rows) {
    if (rows.empty()) return table;
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    for (Index row = 0; row < table.rowCount(); ++row) {
        if (rows.empty() || rows.front() != row) {
            columns.insert(columns.end(), table.columns(row).begin(), table.columns(row).end());
            weights.insert(weights.end(), table.weights(row).begin(), table.weights(row).end());
        } else {
            rows = rows.subspan(1);
        }
        offsets.push_back(std::ssize(columns));
    }
    return {stencils::Trusted{}, table.columnCount(), std::move(offsets), std::move(columns),
            std::move(weights)};
}

stencils::StencilTable<double> boundRows(stencils::StencilTable<double> table) {
    const std::vector<Index> rows = unboundedRows(table);
    return emptyRows(std::move(table), rows);
}

stencils::FactoredTable<double> boundRows(stencils::FactoredTable<double> table) {
    // |W S| is at most Σ |w| · Σ |s|. This bound is near 1 for points inside, and decides for them.
    Array<double> sums(table.vertices.rowCount());
    parallelFor(table.vertices.rowCount(), 4096, [&](Offset first, Offset last) {
        for (Offset row = first; row < last; ++row)
            sums[row] = absoluteSum(table.vertices.weights(static_cast<Index>(row)));
    });
    const std::vector<Index> open = rowsThatAre(table.rowCount(), [&](Index row) {
        double bound = 0;
        const auto columns = table.points.columns(row);
        const auto weights = table.points.weights(row);
        for (std::size_t k = 0; k < columns.size(); ++k)
            bound += std::abs(weights[k]) * sums[columns[k]];
        return !(bound <= kMaxRowSum);
    });
    if (open.empty()) return table;
    const auto rowsOfOpen =
        stencils::multiply(stencils::selectRows<double>(table.points, open), table.vertices);
    std::vector<Index> rows = unboundedRows(rowsOfOpen);
    for (Index& row : rows) row = open[row];
    table.points = emptyRows(std::move(table.points), rows);
    return table;
}

}  // namespace espalier::embed
