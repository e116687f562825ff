// SPDX-License-Identifier: Apache-2.0
#include "group_list.h"

#include <espalier/base/parallel.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <type_traits>
#include <unordered_map>
#include <utility>

namespace espalier::osd {

using kernels::kLanes;
using stencils::StencilTable;

template <class Real>
GroupList<Real>::GroupList(const StencilTable<Real>& table) : table_(table) {
    rows_.reserve(table.rowCount());
}

template <class Real>
void GroupList<Real>::addPanels(std::span<const Index> rows, std::span<const Index> columns) {
    add(rows, columns, {});
}

template <class Real>
void GroupList<Real>::addFactors(std::span<const Real> factors) {
    factors_.insert(factors_.end(), factors.begin(), factors.end());
}

template <class Real>
void GroupList<Real>::addProducts(std::span<const Index> rows, std::span<const Index> columns,
                                  const std::array<Index, 3>& size) {
    add(rows, columns, size);
}

template <class Real>
void GroupList<Real>::add(std::span<const Index> rows, std::span<const Index> columns,
                          const std::array<Index, 3>& size) {
    while (!rows.empty()) {
        const auto part = rows.first(std::min(rows.size(), kMaxRowsPerGroup));
        const auto [lowest, highest] = std::minmax_element(part.begin(), part.end());
        groups_.push_back({static_cast<Offset>(columns_.size()), static_cast<Index>(columns.size()),
                           static_cast<Offset>(factorsUsed_), static_cast<Offset>(rows_.size()),
                           static_cast<Index>(part.size()), *lowest, *highest, size});
        columns_.insert(columns_.end(), columns.begin(), columns.end());
        rows_.insert(rows_.end(), part.begin(), part.end());
        sums_.push_back(sumOfBits(groups_.back()));
        if (size[0] > 0) factorsUsed_ += part.size() * lengthOf(groups_.back());
        rows = rows.subspan(part.size());
    }
}

/// Returns how many numbers the group has for each row.
template <class Real>
std::size_t GroupList<Real>::lengthOf(const Group& group) {
    return group.size[0] == 0 ? group.columnCount : group.size[0] + group.size[1] + group.size[2];
}

template <class Real>
std::span<const Index> GroupList<Real>::columnsOf(const Group& group) const {
    return std::span(columns_).subspan(group.firstColumn, group.columnCount);
}

template <class Real>
std::span<Index> GroupList<Real>::rowsOf(const Group& group) {
    return std::span(rows_).subspan(group.firstRow, group.rowCount);
}

/// Returns the numbers of row i of a group.
/// \param spread gets the weights if the row lacks some columns of the group
template <class Real>
std::span<const Real> GroupList<Real>::numbersOf(const Group& group, Index i,
                                                 std::vector<Real>& spread) const {
    const std::size_t length = lengthOf(group);
    if (group.size[0] > 0)
        return std::span(factors_).subspan(
            static_cast<std::size_t>(group.firstNumber) + static_cast<std::size_t>(i) * length,
            length);
    return spreadRow(table_, rows_[group.firstRow + i], columnsOf(group), spread);
}

/// Returns the sum of the bits of all numbers of a group. It does not depend on their order and on
/// zeros, so it is quick to compute from the table.
template <class Real>
std::uint64_t GroupList<Real>::sumOfBits(const Group& group) const {
    using Bits = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
    const auto sumOf = [](std::span<const Real> numbers) {
        std::uint64_t sum = 0;
        for (const Real number : numbers) sum += std::bit_cast<Bits>(number);
        return sum;
    };
    const std::size_t count = static_cast<std::size_t>(group.rowCount) * lengthOf(group);
    if (group.size[0] > 0) return sumOf(std::span(factors_).subspan(group.firstNumber, count));
    std::uint64_t sum = count;
    for (Index i = 0; i < group.rowCount; ++i)
        sum += sumOf(table_.weights(rows_[group.firstRow + i]));
    return sum;
}

/// Returns a hash of the numbers and the size. It does not depend on the order of the rows.
template <class Real>
std::uint64_t GroupList<Real>::hashOfGroup(const Group& group) const {
    const std::uint64_t kind[] = {
        static_cast<std::uint64_t>(group.columnCount), static_cast<std::uint64_t>(group.size[0]),
        static_cast<std::uint64_t>(group.size[1]), static_cast<std::uint64_t>(group.size[2])};
    std::uint64_t hash = hashOf(std::span<const std::uint64_t>(kind));
    // A sum does not depend on the order of the rows.
    std::vector<Real> spread;
    for (Index i = 0; i < group.rowCount; ++i) hash += hashOf(numbersOf(group, i, spread));
    return hash;
}

template <class Real>
bool GroupList<Real>::haveSameNumbers(const Group& a, const Group& b) const {
    if (a.size != b.size || a.rowCount != b.rowCount || a.columnCount != b.columnCount)
        return false;
    std::vector<Real> spreadA, spreadB;
    for (Index i = 0; i < a.rowCount; ++i)
        if (!std::ranges::equal(numbersOf(a, i, spreadA), numbersOf(b, i, spreadB))) return false;
    return true;
}

/// Sorts the rows of a group by the bits of their numbers. The order has no meaning; it only puts
/// identical rows side by side.
template <class Real>
void GroupList<Real>::sortRows(const Group& group) {
    const std::size_t length = lengthOf(group), count = group.rowCount;
    std::vector<Real> numbers, spread;
    numbers.reserve(count * length);
    for (Index i = 0; i < group.rowCount; ++i) {
        const auto own = numbersOf(group, i, spread);
        numbers.insert(numbers.end(), own.begin(), own.end());
    }
    const auto first = [&](Index i) {
        return numbers.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(i) * length);
    };
    std::vector<Index> order(count);
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
        return std::memcmp(&*first(a), &*first(b), length * sizeof(Real)) < 0;
    });
    const std::span<Index> rows = rowsOf(group);
    const std::vector<Index> unsorted(rows.begin(), rows.end());
    for (std::size_t i = 0; i < count; ++i) {
        rows[i] = unsorted[order[i]];
        if (group.size[0] > 0)
            std::copy_n(
                first(order[i]), length,
                factors_.begin() + group.firstNumber + static_cast<std::ptrdiff_t>(i * length));
    }
}

/// Finds groups with identical numbers and sorts their rows, so that they can share the numbers.
/// Returns for each group the first group with the same numbers.
template <class Real>
std::vector<std::size_t> GroupList<Real>::findSources() {
    // Hashes only groups that may be alike.
    std::vector<std::uint64_t> hashes(groups_.size());
    std::unordered_map<std::uint64_t, Index> sumCounts, hashCounts;
    for (const std::uint64_t sum : sums_) ++sumCounts[sum];
    const auto mayShare = [&](std::size_t g) { return sumCounts[sums_[g]] > 1; };
    for (std::size_t g = 0; g < groups_.size(); ++g)
        if (mayShare(g)) ++hashCounts[hashes[g] = hashOfGroup(groups_[g])];

    std::vector<std::size_t> sources(groups_.size());
    std::unordered_multimap<std::uint64_t, std::size_t> firstGroups;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        sources[g] = g;
        // A group that shares its numbers with no other keeps the order of its rows, so that
        // results that are close in memory are written together.
        if (!mayShare(g) || hashCounts[hashes[g]] == 1) continue;
        sortRows(groups_[g]);
        const auto [begin, end] = firstGroups.equal_range(hashes[g]);
        const auto same = std::find_if(begin, end, [&](const auto& first) {
            return haveSameNumbers(groups_[first.second], groups_[g]);
        });
        if (same != end)
            sources[g] = same->second;
        else
            firstGroups.emplace(hashes[g], g);
    }
    return sources;
}

/// Stores the numbers of a group in the layout of the kernels, one row in each lane.
template <class Real>
void GroupList<Real>::storeNumbers(const Group& group, Real* to) const {
    constexpr Index lanes = kLanes<Real>;
    const std::size_t length = lengthOf(group);
    std::array<std::vector<Real>, lanes> spread;
    const std::vector<Real> zeros(length, Real{0});
    for (Index first = 0; first < group.rowCount; first += lanes) {
        std::array<const Real*, lanes> numbers;
        for (Index lane = 0; lane < lanes; ++lane)
            numbers[lane] = first + lane < group.rowCount
                                ? numbersOf(group, first + lane, spread[lane]).data()
                                : zeros.data();
        for (std::size_t k = 0; k < length; ++k)
            for (Index lane = 0; lane < lanes; ++lane) *to++ = numbers[lane][k];
    }
}

template <class Real>
void GroupList<Real>::moveTo(CompiledRows<Real>& compiled) {
    const std::vector<std::size_t> sources = findSources();
    std::vector<Offset> firstNumbers(groups_.size());
    Offset count = 0;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        const Group& group = groups_[g];
        firstNumbers[g] = sources[g] == g ? count : firstNumbers[sources[g]];
        if (sources[g] != g) continue;
        const Offset panels = (group.rowCount + kLanes<Real> - 1) / kLanes<Real>;
        count += panels * kLanes<Real> * static_cast<Offset>(lengthOf(group));
    }
    // Kernels add the lane to this pointer also for rows without entries. It must not be null.
    compiled.groupNumbers.reserve(std::max<std::size_t>(count, kLanes<Real>));
    compiled.groupNumbers.resize(count);
    parallelFor(std::ssize(groups_), 1, [&](Offset g, Offset) {
        if (sources[g] == static_cast<std::size_t>(g))
            storeNumbers(groups_[g], compiled.groupNumbers.data() + firstNumbers[g]);
    });
    for (std::size_t g = 0; g < groups_.size(); ++g) groups_[g].firstNumber = firstNumbers[g];
    columns_.shrink_to_fit();
    groups_.shrink_to_fit();
    rows_.shrink_to_fit();
    compiled.groups = std::move(groups_);
    compiled.groupColumns = std::move(columns_);
    compiled.groupRows = std::move(rows_);
    factors_ = {};
}

template class GroupList<float>;
template class GroupList<double>;

}  // namespace espalier::osd
