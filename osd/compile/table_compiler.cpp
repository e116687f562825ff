// SPDX-License-Identifier: Apache-2.0
#include "table_compiler.h"

#include <espalier/base/parallel.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "group_list.h"
#include "outer_product.h"
#include "row_sets.h"

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
    std::sort(candidates.begin(), candidates.end());
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

template <class Real>
class TableCompiler {
public:
    explicit TableCompiler(const StencilTable<Real>& table) : table_(table), groups_(table) {}

    CompiledRows<Real> compile() {
        const RowSets sets(table_);
        for (Index set = 0; set < sets.count(); ++set)
            if (!sets.subsetsOf(set).empty()) addSuperset(sets, set);
        groups_.moveTo(result_);
        addRuns(table_, std::move(ungrouped_), result_);
        addTasks();
        return std::move(result_);
    }

private:
    /// Adds the rows of a superset and of its subsets to groups, as far as they fill panels.
    void addSuperset(const RowSets& sets, Index superset) {
        const auto subsets = sets.subsetsOf(superset);
        const auto own = sets.rowsOf(superset);
        shared_ = table_.columns(own.front());
        std::size_t rowCount = 0;
        for (const Index set : subsets) rowCount += sets.rowsOf(set).size();
        if (2 * rowCount < kLanes<Real>) {
            for (const Index set : subsets) append(ungrouped_, sets.rowsOf(set));
            return;
        }
        weights_.clear();
        for (const Index row : own) weights_.push_back(table_.weights(row));
        const auto product = findOuterProduct<Real>(weights_);
        products_.clear();
        left_.clear();
        for (const Index set : subsets) {
            std::span<const Index> others = sets.rowsOf(set);
            if (product) {
                addFactors(*product, others);
                others = others_;
            }
            // Full panels use the subset's own columns.
            const auto columns = table_.columns(sets.rowsOf(set).front());
            const std::size_t full = others.size() / kLanes<Real> * kLanes<Real>;
            groups_.addPanels(others.first(full), columns);
            // With the superset's columns, the remaining rows need zeros for the columns that they
            // lack. Rows that would take more memory in this way stay ungrouped.
            const bool fits =
                shared_.size() * sizeof(Real) <= columns.size() * (sizeof(Real) + sizeof(Index));
            append(fits ? left_ : ungrouped_, others.subspan(full));
        }
        if (product) {
            columns_.clear();
            for (const Index position : product->order) columns_.push_back(shared_[position]);
            groups_.addProducts(products_, columns_, product->size);
        }
        // Uses the superset's columns for all remaining rows, for the rows that fill panels, or for
        // no rows, whichever is the first that saves memory.
        const std::size_t full = left_.size() / kLanes<Real> * kLanes<Real>;
        const std::size_t paneled = isSmaller(left_)                          ? left_.size()
                                    : isSmaller(std::span(left_).first(full)) ? full
                                                                              : 0;
        groups_.addPanels(std::span(left_).first(paneled), shared_);
        append(ungrouped_, std::span(left_).subspan(paneled));
    }

    /// Returns true if rows take at most as much memory in panels with the superset's columns as
    /// they take ungrouped.
    bool isSmaller(std::span<const Index> rows) const {
        constexpr std::size_t lanes = kLanes<Real>;
        std::size_t entries = 0;
        for (const Index row : rows) entries += table_.columns(row).size();
        const std::size_t padded = (rows.size() + lanes - 1) / lanes * lanes * shared_.size();
        return padded * sizeof(Real) + shared_.size() * sizeof(Index) +
                   sizeof(typename CompiledRows<Real>::Group) <=
               entries * (sizeof(Real) + sizeof(Index));
    }

    static void append(std::vector<Index>& all, std::span<const Index> more) {
        all.insert(all.end(), more.begin(), more.end());
    }

    /// Adds the factors of the rows of a set to the groups. Puts rows that are not this kind of
    /// outer product into others_.
    void addFactors(const OuterProduct& product, std::span<const Index> rows) {
        positions_.clear();
        for (std::size_t place = 0; const Index column : table_.columns(rows.front())) {
            while (shared_[place] != column) ++place;
            positions_.push_back(static_cast<Index>(place));
        }
        weights_.clear();
        for (const Index row : rows) weights_.push_back(table_.weights(row));
        others_.clear();
        factorizeRows<Real>(product, positions_, weights_,
                            [&](std::size_t i, std::span<const Real> factors) {
                                (factors.empty() ? others_ : products_).push_back(rows[i]);
                                groups_.addFactors(factors);
                            });
    }

    /// Divides the groups into tasks.
    void addTasks() {
        Index rowCount = 0;
        for (std::size_t group = 0; group < result_.groups.size(); ++group) {
            rowCount += result_.groups[group].rowCount;
            if (rowCount < kRowsPerTask && group + 1 < result_.groups.size()) continue;
            result_.taskStarts.push_back(static_cast<Offset>(group) + 1);
            rowCount = 0;
        }
    }

    const StencilTable<Real>& table_;
    CompiledRows<Real> result_;
    GroupList<Real> groups_;
    std::vector<Index> ungrouped_;  ///< rows that are in no group

    // addSuperset() works on these. They are members so that all supersets use the same memory.
    std::span<const Index> shared_;               ///< columns of the superset
    std::vector<std::span<const Real>> weights_;  ///< of the rows of a set
    std::vector<Index> positions_;                ///< of the columns of a subset in shared_
    std::vector<Index> products_;                 ///< rows that are outer products
    std::vector<Index> others_;                   ///< rows of a subset that are not
    std::vector<Index> left_;     ///< rows that do not fill panels with the columns of their set
    std::vector<Index> columns_;  ///< in the order of the outer product
};

}  // namespace

template <class Real>
CompiledRows<Real> compileRows(const StencilTable<Real>& table) {
    return TableCompiler<Real>(table).compile();
}

template <class Real>
StencilTable<Real> rowsOnly(const StencilTable<Real>& table, std::span<const Index> rows) {
    std::vector<char> isSelected(table.rowCount(), 0);
    for (const Index row : rows) isSelected[row] = 1;
    Array<Offset> offsets(static_cast<std::size_t>(table.rowCount()) + 1);
    offsets[0] = 0;
    Array<Index> columns;
    Array<Real> weights;
    for (Index row = 0; row < table.rowCount(); ++row) {
        if (isSelected[row]) {
            columns.insert(columns.end(), table.columns(row).begin(), table.columns(row).end());
            weights.insert(weights.end(), table.weights(row).begin(), table.weights(row).end());
        }
        offsets[static_cast<std::size_t>(row) + 1] = static_cast<Offset>(columns.size());
    }
    return {stencils::Trusted{}, table.columnCount(), std::move(offsets), std::move(columns),
            std::move(weights)};
}

template CompiledRows<float> compileRows(const StencilTable<float>&);
template CompiledRows<double> compileRows(const StencilTable<double>&);
template StencilTable<float> rowsOnly(const StencilTable<float>&, std::span<const Index>);
template StencilTable<double> rowsOnly(const StencilTable<double>&, std::span<const Index>);

}  // namespace espalier::osd
