// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "weighted_binding.h"

namespace espalier::bind {
namespace {

using embed::PointWeight;
using stencils::StencilTable;

/// Returns the rows, each times the weight of its point, and without entries where it is 0.
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

/// Returns the rows of the gradients for one coordinate at rest: w G + ∂w · D. They stay empty
/// where G is, as for points that have a place.
StencilTable<double> weightedGradient(const StencilTable<double>& gradient,
                                      const StencilTable<double>& table, std::size_t coordinate,
                                      std::span<const PointWeight> weights) {
    return stencils::buildTable(
        gradient.rowCount(), gradient.columnCount(),
        [&](Index row, stencils::RowAccumulator& accumulator) {
            const auto& [weight, slope] = weights[row];
            if (!(weight > 0) || gradient.columns(row).empty()) return;
            const auto add = [&](const StencilTable<double>& rows, double factor) {
                if (factor == 0) return;
                for (std::size_t k = 0; k < rows.columns(row).size(); ++k)
                    accumulator.add(rows.columns(row)[k], factor * rows.weights(row)[k]);
            };
            add(gradient, weight);
            add(table, slope[coordinate]);
        });
}

/// Returns the rows with empty ones between them.
StencilTable<double> spread(const StencilTable<double>& table, std::span<const Index> numbers,
                            Index rowCount) {
    Array<Offset> offsets(Offset{rowCount} + 1, 0);
    for (std::size_t i = 0; i < numbers.size(); ++i)
        offsets[numbers[i] + 1] = std::ssize(table.columns(static_cast<Index>(i)));
    for (Index row = 0; row < rowCount; ++row) offsets[row + 1] += offsets[row];
    return {stencils::Trusted{}, table.columnCount(), std::move(offsets),
            Array<Index>(table.columns().begin(), table.columns().end()),
            Array<double>(table.weights().begin(), table.weights().end())};
}

/// The same for a list with an entry for each row.
template <class T>
std::vector<T> spread(const std::vector<T>& entries, std::span<const Index> numbers, Index rowCount,
                      const T& between) {
    std::vector<T> all(rowCount, between);
    for (std::size_t i = 0; i < numbers.size(); ++i) all[numbers[i]] = entries[i];
    return all;
}

}  // namespace

void applyWeights(std::span<const PointWeight> weights, Binding& binding) {
    if (binding.gradients) {
        auto& [tables, splines] = *binding.gradients;
        for (std::size_t j = 0; j < 3; ++j)
            tables[j] = weightedGradient(tables[j], binding.table, j, weights);
        bool needsWeights = false;
        for (std::size_t i = 0; i < splines.places.size(); ++i) {
            if (splines.places[i].patch == kMaxIndex) continue;
            needsWeights = needsWeights || weights[i] != PointWeight();
            if (!(weights[i].value > 0)) splines.places[i] = {};
        }
        if (needsWeights) splines.weights.assign(weights.begin(), weights.end());
    }
    for (std::size_t i = 0; i < weights.size(); ++i)
        if (!(weights[i].value > 0)) binding.statuses[i] = embed::PointStatus::NotBound;
    binding.table = weighted(binding.table, weights);
    if (binding.factors) binding.factors->points = weighted(binding.factors->points, weights);
}

void addKeptPoints(std::span<const Index> numbers, Index pointCount, Binding& binding) {
    binding.table = spread(binding.table, numbers, pointCount);
    if (binding.factors)
        binding.factors->points = spread(binding.factors->points, numbers, pointCount);
    if (binding.gradients) {
        auto& [tables, splines] = *binding.gradients;
        for (auto& table : tables) table = spread(table, numbers, pointCount);
        if (!splines.places.empty()) {
            splines.places = spread(splines.places, numbers, pointCount, {});
            if (!splines.weights.empty())
                splines.weights = spread(splines.weights, numbers, pointCount, PointWeight{0});
        }
    }
    binding.statuses = spread(binding.statuses, numbers, pointCount, embed::PointStatus::NotBound);
}

}  // namespace espalier::bind
