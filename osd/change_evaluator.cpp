// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/osd/change_evaluator.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>

#include "compile/compiled_table_data.h"
#include "compile/table_compiler.h"
#include "kernels/scratch.h"

namespace espalier::osd {
namespace {

using kernels::kLanes;

/// A set of numbers from 0 to a bound, stored as bits in memory of the caller.
class BitSet {
public:
    static constexpr Index kBitsPerWord = 64;
    static Offset wordCount(Index bound) {
        return (Offset{bound} + kBitsPerWord - 1) / kBitsPerWord;
    }

    explicit BitSet(std::span<std::uint64_t> words) : words_(words) {
        std::fill(words.begin(), words.end(), 0);
    }

    void add(Index number) { words_[number / kBitsPerWord] |= bit(number); }
    bool contains(Index number) const { return (words_[number / kBitsPerWord] & bit(number)) != 0; }

    /// Calls step(number) for the members in words firstWord to lastWord − 1, ascending.
    template <class Step>
    void forEach(Offset firstWord, Offset lastWord, Step step) const {
        for (Offset w = firstWord; w < lastWord; ++w)
            for (std::uint64_t word = words_[w]; word != 0; word &= word - 1)
                step(static_cast<Index>(w * kBitsPerWord + std::countr_zero(word)));
    }

private:
    static std::uint64_t bit(Index number) { return std::uint64_t{1} << (number % kBitsPerWord); }

    std::span<std::uint64_t> words_;
};

constexpr Offset kGroupsPerTask = 16;
constexpr Offset kWordsPerTask = 512;

}  // namespace

template <class Real>
struct ChangeEvaluator<Real>::Data {
    using Table = typename CompiledTable<Real>::Data;
    using Group = typename CompiledRows<Real>::Group;
    using Run = typename CompiledRows<Real>::Run;

    std::shared_ptr<const Table> table;
    InverseIndex<Index> groups;     ///< column → groups that have it
    InverseIndex<Index> ungrouped;  ///< column → rows in no group, by their slot in rows.rows
    std::vector<char> isFull;  ///< 1 for each of groupColumns for which no row has weight 0; else 0
    std::vector<Index> ascending;  ///< 0, 1, … as many as the longest run has columns
    Index maxColumns;              ///< maximum number of columns of a group or run

    explicit Data(std::shared_ptr<const Table> shared)
        : table(std::move(shared)),
          groups(table->columnCount,
                 [&](auto found) {
                     for (Index g = 0; g < groupCount(); ++g)
                         for (const Index column : table->columnsOf(groupAt(g))) found(column, g);
                 }),
          ungrouped(table->columnCount,
                    [&](auto found) {
                        for (const Run& run : table->rows.runs)
                            for (Index i = 0; i < run.rowCount; ++i) addRow(run, i, found);
                    }),
          isFull(table->rows.groupColumns.size()),
          maxColumns(table->maxColumns) {
        for (Index g = 0; g < groupCount(); ++g) {
            const Group& group = groupAt(g);
            for (Index k = 0; k < group.columnCount; ++k) {
                Index count = 0;
                forRowsWith(group, k, [&](Index) { ++count; });
                isFull[group.firstColumn + k] = count == group.rowCount;
            }
        }
        Index longest = 0;
        for (const Run& run : table->rows.runs) longest = std::max(longest, run.length);
        ascending.resize(longest);
        std::iota(ascending.begin(), ascending.end(), Index{0});
        maxColumns = std::max(maxColumns, longest);
    }

    Index groupCount() const { return static_cast<Index>(table->rows.groups.size()); }
    Index ungroupedCount() const { return static_cast<Index>(table->rows.rows.size()); }
    const Group& groupAt(Index g) const { return table->rows.groups[g]; }

    template <class Found>
    void addRow(const Run& run, Index i, Found found) const {
        const Real* weights = table->rows.weights.data() + run.firstWeight +
                              (run.isShared ? 0 : Offset{i} * run.length);
        const Index* columns =
            table->rows.columns.data() + run.firstColumn + Offset{i} * run.length;
        for (Index k = 0; k < run.length; ++k)
            if (weights[k] != 0) found(columns[k], static_cast<Index>(run.firstRow + i));
    }

    /// Calls found(row) for each row of a group that has a weight other than 0 for column k of the
    /// group.
    template <class Found>
    void forRowsWith(const Group& group, Index k, Found found) const {
        constexpr Index lanes = kLanes<Real>;
        const auto& size = group.size;
        const bool isPanel = size[0] == 0;
        const Index length = isPanel ? group.columnCount : size[0] + size[1] + size[2];
        // The weight is a number of a panel, or the product of three factors.
        const Index first = isPanel ? k : k % size[0],
                    second = isPanel ? k : size[0] + k / size[0] % size[1],
                    third = isPanel ? k : size[0] + size[1] + k / (size[0] * size[1]);
        const Real* own = table->rows.groupNumbers.data() + group.firstNumber;
        for (Index row = 0; row < group.rowCount; row += lanes, own += Offset{length} * lanes)
            for (Index lane = 0; lane < std::min(lanes, group.rowCount - row); ++lane)
                if (own[first * lanes + lane] != 0 && own[second * lanes + lane] != 0 &&
                    own[third * lanes + lane] != 0)
                    found(row + lane);
    }

    void checkColumns(std::span<const Index> changed) const {
        for (const Index column : changed)
            if (column < 0 || column >= table->columnCount)
                throw Error(concat("column ", column, " is not in a table of ", table->columnCount,
                                   " columns"));
    }

    /// The columns that changed, and the rows and groups that depend on them.
    struct Changes {
        BitSet columns;
        BitSet ungrouped;
        std::span<const Index> groups;  ///< ascending
    };

    std::size_t changeBytes() const {
        return scratchBytes<std::uint64_t>(BitSet::wordCount(table->columnCount)) +
               scratchBytes<std::uint64_t>(BitSet::wordCount(ungroupedCount())) +
               scratchBytes<std::uint64_t>(BitSet::wordCount(groupCount())) +
               scratchBytes<Index>(groupCount());
    }

    Changes changesBy(std::span<const Index> changed, Scratch& scratch) const {
        const auto marks = [&](Index bound) {
            return BitSet(scratch.take<std::uint64_t>(BitSet::wordCount(bound)));
        };
        BitSet columns = marks(table->columnCount), rows = marks(ungroupedCount()),
               isChanged = marks(groupCount());
        for (const Index column : changed) {
            if (columns.contains(column)) continue;
            columns.add(column);
            for (const Index slot : ungrouped.of(column)) rows.add(slot);
            for (const Index g : groups.of(column)) isChanged.add(g);
        }
        const std::span<Index> list = scratch.take<Index>(groupCount());
        std::size_t count = 0;
        isChanged.forEach(0, BitSet::wordCount(groupCount()), [&](Index g) { list[count++] = g; });
        return {columns, rows, list.first(count)};
    }

    using GroupRows = std::array<Index, kMaxRowsPerGroup>;

    /// The rows of a group that kernels write.
    struct ChangedRows {
        const Index* numbers;  ///< −1 for rows that do not depend on the changed columns
        bool isWhole;          ///< true if all rows depend on them
    };

    /// Returns the rows of a group that depend on changed columns. The result may point into
    /// `rows`.
    ChangedRows changedRows(Index g, const BitSet& columns, GroupRows& rows) const {
        const Group& group = groupAt(g);
        const auto all = table->rowsOf(group), own = table->columnsOf(group);
        for (Index k = 0; k < group.columnCount; ++k)
            if (isFull[group.firstColumn + k] && columns.contains(own[k]))
                return {all.data(), true};
        std::fill_n(rows.begin(), group.rowCount, Index{-1});
        for (Index k = 0; k < group.columnCount; ++k)
            if (columns.contains(own[k]))
                forRowsWith(group, k, [&](Index row) { rows[row] = all[row]; });
        return {rows.data(), false};
    }

    /// Buffers of the tasks: each holds the source entries of one group or of one row.
    TaskBuffers<Real> taskBuffers(Offset length) const {
        const Offset tasks =
            std::max((groupCount() + kGroupsPerTask - 1) / kGroupsPerTask,
                     (BitSet::wordCount(ungroupedCount()) + kWordsPerTask - 1) / kWordsPerTask);
        return {tasks, maxColumns * paddedLength(length)};
    }

    std::size_t workspaceBytes(Offset length) const {
        return changeBytes() + taskBuffers(length).bytes();
    }
};

template <class Real>
ChangeEvaluator<Real>::ChangeEvaluator(const CompiledTable<Real>& table)
    : data_(std::make_shared<const Data>(table.data_)) {}

template <class Real>
Index ChangeEvaluator<Real>::rowCount() const {
    return data_->table->rowCount;
}

template <class Real>
Index ChangeEvaluator<Real>::columnCount() const {
    return data_->table->columnCount;
}

template <class Real>
std::size_t ChangeEvaluator<Real>::byteCount() const {
    const auto bytes = [](const auto& values) { return values.size() * sizeof(values[0]); };
    return data_->groups.byteCount() + data_->ungrouped.byteCount() + bytes(data_->isFull) +
           bytes(data_->ascending);
}

template <class Real>
Workspace ChangeEvaluator<Real>::workspace(Offset length) const {
    checkLength(length);
    return Workspace(data_->workspaceBytes(length));
}

template <class Real>
void ChangeEvaluator<Real>::evaluateChanged(Values<Real> source,
                                            const BufferDescriptor& sourceLayout,
                                            MutableValues<Real> destination,
                                            const BufferDescriptor& destinationLayout,
                                            std::span<const Index> changed, Workspace& workspace,
                                            const Addend<Real>& addend) const {
    checkEvaluation(rowCount(), columnCount(), source.size(), sourceLayout, destination.size(),
                    destinationLayout, {0, rowCount()});
    checkAddend(addend.values.size(), addend.layout, destinationLayout, {0, rowCount()});
    data_->checkColumns(changed);
    const Offset length = sourceLayout.length, stride = paddedLength(length);
    Scratch scratch(workspace.reserve(data_->workspaceBytes(length)));
    const auto changes = data_->changesBy(changed, scratch);
    TaskBuffers<Real> numbers = data_->taskBuffers(length);
    numbers.allocateFrom(scratch);

    const auto& table = *data_->table;
    const auto gather = [&](std::span<const Index> columns, Real* to) {
        for (std::size_t k = 0; k < columns.size(); ++k)
            copyPadded(source.data() + sourceLayout.offset + columns[k] * sourceLayout.stride,
                       length, stride, to + static_cast<Offset>(k) * stride);
    };
    const auto all =
        destinationOf<Real>(destination, destinationLayout, {0, rowCount()}, rowCount(), addend);
    auto some = all;
    some.isWhole = false;  // Kernels must check the range, which excludes rows with number −1.
    parallelFor(std::ssize(changes.groups), kGroupsPerTask, [&](Offset first, Offset last) {
        typename TaskBuffers<Real>::Local entries(numbers, first / kGroupsPerTask);
        typename Data::GroupRows rows;
        for (Offset i = first; i < last; ++i) {
            const Index g = changes.groups[i];
            const auto& group = data_->groupAt(g);
            gather(table.columnsOf(group), entries.data());
            const auto changedRows = data_->changedRows(g, changes.columns, rows);
            table.evaluateGroup(group, entries.data(), stride, changedRows.numbers,
                                changedRows.isWhole ? all : some);
        }
    });
    const auto& runs = table.rows.runs;
    parallelFor(
        BitSet::wordCount(data_->ungroupedCount()), kWordsPerTask, [&](Offset first, Offset last) {
            typename TaskBuffers<Real>::Local entries(numbers, first / kWordsPerTask);
            auto run = runs.begin();
            changes.ungrouped.forEach(first, last, [&](Index slot) {
                while (slot >= run->firstRow + run->rowCount) ++run;
                const auto i = static_cast<Index>(slot - run->firstRow);
                gather(std::span(table.rows.columns)
                           .subspan(run->firstColumn + Offset{i} * run->length, run->length),
                       entries.data());
                table.evaluateRow(*run, i, entries.data(), stride, data_->ascending.data(), all);
            });
        });
}

template <class Real>
std::vector<Index> ChangeEvaluator<Real>::rowsOf(std::span<const Index> changed) const {
    data_->checkColumns(changed);
    Workspace workspace(data_->changeBytes());
    Scratch scratch(workspace.reserve(0));
    const auto changes = data_->changesBy(changed, scratch);
    std::vector<Index> result;
    typename Data::GroupRows own;
    for (const Index g : changes.groups) {
        const Index* rows = data_->changedRows(g, changes.columns, own).numbers;
        std::copy_if(rows, rows + data_->groupAt(g).rowCount, std::back_inserter(result),
                     [](Index row) { return row >= 0; });
    }
    changes.ungrouped.forEach(0, BitSet::wordCount(data_->ungroupedCount()),
                              [&](Index slot) { result.push_back(data_->table->rows.rows[slot]); });
    std::sort(result.begin(), result.end());
    return result;
}

template class ChangeEvaluator<float>;
template class ChangeEvaluator<double>;

}  // namespace espalier::osd
