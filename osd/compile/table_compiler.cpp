// SPDX-License-Identifier: Apache-2.0
#include "table_compiler.h"

#include <espalier/base/cancellable_sort.h>
#include <espalier/base/parallel.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "number_bits.h"
#include "row_sets.h"
#include "shared_numbers.h"
#include "superset_form.h"

namespace espalier::osd {
namespace {

using kernels::kLanes;
using stencils::StencilTable;

/// Maximum number of rows in a run. One thread evaluates a run.
constexpr std::ptrdiff_t kMaxRowsPerRun = 4096;

/// Minimum number of rows with the same weights that get a run of their own.
constexpr std::ptrdiff_t kMinSharedRows = 16;

/// Collects runs. Their columns and weights are stored at the end, when their count is known.
template <class Real>
class RunList {
public:
    RunList(const StencilTable<Real>& table, CompiledRows<Real>& compiled)
        : table_(table), compiled_(compiled) {}

    /// Adds rows of equal length.
    /// \param isShared true if all of them have the same weights
    void add(std::span<const Index> rows, bool isShared) {
        const auto length = static_cast<Index>(table_.columns(rows.front()).size());
        const Offset firstWeight = weightCount_;
        if (isShared) weightCount_ += length;
        while (!rows.empty()) {
            const auto part = rows.first(std::min(std::ssize(rows), kMaxRowsPerRun));
            compiled_.runs.push_back({length, columnCount_, isShared ? firstWeight : weightCount_,
                                      isShared, static_cast<Offset>(compiled_.rows.size()),
                                      static_cast<Index>(part.size())});
            compiled_.rows.insert(compiled_.rows.end(), part.begin(), part.end());
            columnCount_ += std::ssize(part) * length;
            if (!isShared) weightCount_ += std::ssize(part) * length;
            rows = rows.subspan(part.size());
        }
    }

    void storeColumnsAndWeights() {
        compiled_.columns.resize(columnCount_);
        compiled_.weights.resize(weightCount_);
        parallelFor(std::ssize(compiled_.runs), 1, [&](Offset r, Offset) {
            const auto& run = compiled_.runs[r];
            auto column = compiled_.columns.begin() + run.firstColumn;
            auto weight = compiled_.weights.begin() + run.firstWeight;
            for (Index i = 0; i < run.rowCount; ++i) {
                const Index row = compiled_.rows[run.firstRow + i];
                const auto columns = table_.columns(row);
                column = std::copy(columns.begin(), columns.end(), column);
                // All parts of a shared run have the same weights; the first part stores them.
                if (run.isShared && (i > 0 || !isFirstOf(r))) continue;
                const auto weights = table_.weights(row);
                weight = std::copy(weights.begin(), weights.end(), weight);
            }
        });
    }

private:
    /// Returns true unless the run before has the same weights.
    bool isFirstOf(Offset run) const {
        if (run == 0) return true;
        const auto &before = compiled_.runs[run - 1], &own = compiled_.runs[run];
        // The weights of a run of empty rows begin where those of the next run begin.
        return before.firstWeight != own.firstWeight || before.length != own.length;
    }

    const StencilTable<Real>& table_;
    CompiledRows<Real>& compiled_;
    Offset columnCount_ = 0, weightCount_ = 0;
};

/// Puts rows into runs of equal length, in which each row has its own columns. Rows with identical
/// weights, such as rows of the same mask, form runs of their own that store the weights once.
///
/// \param rows some rows of `table`
/// \param compiled gets the runs; it must have none yet
/// \cost O(entries + rows log rows)
template <class Real>
void addRuns(const StencilTable<Real>& table, std::vector<Index> rows,
             CompiledRows<Real>& compiled) {
    /// A row with the keys that it shares with rows of identical weights.
    struct Candidate {
        std::size_t length;
        std::uint64_t hash;
        Index row;
        auto operator<=>(const Candidate&) const = default;
    };
    std::vector<Candidate> candidates;
    candidates.reserve(rows.size());
    for (const Index row : rows)
        candidates.push_back({table.columns(row).size(), hashOf(table.weights(row)), row});
    sortCancellably(candidates.begin(), candidates.end());
    compiled.rows.reserve(rows.size());
    RunList<Real> runs(table, compiled);
    std::vector<Index> same, others;
    // For each length, first adds runs of identical weights, then one for the remaining rows.
    for (auto first = candidates.begin(); first != candidates.end();) {
        const auto last = std::find_if(first, candidates.end(), [&](const Candidate& other) {
            return other.length != first->length || other.hash != first->hash;
        });
        same.clear();
        // Rows with the same hash have the same weights, except in one case of 2^64.
        for (auto each = first; each != last; ++each)
            (std::ranges::equal(table.weights(each->row), table.weights(first->row)) ? same
                                                                                     : others)
                .push_back(each->row);
        if (std::ssize(same) >= kMinSharedRows)
            runs.add(same, true);
        else
            others.insert(others.end(), same.begin(), same.end());
        if (!others.empty() && (last == candidates.end() || last->length != first->length)) {
            std::sort(others.begin(), others.end());
            runs.add(others, false);
            others.clear();
        }
        first = last;
    }
    runs.storeColumnsAndWeights();
}

/// Approximate number of rows of a task. One thread evaluates a task.
constexpr Index kRowsPerTask = 4096;

/// Divides the supersets into blocks. One thread finds the forms of a block.
template <class Real>
std::vector<FormBlock<Real>> divide(const RowSets& sets) {
    constexpr std::size_t kRowsPerBlock = 1 << 14;
    std::vector<FormBlock<Real>> blocks;
    std::size_t rowCount = kRowsPerBlock;
    for (Index set = 0; set < sets.count(); ++set) {
        if (sets.subsetsOf(set).empty()) continue;
        if (rowCount >= kRowsPerBlock) {
            blocks.emplace_back();
            rowCount = 0;
        }
        blocks.back().supersets.push_back(set);
        for (const Index subset : sets.subsetsOf(set)) rowCount += sets.rowsOf(subset).size();
    }
    return blocks;
}

/// Where the groups of a block of supersets begin in a compiled table.
struct BlockStart {
    Offset group = 0, column = 0, row = 0, ungrouped = 0;
};

/// Returns the starts of all blocks, and the end of the last one.
template <class Real>
std::vector<BlockStart> startsOf(const std::vector<FormBlock<Real>>& blocks) {
    std::vector<BlockStart> starts(1);
    for (const FormBlock<Real>& block : blocks) {
        BlockStart next = starts.back();
        for (const Index f : block.formOf) {
            const auto& form = block.forms[f];
            next.group += std::ssize(form.groups);
            next.column += std::ssize(form.positions);
            next.row += std::ssize(form.slots);
            next.ungrouped += std::ssize(form.ungrouped);
        }
        starts.push_back(next);
    }
    return starts;
}

/// Writes the groups of a block of supersets to their slots in a compiled table.
template <class Real>
void addGroups(const StencilTable<Real>& table, const RowSets& sets, const FormBlock<Real>& block,
               BlockStart at, CompiledRows<Real>& compiled, std::span<Index> ungrouped) {
    Superset superset;
    for (std::size_t i = 0; i < block.supersets.size(); ++i) {
        const auto& form = block.forms[block.formOf[i]];
        superset.assign(sets, block.supersets[i]);
        for (const auto& group : form.groups) {
            Index lowest = table.rowCount(), highest = 0;
            const std::span slots(form.slots);
            for (const Index slot : slots.subspan(group.firstSlot, group.rowCount)) {
                lowest = std::min(lowest, superset.rows[slot]);
                highest = std::max(highest, superset.rows[slot]);
            }
            compiled.groups[at.group++] = {at.column + group.firstPosition,
                                           group.columnCount,
                                           group.firstNumber,
                                           at.row + group.firstSlot,
                                           group.rowCount,
                                           lowest,
                                           highest,
                                           group.size};
        }
        for (const Index position : form.positions)
            compiled.groupColumns[at.column++] = superset.columns[position];
        for (const Index slot : form.slots) compiled.groupRows[at.row++] = superset.rows[slot];
        for (const Index slot : form.ungrouped) ungrouped[at.ungrouped++] = superset.rows[slot];
    }
}

/// Divides the groups into tasks.
template <class Real>
void addTasks(CompiledRows<Real>& compiled) {
    Index rowCount = 0;
    for (std::size_t group = 0; group < compiled.groups.size(); ++group) {
        rowCount += compiled.groups[group].rowCount;
        if (rowCount < kRowsPerTask && group + 1 < compiled.groups.size()) continue;
        compiled.taskStarts.push_back(static_cast<Offset>(group) + 1);
        rowCount = 0;
    }
}

}  // namespace

template <class Real>
CompiledRows<Real> compileRows(const StencilTable<Real>& table, NumberOrder order, Simd simd) {
    const kernels::Kernels<Real>& kernels = kernels::kernelsFor<Real>(simd);
    CompiledRows<Real> compiled;
    const RowSets sets(table);
    std::vector<FormBlock<Real>> blocks = divide<Real>(sets);
    parallelFor(std::ssize(blocks), 1,
                [&](Offset block, Offset) { findForms(table, sets, kernels, blocks[block]); });
    storeNumbers(table, order, kernels, blocks, compiled.groupNumbers);
    const std::vector<BlockStart> starts = startsOf(blocks);
    compiled.groups.resize(starts.back().group);
    compiled.groupColumns.resize(starts.back().column);
    compiled.groupRows.resize(starts.back().row);
    std::vector<Index> ungrouped(starts.back().ungrouped);
    parallelFor(std::ssize(blocks), 1, [&](Offset block, Offset) {
        addGroups<Real>(table, sets, blocks[block], starts[block], compiled, ungrouped);
    });
    addRuns(table, std::move(ungrouped), compiled);
    addTasks(compiled);
    return compiled;
}

template <class Real>
StencilTable<Real> rowsOnly(const StencilTable<Real>& table, std::span<const Index> rows) {
    std::vector<char> isSelected(table.rowCount(), 0);
    for (const Index row : rows) isSelected[row] = 1;
    Array<Offset> offsets(Offset{table.rowCount()} + 1);
    offsets[0] = 0;
    Array<Index> columns;
    Array<Real> weights;
    for (Index row = 0; row < table.rowCount(); ++row) {
        if (isSelected[row]) {
            columns.insert(columns.end(), table.columns(row).begin(), table.columns(row).end());
            weights.insert(weights.end(), table.weights(row).begin(), table.weights(row).end());
        }
        offsets[row + 1] = static_cast<Offset>(columns.size());
    }
    return {stencils::Trusted{}, table.columnCount(), std::move(offsets), std::move(columns),
            std::move(weights)};
}

template CompiledRows<float> compileRows(const StencilTable<float>&, NumberOrder, Simd);
template CompiledRows<double> compileRows(const StencilTable<double>&, NumberOrder, Simd);
template StencilTable<float> rowsOnly(const StencilTable<float>&, std::span<const Index>);
template StencilTable<double> rowsOnly(const StencilTable<double>&, std::span<const Index>);

}  // namespace espalier::osd
