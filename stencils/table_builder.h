// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/parallel.h>
#include <espalier/stencils/stencil_table.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace espalier::stencils {

/// A row under construction: weights are added to columns in any order, and come out ascending.
/// Sums are made in double, in the order of the calls.
class RowAccumulator {
public:
    explicit RowAccumulator(Index columnCount)
        : sums_(static_cast<std::size_t>(columnCount), 0),
          isTouched_(static_cast<std::size_t>(columnCount), 0) {}

    void add(Index column, double weight) {
        const auto at = static_cast<std::size_t>(column);
        if (!isTouched_[at]) {
            isTouched_[at] = 1;
            touched_.push_back(column);
        }
        sums_[at] += weight;
    }

    /// Appends the row to the two arrays and starts a new one. Sums that cancelled to exactly 0 are
    /// left out.
    template <class Real>
    void flush(std::vector<Index>& columns, std::vector<Real>& weights) {
        std::sort(touched_.begin(), touched_.end());
        for (const Index column : touched_) {
            const auto at = static_cast<std::size_t>(column);
            if (sums_[at] != 0) {
                columns.push_back(column);
                weights.push_back(static_cast<Real>(sums_[at]));
            }
            sums_[at] = 0;
            isTouched_[at] = 0;
        }
        touched_.clear();
    }

private:
    std::vector<double> sums_;
    std::vector<char> isTouched_;
    std::vector<Index> touched_;
};

/// Accumulators that have done their chunk, for the next one: as many as there are threads at work.
class AccumulatorPool {
public:
    explicit AccumulatorPool(Index columnCount) : columnCount_(columnCount) {}

    std::unique_ptr<RowAccumulator> take() {
        const std::lock_guard lock(mutex_);
        if (free_.empty()) return std::make_unique<RowAccumulator>(columnCount_);
        auto accumulator = std::move(free_.back());
        free_.pop_back();
        return accumulator;
    }

    void giveBack(std::unique_ptr<RowAccumulator> accumulator) {
        const std::lock_guard lock(mutex_);
        free_.push_back(std::move(accumulator));
    }

private:
    Index columnCount_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<RowAccumulator>> free_;
};

/// Builds a table row by row, in parallel: fill(row, accumulator) adds the weights of `row`.
/// The result does not depend on the number of threads.
template <class Real, class Fill>
StencilTable<Real> buildTable(Index rowCount, Index columnCount, Fill fill) {
    constexpr Offset kGrain = 4096;
    struct Chunk {
        std::vector<Index> columns;
        std::vector<Real> weights;
    };
    std::vector<Chunk> chunks(static_cast<std::size_t>((Offset{rowCount} + kGrain - 1) / kGrain));
    std::vector<Offset> offsets(static_cast<std::size_t>(rowCount) + 1, 0);
    AccumulatorPool pool(columnCount);
    far::parallelFor(rowCount, kGrain, [&](Offset first, Offset last) {
        Chunk& chunk = chunks[static_cast<std::size_t>(first / kGrain)];
        std::unique_ptr<RowAccumulator> accumulator = pool.take();
        for (Offset row = first; row < last; ++row) {
            fill(static_cast<Index>(row), *accumulator);
            accumulator->flush(chunk.columns, chunk.weights);
            offsets[static_cast<std::size_t>(row) + 1] = static_cast<Offset>(chunk.columns.size());
        }
        pool.giveBack(std::move(accumulator));
    });

    // Offsets count from the start of their chunk so far; shift each chunk behind the one before.
    Offset shift = 0;
    for (Offset row = 0; row < rowCount; ++row) {
        if (row % kGrain == 0) shift = offsets[static_cast<std::size_t>(row)];
        offsets[static_cast<std::size_t>(row) + 1] += shift;
    }
    std::vector<Index> columns(static_cast<std::size_t>(offsets.back()));
    std::vector<Real> weights(columns.size());
    far::parallelFor(rowCount, kGrain, [&](Offset first, Offset) {
        Chunk& chunk = chunks[static_cast<std::size_t>(first / kGrain)];
        const Offset at = offsets[static_cast<std::size_t>(first)];
        std::copy(chunk.columns.begin(), chunk.columns.end(), columns.begin() + at);
        std::copy(chunk.weights.begin(), chunk.weights.end(), weights.begin() + at);
        chunk = {};
    });
    return StencilTable<Real>(columnCount, std::move(offsets), std::move(columns),
                              std::move(weights));
}

}  // namespace espalier::stencils
