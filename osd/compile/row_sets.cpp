// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <unordered_map>

#include "row_sets.h"

namespace espalier::osd {
namespace {

/// Returns a bit mask of the columns. A set can be a subset only of sets that have all of its bits.
std::uint64_t maskOf(std::span<const Index> columns) {
    std::uint64_t mask = 0;
    for (const Index column : columns)
        mask |=
            std::uint64_t{1} << ((static_cast<std::uint64_t>(column) * 0x9E3779B97F4A7C15U) >> 58);
    return mask;
}

/// Groups the rows of a table by their columns. Each set is its own superset.
template <class Real>
std::vector<RowSet> groupRows(const stencils::StencilTable<Real>& table) {
    constexpr Offset kGrain = 4096;
    std::vector<std::uint64_t> hashes(table.rowCount());
    parallelFor(table.rowCount(), kGrain, [&](Offset first, Offset last) {
        for (Offset row = first; row < last; ++row)
            hashes[row] = hashOf(table.columns(static_cast<Index>(row)));
    });
    // The first row of each set stands for the set. Sets come in the order of their first rows.
    const auto hashOfRow = [&](Index row) { return hashes[row]; };
    const auto haveSameColumns = [&](Index a, Index b) {
        return std::ranges::equal(table.columns(a), table.columns(b));
    };
    std::unordered_map<Index, std::size_t, decltype(hashOfRow), decltype(haveSameColumns)> numbers(
        0, hashOfRow, haveSameColumns);
    std::vector<RowSet> sets;
    for (Index row = 0; row < table.rowCount(); ++row) {
        const auto [found, isNew] = numbers.try_emplace(row, sets.size());
        if (isNew) sets.emplace_back();
        sets[found->second].rows.push_back(row);
    }
    for (std::size_t set = 0; set < sets.size(); ++set) sets[set].superset = set;
    return sets;
}

}  // namespace

template <class Real>
std::vector<RowSet> findRowSets(const stencils::StencilTable<Real>& table) {
    std::vector<RowSet> sets = groupRows(table);
    const auto columnsOf = [&](std::size_t set) { return table.columns(sets[set].rows.front()); };
    // Goes from the largest set to the smallest, so that a superset has no superset other than
    // itself.
    std::vector<std::size_t> order(sets.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return columnsOf(a).size() > columnsOf(b).size();
    });
    std::vector<std::uint64_t> masks;
    for (std::size_t set = 0; set < sets.size(); ++set) masks.push_back(maskOf(columnsOf(set)));
    std::vector<std::vector<std::size_t>> supersetsWith(table.columnCount());
    for (const std::size_t set : order) {
        const auto columns = columnsOf(set);
        if (columns.empty()) continue;
        // Searches among the supersets that contain the rarest of the columns. At a vertex with
        // very many edges there are many such supersets. The search is limited, because a missed
        // superset costs little.
        constexpr std::size_t kMaxTried = 256, kMaxSizeRatio = 3;
        const auto& supersets =
            supersetsWith[*std::min_element(columns.begin(), columns.end(), [&](Index a, Index b) {
                return supersetsWith[a].size() < supersetsWith[b].size();
            })];
        const auto last =
            supersets.begin() + static_cast<std::ptrdiff_t>(std::min(supersets.size(), kMaxTried));
        const auto superset = std::find_if(supersets.begin(), last, [&](std::size_t candidate) {
            return (masks[set] & ~masks[candidate]) == 0 &&
                   columnsOf(candidate).size() <= kMaxSizeRatio * columns.size() &&
                   std::ranges::includes(columnsOf(candidate), columns);
        });
        if (superset != last) {
            sets[set].superset = *superset;
            continue;
        }
        for (const Index column : columns) supersetsWith[column].push_back(set);
    }
    return sets;
}

template std::vector<RowSet> findRowSets(const stencils::StencilTable<float>&);
template std::vector<RowSet> findRowSets(const stencils::StencilTable<double>&);

}  // namespace espalier::osd
