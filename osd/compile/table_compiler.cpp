// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <numeric>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "outer_product.h"
#include "row_sets.h"
#include "table_compiler.h"

namespace espalier::osd {
namespace {

using kernels::kLanes;
using stencils::StencilTable;

/// Collects groups of rows that share their columns, for a compiled table. Groups with identical
/// numbers share them; all faces of a regular surface are such groups, for example.
template <class Real>
class GroupList {
public:
    /// Adds a group.
    /// \param numbers the weights of the columns, or the factors, row by row
    /// \param size the size of an outer product, or zeros
    void add(std::span<const Index> rows, std::span<const Index> columns,
             const std::array<Index, 3>& size, std::vector<Real> numbers) {
        groups_.push_back({{rows.begin(), rows.end()},
                           {columns.begin(), columns.end()},
                           size,
                           std::move(numbers),
                           0});
        groups_.back().hash = hashOf(groups_.back());
    }

    /// Moves all groups into a table that has none yet.
    void moveTo(CompiledRows<Real>& table) {
        std::unordered_map<std::uint64_t, Index> counts;
        for (const Group& group : groups_) ++counts[group.hash];
        /// Numbers that are already in the table, and their position there.
        struct Place {
            std::array<Index, 3> size;
            std::vector<Real> numbers;
            Offset first;
        };
        std::unordered_multimap<std::uint64_t, Place> places;
        const auto placeOf = [&](Group& group) {
            // A group that shares its numbers with no other keeps the order of its rows, so that
            // results that are close in memory are written together.
            if (counts[group.hash] == 1) return appendNumbers(group, table.groupNumbers);
            sortRows(group);
            const auto [begin, end] = places.equal_range(group.hash);
            const auto same = std::find_if(begin, end, [&](const auto& place) {
                return place.second.size == group.size && place.second.numbers == group.numbers;
            });
            if (same != end) return same->second.first;
            const Offset first = appendNumbers(group, table.groupNumbers);
            places.emplace(group.hash, Place{group.size, std::move(group.numbers), first});
            return first;
        };
        for (Group& group : groups_) {
            const Offset firstNumber = placeOf(group);
            const auto [lowest, highest] =
                std::minmax_element(group.rows.begin(), group.rows.end());
            table.groups.push_back({static_cast<Offset>(table.groupColumns.size()),
                                    static_cast<Index>(group.columns.size()), firstNumber,
                                    static_cast<Offset>(table.groupRows.size()),
                                    static_cast<Index>(group.rows.size()), *lowest, *highest,
                                    group.size});
            table.groupColumns.insert(table.groupColumns.end(), group.columns.begin(),
                                      group.columns.end());
            table.groupRows.insert(table.groupRows.end(), group.rows.begin(), group.rows.end());
            group = {};
        }
        groups_.clear();
    }

private:
    struct Group {
        std::vector<Index> rows, columns;
        std::array<Index, 3> size;
        std::vector<Real> numbers;
        std::uint64_t hash;  ///< of numbers and size; does not depend on the order of the rows

        std::size_t length() const { return numbers.size() / rows.size(); }
    };

    static std::uint64_t hashOf(const Group& group) {
        const std::uint64_t kind[] = {
            group.columns.size(), static_cast<std::uint64_t>(group.size[0]),
            static_cast<std::uint64_t>(group.size[1]), static_cast<std::uint64_t>(group.size[2])};
        std::uint64_t hash = osd::hashOf(std::span<const std::uint64_t>(kind));
        // A sum does not depend on the order of the rows.
        const std::span<const Real> numbers(group.numbers);
        for (std::size_t row = 0; row < group.rows.size(); ++row)
            hash += osd::hashOf(numbers.subspan(row * group.length(), group.length()));
        return hash;
    }

    /// Sorts the rows by the bits of their numbers. The order has no meaning; it only puts
    /// identical rows side by side.
    static void sortRows(Group& group) {
        const std::size_t length = group.length();
        const auto numbersOf = [&](std::size_t row) {
            return std::span(group.numbers).subspan(row * length, length);
        };
        std::vector<std::size_t> order(group.rows.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return std::memcmp(numbersOf(a).data(), numbersOf(b).data(), length * sizeof(Real)) < 0;
        });
        std::vector<Index> rows;
        std::vector<Real> numbers;
        numbers.reserve(group.numbers.size());
        for (const std::size_t row : order) {
            rows.push_back(group.rows[row]);
            numbers.insert(numbers.end(), numbersOf(row).begin(), numbersOf(row).end());
        }
        group.rows = std::move(rows);
        group.numbers = std::move(numbers);
    }

    /// Appends the numbers of a group in the layout of the kernels, one row in each lane.
    static Offset appendNumbers(const Group& group, AlignedVector<Real>& all) {
        constexpr std::size_t lanes = kLanes<Real>;
        const std::size_t length = group.length(), start = all.size();
        all.resize(start + (group.rows.size() + lanes - 1) / lanes * lanes * length);
        for (std::size_t row = 0; row < group.rows.size(); ++row) {
            const std::size_t first = start + row / lanes * lanes * length + row % lanes;
            for (std::size_t k = 0; k < length; ++k)
                all[first + k * lanes] = group.numbers[row * length + k];
        }
        return static_cast<Offset>(start);
    }

    std::vector<Group> groups_;
};

/// Maximum number of rows in a run. One thread evaluates a run.
constexpr std::ptrdiff_t kMaxRowsPerRun = 4096;

/// Minimum number of rows with the same weights that get a run of their own.
constexpr std::ptrdiff_t kMinSharedRows = 16;

template <class Real>
class RunList {
public:
    RunList(const StencilTable<Real>& table, CompiledRows<Real>& compiled)
        : table_(table), compiled_(compiled) {}

    /// Adds rows of equal length.
    /// \param isShared true if all of them have the same weights
    void add(std::span<const Index> rows, bool isShared) {
        const auto length = static_cast<Index>(table_.columns(rows.front()).size());
        const auto firstWeight = static_cast<Offset>(compiled_.weights.size());
        if (isShared) appendWeights(rows.front());
        while (!rows.empty()) {
            const auto part = rows.first(std::min(std::ssize(rows), kMaxRowsPerRun));
            compiled_.runs.push_back(
                {length, static_cast<Offset>(compiled_.columns.size()),
                 isShared ? firstWeight : static_cast<Offset>(compiled_.weights.size()), isShared,
                 static_cast<Offset>(compiled_.rows.size()), static_cast<Index>(part.size())});
            for (const Index row : part) {
                const auto columns = table_.columns(row);
                compiled_.columns.insert(compiled_.columns.end(), columns.begin(), columns.end());
                compiled_.rows.push_back(row);
                if (!isShared) appendWeights(row);
            }
            rows = rows.subspan(part.size());
        }
    }

private:
    void appendWeights(Index row) {
        const auto weights = table_.weights(row);
        compiled_.weights.insert(compiled_.weights.end(), weights.begin(), weights.end());
    }

    const StencilTable<Real>& table_;
    CompiledRows<Real>& compiled_;
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
}

/// Approximate number of rows of a task. One thread evaluates a task.
constexpr Index kRowsPerTask = 4096;

template <class Real>
class TableCompiler {
public:
    explicit TableCompiler(const StencilTable<Real>& table) : table_(table) {}

    CompiledRows<Real> compile() {
        const std::vector<RowSet> sets = findRowSets(table_);
        std::vector<std::vector<std::size_t>> subsets(sets.size());
        for (std::size_t set = 0; set < sets.size(); ++set)
            subsets[sets[set].superset].push_back(set);
        for (std::size_t superset = 0; superset < sets.size(); ++superset)
            if (!subsets[superset].empty()) addSuperset(sets, superset, subsets[superset]);
        groups_.moveTo(result_);
        addRuns(table_, std::move(ungrouped_), result_);
        addTasks();
        result_.groups.shrink_to_fit();
        result_.groupColumns.shrink_to_fit();
        result_.groupNumbers.shrink_to_fit();
        result_.groupRows.shrink_to_fit();
        result_.runs.shrink_to_fit();
        result_.columns.shrink_to_fit();
        result_.weights.shrink_to_fit();
        result_.rows.shrink_to_fit();
        // Kernels add the lane to this pointer also for rows without entries. It must not be null.
        result_.groupNumbers.reserve(kLanes<Real>);
        return std::move(result_);
    }

private:
    /// Adds the rows of a superset and of its subsets to groups, as far as they fill panels.
    void addSuperset(const std::vector<RowSet>& sets, std::size_t superset,
                     const std::vector<std::size_t>& subsets) {
        const std::vector<Index>& own = sets[superset].rows;
        shared_ = table_.columns(own.front());
        std::size_t rowCount = 0;
        for (const std::size_t set : subsets) rowCount += sets[set].rows.size();
        if (2 * rowCount < kLanes<Real>) {
            for (const std::size_t set : subsets) append(ungrouped_, sets[set].rows);
            return;
        }
        std::vector<std::span<const Real>> weights;
        for (const Index row : own) weights.push_back(table_.weights(row));
        const auto product = findOuterProduct<Real>(weights);
        std::vector<Index> products, left;
        std::vector<Real> factors;
        for (const std::size_t set : subsets) {
            std::vector<Index> others;
            for (const Index row : sets[set].rows)
                (product && addFactors(*product, row, factors) ? products : others).push_back(row);
            // Full panels use the subset's own columns.
            const std::size_t full = others.size() / kLanes<Real> * kLanes<Real>;
            addPanels(std::span(others).first(full), table_.columns(sets[set].rows.front()));
            // With the superset's columns, the remaining rows need zeros for the columns that they
            // lack. Rows that would take more memory in this way stay ungrouped.
            const std::size_t ownCount = table_.columns(sets[set].rows.front()).size();
            const bool fits =
                shared_.size() * sizeof(Real) <= ownCount * (sizeof(Real) + sizeof(Index));
            append(fits ? left : ungrouped_, std::span(others).subspan(full));
        }
        if (product) addProducts(*product, products, factors);
        // Uses the superset's columns for all remaining rows, for the rows that fill panels, or for
        // no rows, whichever is the first that saves memory.
        const std::size_t full = left.size() / kLanes<Real> * kLanes<Real>;
        const std::size_t paneled = isSmaller(left)                          ? left.size()
                                    : isSmaller(std::span(left).first(full)) ? full
                                                                             : 0;
        addPanels(std::span(left).first(paneled), shared_);
        append(ungrouped_, std::span(left).subspan(paneled));
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

    /// Returns the weights of a row for columns that include its own, with zeros for the others.
    /// They are valid until the next call.
    std::span<const Real> spread(Index row, std::span<const Index> columns) {
        const auto own = table_.columns(row);
        if (own.size() == columns.size()) return table_.weights(row);
        spread_.assign(columns.size(), 0);
        for (std::size_t k = 0, place = 0; k < own.size(); ++k) {
            while (columns[place] != own[k]) ++place;
            spread_[place] = table_.weights(row)[k];
        }
        return spread_;
    }

    /// Appends the factors of a row to `factors`. Returns false if the row is not this kind of
    /// outer product.
    bool addFactors(const OuterProduct& product, Index row, std::vector<Real>& factors) {
        std::array<Real, 256> found;
        const std::size_t length = product.size[0] + product.size[1] + product.size[2];
        if (length > found.size()) return false;
        const auto own = std::span(found).first(length);
        if (!factorizeRow<Real>(product, spread(row, shared_), own)) return false;
        factors.insert(factors.end(), own.begin(), own.end());
        return true;
    }

    void addPanels(std::span<const Index> rows, std::span<const Index> columns) {
        for (; !rows.empty(); rows = rows.subspan(std::min(rows.size(), kMaxRowsPerGroup))) {
            const auto part = rows.first(std::min(rows.size(), kMaxRowsPerGroup));
            std::vector<Real> numbers;
            numbers.reserve(part.size() * columns.size());
            for (const Index row : part) {
                const auto weights = spread(row, columns);
                numbers.insert(numbers.end(), weights.begin(), weights.end());
            }
            groups_.add(part, columns, {}, std::move(numbers));
        }
    }

    void addProducts(const OuterProduct& product, std::span<const Index> rows,
                     std::span<const Real> factors) {
        const std::size_t length = product.size[0] + product.size[1] + product.size[2];
        std::vector<Index> columns;
        for (const Index position : product.order) columns.push_back(shared_[position]);
        for (std::size_t first = 0; first < rows.size(); first += kMaxRowsPerGroup) {
            const auto part = rows.subspan(first, std::min(rows.size() - first, kMaxRowsPerGroup));
            const auto numbers = factors.subspan(first * length, part.size() * length);
            groups_.add(part, columns, product.size, {numbers.begin(), numbers.end()});
        }
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
    std::span<const Index> shared_;  ///< columns of the current superset
    std::vector<Index> ungrouped_;   ///< rows that are in no group
    std::vector<Real> spread_;       ///< the latest result of spread()
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
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    for (Index row = 0; row < table.rowCount(); ++row) {
        if (isSelected[row]) {
            columns.insert(columns.end(), table.columns(row).begin(), table.columns(row).end());
            weights.insert(weights.end(), table.weights(row).begin(), table.weights(row).end());
        }
        offsets.push_back(static_cast<Offset>(columns.size()));
    }
    return {stencils::Trusted{}, table.columnCount(), std::move(offsets), std::move(columns),
            std::move(weights)};
}

template CompiledRows<float> compileRows(const StencilTable<float>&);
template CompiledRows<double> compileRows(const StencilTable<double>&);
template StencilTable<float> rowsOnly(const StencilTable<float>&, std::span<const Index>);
template StencilTable<double> rowsOnly(const StencilTable<double>&, std::span<const Index>);

}  // namespace espalier::osd
