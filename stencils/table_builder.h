// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>
#include <espalier/stencils/stencil_table.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace espalier::stencils {

/// Rows under construction, in order.
struct RowList {
    Array<Index> columns;
    Array<double> weights;
    Array<Offset> ends;  ///< one per row

    void clear() {
        columns.clear();
        weights.clear();
        ends.clear();
    }

    void endRow() { ends.push_back(static_cast<Offset>(columns.size())); }

    /// Appends a row.
    /// \param entries column and weight of each entry, with ascending columns
    template <class Entries>
    void appendRow(const Entries& entries) {
        std::size_t at = columns.size();
        columns.resize(at + entries.size());
        weights.resize(at + entries.size());
        for (const auto& [column, weight] : entries) {
            columns[at] = column;
            weights[at++] = weight;
        }
        endRow();
    }
};

/// A pool of working memory for threads. A thread takes an item for a chunk and gives it back, so
/// there are at most as many items as threads at work.
template <class T>
class Pool {
public:
    template <class Make>
    std::unique_ptr<T> take(Make make) {
        const std::lock_guard lock(mutex_);
        if (free_.empty()) return make();
        auto item = std::move(free_.back());
        free_.pop_back();
        return item;
    }

    void giveBack(std::unique_ptr<T> item) {
        const std::lock_guard lock(mutex_);
        free_.push_back(std::move(item));
    }

private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<T>> free_;
};

/// The number of rows that are built at a time.
inline constexpr Offset kRowsPerChunk = 4096;

/// Allocates the entries of a table.
/// \param offsets first the length of each row; their running sum is made here
inline void allocateEntries(Array<Offset>& offsets, Array<Index>& columns, Array<double>& weights) {
    std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
    requireMemory(static_cast<std::uint64_t>(offsets.back()) * (sizeof(Index) + sizeof(double)),
                  "a table of " + std::to_string(offsets.back()) + " weights");
    columns.resize(offsets.back());
    weights.resize(offsets.back());
}

/// Builds a table in parallel: fill(first, last, rows) appends the rows first to last − 1.
///
/// The result does not depend on the number of threads. Needs twice the memory of the result.
template <class Fill>
StencilTable<double> buildTableByChunks(Index rowCount, Index columnCount, Fill fill) {
    std::vector<RowList> chunks((Offset{rowCount} + kRowsPerChunk - 1) / kRowsPerChunk);
    // First the length of each row, then their running sum.
    Array<Offset> offsets(Offset{rowCount} + 1);
    offsets[0] = 0;
    parallelFor(rowCount, kRowsPerChunk, [&](Offset first, Offset last) {
        RowList& chunk = chunks[first / kRowsPerChunk];
        fill(first, last, chunk);
        Offset begin = 0;
        for (Offset row = first; row < last; ++row) {
            const Offset end = chunk.ends[row - first];
            offsets[row + 1] = end - std::exchange(begin, end);
        }
    });
    Array<Index> columns;
    Array<double> weights;
    if (chunks.size() == 1) {
        // The arrays become the table. Memory that they reserved too much is given back, unless it
        // is less than an eighth.
        std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
        RowList& all = chunks.front();
        if (all.columns.capacity() > all.columns.size() / 8 * 9) {
            all.columns.shrink_to_fit();
            all.weights.shrink_to_fit();
        }
        return StencilTable<double>(Trusted{}, columnCount, std::move(offsets),
                                    std::move(all.columns), std::move(all.weights));
    }

    allocateEntries(offsets, columns, weights);
    parallelFor(rowCount, kRowsPerChunk, [&](Offset first, Offset) {
        RowList& chunk = chunks[first / kRowsPerChunk];
        std::ranges::copy(chunk.columns, columns.begin() + offsets[first]);
        std::ranges::copy(chunk.weights, weights.begin() + offsets[first]);
        chunk = {};
    });
    return StencilTable<double>(Trusted{}, columnCount, std::move(offsets), std::move(columns),
                                std::move(weights));
}

/// The same without more memory than the result: fill() is called twice for the same rows, first to
/// count their entries.
template <class Fill>
StencilTable<double> buildTableInPlace(Index rowCount, Index columnCount, Fill fill) {
    if (rowCount <= kRowsPerChunk) return buildTableByChunks(rowCount, columnCount, fill);
    Pool<RowList> pool;
    const auto forEachChunk = [&](auto use) {
        parallelFor(rowCount, kRowsPerChunk, [&](Offset first, Offset last) {
            auto rows = pool.take([] { return std::make_unique<RowList>(); });
            fill(first, last, *rows);
            use(first, *rows);
            rows->clear();
            pool.giveBack(std::move(rows));
        });
    };
    Array<Offset> offsets(Offset{rowCount} + 1);
    offsets[0] = 0;
    forEachChunk([&](Offset first, const RowList& rows) {
        std::adjacent_difference(rows.ends.begin(), rows.ends.end(), offsets.begin() + first + 1);
    });
    Array<Index> columns;
    Array<double> weights;
    allocateEntries(offsets, columns, weights);
    forEachChunk([&](Offset first, const RowList& rows) {
        std::ranges::copy(rows.columns, columns.begin() + offsets[first]);
        std::ranges::copy(rows.weights, weights.begin() + offsets[first]);
    });
    return StencilTable<double>(Trusted{}, columnCount, std::move(offsets), std::move(columns),
                                std::move(weights));
}

/// Returns a table with other numbers of the columns.
/// \param numberOf numberOf(column) ascends with the column
template <class NumberOf>
StencilTable<double> renumberColumns(const StencilTable<double>& table, Index columnCount,
                                     NumberOf numberOf) {
    Array<Index> columns(table.columns().size());
    std::transform(table.columns().begin(), table.columns().end(), columns.begin(), numberOf);
    return {Trusted{},
            columnCount,
            {table.offsets().begin(), table.offsets().end()},
            std::move(columns),
            {table.weights().begin(), table.weights().end()}};
}

/// A row under construction. Weights may be added to columns in any order; the finished row is
/// ascending. Weights of the same column are summed in the order of the calls.
class RowAccumulator {
public:
    explicit RowAccumulator(Index columnCount)
        : sums_(columnCount, 0), isTouched_(columnCount, 0) {}

    void add(Index column, double weight) {
        const std::size_t at = column;
        if (!isTouched_[at]) {
            isTouched_[at] = 1;
            touched_.push_back(column);
        }
        sums_[at] += weight;
    }

    /// Subtracts the sum of the row from its largest weight. The row then sums to 0, up to the
    /// rounding of that weight.
    ///
    /// Derivatives shrink with each level on the way to the base, but an error of their sum does
    /// not: without this correction, it would exceed them.
    void makeSumZero() {
        if (touched_.empty()) return;
        std::sort(touched_.begin(), touched_.end());  // So the sum does not depend on the order of
                                                      // calls.
        double sum = 0;
        Index largest = touched_.front();
        for (const Index column : touched_) {
            sum += sums_[column];
            if (std::abs(sums_[column]) > std::abs(sums_[largest])) largest = column;
        }
        sums_[largest] -= sum;
    }

    /// Ends the row, and starts a new one. Omits sums that are exactly 0.
    void flush(RowList& rows) {
        if (!std::is_sorted(touched_.begin(), touched_.end()))
            std::sort(touched_.begin(), touched_.end());
        std::size_t end = rows.columns.size();
        rows.columns.resize(end + touched_.size());
        rows.weights.resize(end + touched_.size());
        for (const Index column : touched_) {
            rows.columns[end] = column;
            rows.weights[end] = sums_[column];
            end += sums_[column] != 0;
            sums_[column] = 0;
            isTouched_[column] = 0;
        }
        rows.columns.resize(end);
        rows.weights.resize(end);
        touched_.clear();
        rows.endRow();
    }

private:
    std::vector<double> sums_;
    std::vector<char> isTouched_;
    std::vector<Index> touched_;
};

/// Builds a table row by row, in parallel: fill(row, accumulator) adds the weights of `row`.
template <class Fill>
StencilTable<double> buildTable(Index rowCount, Index columnCount, Fill fill) {
    Pool<RowAccumulator> pool;
    return buildTableByChunks(rowCount, columnCount, [&](Offset first, Offset last, RowList& rows) {
        auto accumulator = pool.take([&] { return std::make_unique<RowAccumulator>(columnCount); });
        for (Offset row = first; row < last; ++row) {
            fill(static_cast<Index>(row), *accumulator);
            accumulator->flush(rows);
        }
        pool.giveBack(std::move(accumulator));
    });
}

}  // namespace espalier::stencils
