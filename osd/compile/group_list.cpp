// SPDX-License-Identifier: Apache-2.0
#include "group_list.h"
#include "number_hash.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace espalier::osd {

using kernels::kLanes;

template <class Real>
void GroupList<Real>::add(std::span<const Index> rows, std::span<const Index> columns,
                          const std::array<Index, 3>& size, std::vector<Real> numbers) {
    groups_.push_back({{rows.begin(), rows.end()},
                       {columns.begin(), columns.end()},
                       size,
                       std::move(numbers),
                       0});
    groups_.back().hash = hashOf(groups_.back());
}

template <class Real>
std::uint64_t GroupList<Real>::hashOf(const Group& group) {
    const std::uint64_t kind[] = {group.columns.size(), static_cast<std::uint64_t>(group.size[0]),
                                  static_cast<std::uint64_t>(group.size[1]),
                                  static_cast<std::uint64_t>(group.size[2])};
    std::uint64_t hash = osd::hashOf(std::span<const std::uint64_t>(kind));
    // A sum, that no order of the rows changes.
    const std::span<const Real> numbers(group.numbers);
    for (std::size_t row = 0; row < group.rows.size(); ++row)
        hash += osd::hashOf(numbers.subspan(row * group.length(), group.length()));
    return hash;
}

/// Sorts rows by the bits of their numbers: any order will do that has no ties but of equal rows.
template <class Real>
void GroupList<Real>::sortRows(Group& group) {
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

/// Appends the numbers of a group as the kernels read them, one row in each lane.
template <class Real>
Offset GroupList<Real>::appendNumbers(const Group& group, AlignedVector<Real>& all) {
    constexpr std::size_t lanes = kLanes<Real>;
    const std::size_t length = group.length(), start = all.size();
    all.resize(start + (group.rows.size() + lanes - 1) / lanes * lanes * length);
    for (std::size_t row = 0; row < group.rows.size(); ++row) {
        Real* lane = all.data() + start + row / lanes * lanes * length + row % lanes;
        for (std::size_t k = 0; k < length; ++k) lane[k * lanes] = group.numbers[row * length + k];
    }
    return static_cast<Offset>(start);
}

template <class Real>
void GroupList<Real>::moveTo(CompiledRows<Real>& table) {
    std::unordered_map<std::uint64_t, Index> counts;
    for (const Group& group : groups_) ++counts[group.hash];
    /// Numbers that are in the table, and where.
    struct Place {
        std::array<Index, 3> size;
        std::vector<Real> numbers;
        Offset first;
    };
    std::unordered_multimap<std::uint64_t, Place> places;
    const auto placeOf = [&](Group& group) {
        // Rows that no other group has stay in their order, for results that lie together.
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
        const auto [lowest, highest] = std::minmax_element(group.rows.begin(), group.rows.end());
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

template class GroupList<float>;
template class GroupList<double>;

}  // namespace espalier::osd
