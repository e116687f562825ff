// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/embed/gradient_rows.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "weighted_binding.h"

namespace espalier::bind {
namespace {

using stencils::StencilTable;

/// Returns the rows with empty ones between them.
StencilTable<double> spread(const StencilTable<double>& table, std::span<const Index> numbers,
                            Index pointCount) {
    Array<Offset> offsets(Offset{pointCount} + 1, 0);
    for (std::size_t i = 0; i < numbers.size(); ++i)
        offsets[numbers[i] + 1] = std::ssize(table.columns(static_cast<Index>(i)));
    for (Index row = 0; row < pointCount; ++row) offsets[row + 1] += offsets[row];
    return {stencils::Trusted{}, table.columnCount(), std::move(offsets),
            Array<Index>(table.columns().begin(), table.columns().end()),
            Array<double>(table.weights().begin(), table.weights().end())};
}

/// The same for a list with an entry for each point.
template <class T>
std::vector<T> spread(const std::vector<T>& entries, std::span<const Index> numbers,
                      Index pointCount, const T& between) {
    std::vector<T> all(pointCount, between);
    for (std::size_t i = 0; i < numbers.size(); ++i) all[numbers[i]] = entries[i];
    return all;
}

}  // namespace

StencilTable<double> weighted(const StencilTable<double>& table,
                              std::span<const PointWeight> weights) {
    Array<Offset> offsets(Offset{table.rowCount()} + 1);
    offsets[0] = 0;
    for (Index row = 0; row < table.rowCount(); ++row)
        offsets[row + 1] = weights[row].value > 0 ? std::ssize(table.columns(row)) : 0;
    Array<Index> columns;
    Array<double> products;
    stencils::allocateEntries(offsets, columns, products);
    parallelFor(table.rowCount(), stencils::kRowsPerChunk, [&](Offset first, Offset last) {
        for (auto row = static_cast<Index>(first); row < last; ++row) {
            const double weight = weights[row].value;
            if (!(weight > 0)) continue;
            std::ranges::copy(table.columns(row), columns.begin() + offsets[row]);
            auto next = products.begin() + offsets[row];
            for (const double each : table.weights(row)) *next++ = weight * each;
        }
    });
    return {stencils::Trusted{}, table.columnCount(), std::move(offsets), std::move(columns),
            std::move(products)};
}

void applyWeights(std::vector<PointWeight> weights, WeightedRows& rows) {
    std::vector<Index> kept;
    for (std::size_t i = 0; i < weights.size(); ++i)
        if (!(weights[i].value > 0)) kept.push_back(static_cast<Index>(i));
    for (const Index point : kept) rows.statuses[point] = embed::PointStatus::NotBound;
    rows.table = weighted(rows.table, weights);
    if (!rows.gradients) return;
    rows.gradients = embed::withoutPoints(std::move(*rows.gradients), kept);
    const auto isFull = [](const PointWeight& weight) { return weight == PointWeight(); };
    if (!std::ranges::all_of(weights, isFull)) rows.weights = std::move(weights);
}

void addKeptPoints(std::span<const Index> numbers, Index pointCount, Binding& binding) {
    binding.table = spread(binding.table, numbers, pointCount);
    if (binding.factors)
        binding.factors->points = spread(binding.factors->points, numbers, pointCount);
    if (binding.gradients)
        binding.gradients = embed::renumbered(std::move(*binding.gradients), numbers);
    if (!binding.weights.empty())
        binding.weights = spread(binding.weights, numbers, pointCount, PointWeight{0, {}});
    binding.statuses = spread(binding.statuses, numbers, pointCount, embed::PointStatus::NotBound);
}

}  // namespace espalier::bind
