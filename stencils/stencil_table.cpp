// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>
#include <espalier/stencils/stencil_table.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace espalier::stencils {

template <class Real>
StencilTable<Real>::StencilTable(Trusted, Index columnCount, Array<Offset> offsets,
                                 Array<Index> columns, Array<Real> weights)
    : columnCount_(columnCount),
      offsets_(std::move(offsets)),
      columns_(std::move(columns)),
      weights_(std::move(weights)) {}

template <class Real>
StencilTable<Real>::StencilTable(Index columnCount, Array<Offset> offsets, Array<Index> columns,
                                 Array<Real> weights)
    : StencilTable(Trusted{}, columnCount, std::move(offsets), std::move(columns),
                   std::move(weights)) {
    const auto entries = static_cast<Offset>(columns_.size());
    if (columnCount_ < 0 || offsets_.empty() || offsets_.front() != 0 ||
        offsets_.back() != entries || weights_.size() != columns_.size() ||
        std::ssize(offsets_) - 1 > kMaxIndex)
        throw Error("a table of " + std::to_string(offsets_.size()) + " offsets, " +
                    std::to_string(entries) + " columns and " + std::to_string(weights_.size()) +
                    " weights is not in compressed sparse rows");
    for (std::size_t row = 0; row + 1 < offsets_.size(); ++row) {
        const auto refuse = [&](const char* why) {
            throw Error("row " + std::to_string(row) + " of the table " + why);
        };
        if (offsets_[row] > offsets_[row + 1] || offsets_[row + 1] > entries)
            refuse("has offsets out of order");
        for (Offset i = offsets_[row]; i < offsets_[row + 1]; ++i) {
            const Index column = columns_[i];
            if (column < 0 || column >= columnCount_) refuse("names a column that does not exist");
            if (i > offsets_[row] && column <= columns_[i - 1])
                refuse("has columns that do not ascend");
        }
    }
}

namespace {

template <class To, class From>
Array<To> rounded(std::span<const From> weights) {
    Array<To> result(weights.size());
    std::transform(weights.begin(), weights.end(), result.begin(),
                   [](From weight) { return static_cast<To>(weight); });
    return result;
}

}  // namespace

template <class To, class From>
StencilTable<To> convertTable(const StencilTable<From>& table) {
    return {Trusted{},
            table.columnCount(),
            {table.offsets().begin(), table.offsets().end()},
            {table.columns().begin(), table.columns().end()},
            rounded<To>(table.weights())};
}

template <class To, class From>
StencilTable<To> convertTable(StencilTable<From>&& table) {
    Array<To> weights;
    if constexpr (std::is_same_v<To, From>)
        weights = std::move(table.weights_);
    else
        weights = rounded<To>(std::as_const(table).weights());
    return {Trusted{}, table.columnCount_, std::move(table.offsets_), std::move(table.columns_),
            std::move(weights)};
}

template <class Real>
StencilTable<Real> transposeTable(const StencilTable<Real>& table) {
    Array<Offset> offsets(Offset{table.columnCount()} + 1, 0);
    for (const Index column : table.columns()) ++offsets[column + 1];
    std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
    std::vector<Offset> next(offsets.begin(), offsets.end() - 1);
    Array<Index> rows(table.columns().size());
    Array<Real> weights(rows.size());
    for (Index row = 0; row < table.rowCount(); ++row) {
        const auto columns = table.columns(row);
        for (std::size_t k = 0; k < columns.size(); ++k) {
            const Offset to = next[columns[k]]++;
            rows[to] = row;
            weights[to] = table.weights(row)[k];
        }
    }
    return StencilTable<Real>(Trusted{}, table.rowCount(), std::move(offsets), std::move(rows),
                              std::move(weights));
}

namespace {

/// Copies rows of other tables: sourceOf(row) returns the table and the row in it.
template <class Real, class SourceOf>
StencilTable<Real> copyRows(Index rowCount, Index columnCount, SourceOf sourceOf) {
    Array<Offset> offsets(Offset{rowCount} + 1);
    offsets[0] = 0;
    for (Index i = 0; i < rowCount; ++i) {
        const auto& [table, row] = sourceOf(i);
        offsets[i + 1] = offsets[i] + static_cast<Offset>(table->columns(row).size());
    }
    requireMemory(static_cast<std::uint64_t>(offsets.back()) * (sizeof(Index) + sizeof(Real)),
                  "a table of " + std::to_string(offsets.back()) + " weights");
    Array<Index> columns(offsets.back());
    Array<Real> weights(columns.size());
    parallelFor(rowCount, 4096, [&](Offset first, Offset last) {
        for (auto i = static_cast<Index>(first); i < last; ++i) {
            const auto& [table, row] = sourceOf(i);
            std::ranges::copy(table->columns(row), columns.begin() + offsets[i]);
            std::ranges::copy(table->weights(row), weights.begin() + offsets[i]);
        }
    });
    return {Trusted{}, columnCount, std::move(offsets), std::move(columns), std::move(weights)};
}

}  // namespace

template <class Real>
StencilTable<Real> selectRows(const StencilTable<Real>& table, std::span<const Index> rows) {
    return copyRows<Real>(static_cast<Index>(rows.size()), table.columnCount(),
                          [&](Index i) { return std::pair(&table, rows[i]); });
}

template <class Real>
StencilTable<Real> interleaveRows(const std::vector<const StencilTable<Real>*>& tables) {
    if (tables.empty()) throw Error("there are no tables to interleave");
    const Index rowCount = tables.front()->rowCount();
    const Index columnCount = tables.front()->columnCount();
    const auto size = [](const StencilTable<Real>& table) {
        return std::to_string(table.rowCount()) + " × " + std::to_string(table.columnCount());
    };
    for (std::size_t t = 1; t < tables.size(); ++t)
        if (tables[t]->rowCount() != rowCount || tables[t]->columnCount() != columnCount)
            throw Error("table " + std::to_string(t) + " is " + size(*tables[t]) +
                        ", but table 0 is " + size(*tables[0]) +
                        "; tables that are interleaved have the same size");
    const auto count = static_cast<Offset>(tables.size());
    if (rowCount * count > kMaxIndex)
        throw Error(std::to_string(count) + " tables of " + std::to_string(rowCount) +
                    " rows are too many rows for one");
    return copyRows<Real>(static_cast<Index>(rowCount * count), columnCount, [&](Index i) {
        return std::pair(tables[i % count], static_cast<Index>(i / count));
    });
}

template class StencilTable<float>;
template class StencilTable<double>;
template StencilTable<float> convertTable(const StencilTable<double>&);
template StencilTable<double> convertTable(const StencilTable<double>&);
template StencilTable<double> convertTable(const StencilTable<float>&);
template StencilTable<float> convertTable(StencilTable<double>&&);
template StencilTable<double> convertTable(StencilTable<double>&&);
template StencilTable<double> convertTable(StencilTable<float>&&);
template StencilTable<float> transposeTable(const StencilTable<float>&);
template StencilTable<double> transposeTable(const StencilTable<double>&);
template StencilTable<float> selectRows(const StencilTable<float>&, std::span<const Index>);
template StencilTable<double> selectRows(const StencilTable<double>&, std::span<const Index>);
template StencilTable<float> interleaveRows(const std::vector<const StencilTable<float>*>&);
template StencilTable<double> interleaveRows(const std::vector<const StencilTable<double>*>&);

}  // namespace espalier::stencils
