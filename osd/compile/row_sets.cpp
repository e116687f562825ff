// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>
#include <espalier/base/hash.h>
#include <espalier/base/parallel.h>

#include <algorithm>
#include <array>
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
        mask |= std::uint64_t{1} << ((static_cast<std::uint64_t>(column) * kHashFactor) >> 58);
    return mask;
}

/// Returns a hash of columns. Four sums at a time take a quarter of the time of one.
std::uint64_t hashOfColumns(std::span<const Index> columns) {
    std::array<std::uint64_t, 4> sums = {1, 2, 3, columns.size()};
    std::size_t i = 0;
    for (; i + sums.size() <= columns.size(); i += sums.size())
        for (std::size_t k = 0; k < sums.size(); ++k)
            sums[k] = appendedHash(sums[k], static_cast<std::uint64_t>(columns[i + k]));
    for (; i < columns.size(); ++i)
        sums[0] = appendedHash(sums[0], static_cast<std::uint64_t>(columns[i]));
    return appendedHash(appendedHash(appendedHash(sums[0], sums[1]), sums[2]), sums[3]);
}

/// Groups the rows of a table by their columns: set → its rows. Sets are in the order of their
/// first rows.
template <class Real>
InverseIndex<Index> groupRows(const stencils::StencilTable<Real>& table) {
    constexpr Offset kGrain = 4096;
    const auto haveSameColumns = [&](Index a, Index b) {
        return std::ranges::equal(table.columns(a), table.columns(b));
    };
    // Neighbouring rows often have the same columns, and to compare two rows is faster than to hash
    // one. 0 stands for the hash of a row that has the columns of the row before.
    Array<std::uint64_t> hashes(table.rowCount());
    parallelFor(table.rowCount(), kGrain, [&](Offset first, Offset last) {
        for (auto row = static_cast<Index>(first); row < last; ++row)
            hashes[row] = row > 0 && haveSameColumns(row - 1, row)
                              ? 0
                              : std::max<std::uint64_t>(hashOfColumns(table.columns(row)), 1);
    });
    // The first row of each set stands for the set.
    const auto hashOfRow = [&](Index row) { return hashes[row]; };
    std::unordered_map<Index, Index, decltype(hashOfRow), decltype(haveSameColumns)> numbers(
        0, hashOfRow, haveSameColumns);
    Array<Index> setOf(table.rowCount());
    for (Index row = 0; row < table.rowCount(); ++row)
        setOf[row] =
            hashes[row] == 0
                ? setOf[row - 1]
                : numbers.try_emplace(row, static_cast<Index>(numbers.size())).first->second;
    return {static_cast<Index>(numbers.size()), [&](auto found) {
                for (Index row = 0; row < table.rowCount(); ++row) found(setOf[row], row);
            }};
}

/// Returns the superset of each set.
template <class Real>
std::vector<Index> supersetsOf(const stencils::StencilTable<Real>& table,
                               const InverseIndex<Index>& sets) {
    const auto columnsOf = [&](Index set) { return table.columns(sets.of(set).front()); };
    std::vector<Index> supersetOf(sets.count());
    std::iota(supersetOf.begin(), supersetOf.end(), Index{0});
    // Goes from the largest set to the smallest, so that a superset has no superset other than
    // itself.
    std::vector<Index> order = supersetOf;
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return columnsOf(a).size() > columnsOf(b).size(); });
    std::vector<std::uint64_t> masks;
    for (Index set = 0; set < sets.count(); ++set) masks.push_back(maskOf(columnsOf(set)));
    std::vector<std::vector<Index>> supersetsWith(table.columnCount());
    for (const Index set : order) {
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
        const auto superset = std::find_if(supersets.begin(), last, [&](Index candidate) {
            return (masks[set] & ~masks[candidate]) == 0 &&
                   columnsOf(candidate).size() <= kMaxSizeRatio * columns.size() &&
                   std::ranges::includes(columnsOf(candidate), columns);
        });
        if (superset != last) {
            supersetOf[set] = *superset;
            continue;
        }
        for (const Index column : columns) supersetsWith[column].push_back(set);
    }
    return supersetOf;
}

}  // namespace

template <class Real>
RowSets::RowSets(const stencils::StencilTable<Real>& table) : rows_(groupRows(table)) {
    const std::vector<Index> supersetOf = supersetsOf(table, rows_);
    subsets_ = {count(), [&](auto found) {
                    for (Index set = 0; set < count(); ++set) found(supersetOf[set], set);
                }};
}

template RowSets::RowSets(const stencils::StencilTable<float>&);
template RowSets::RowSets(const stencils::StencilTable<double>&);

}  // namespace espalier::osd
