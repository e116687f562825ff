// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/cancellable_sort.h>
#include <espalier/base/index.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace espalier::io {

/// The numbers by which the elements of a file name its nodes.
class NodeNumbers {
public:
    /// Adds the number of a node.
    /// \param node the node in the order of the file
    void add(std::int64_t number, Index node) {
        // Most files number their nodes in order.
        isDense_ = isDense_ && (numbers_.empty() || (number > numbers_.back().first &&
                                                     number - 1 == numbers_.back().first &&
                                                     node - 1 == numbers_.back().second));
        numbers_.emplace_back(number, node);
    }

    /// Sorts the numbers, so that find() may be called. A hash table would be faster, but slow for
    /// numbers that all fall into one bucket.
    /// \return a number that two nodes have; nothing if all numbers differ
    std::optional<std::int64_t> sort() {
        if (isDense_) return std::nullopt;
        sortCancellably(numbers_.begin(), numbers_.end());
        const auto twice =
            std::adjacent_find(numbers_.begin(), numbers_.end(),
                               [](const auto& a, const auto& b) { return a.first == b.first; });
        return twice == numbers_.end() ? std::nullopt : std::optional(twice->first);
    }

    /// Returns the node that has a number; nothing if there is none.
    std::optional<Index> find(std::int64_t number) const {
        if (numbers_.empty() || number < numbers_.front().first || number > numbers_.back().first)
            return std::nullopt;
        if (isDense_)
            return static_cast<Index>(number - numbers_.front().first) + numbers_.front().second;
        const auto found =
            std::lower_bound(numbers_.begin(), numbers_.end(), std::pair(number, Index{0}));
        if (found == numbers_.end() || found->first != number) return std::nullopt;
        return found->second;
    }

    bool empty() const { return numbers_.empty(); }

    /// Calls visit(node) for the nodes with the numbers first, first + step, … up to last.
    /// \param step at least 1
    /// \cost O(n) for the nodes between them
    template <class Visit>
    void forEachBetween(std::int64_t first, std::int64_t last, std::int64_t step,
                        Visit visit) const {
        auto next = std::lower_bound(numbers_.begin(), numbers_.end(), std::pair(first, Index{0}));
        for (; next != numbers_.end() && next->first <= last; ++next)
            if ((static_cast<std::uint64_t>(next->first) - static_cast<std::uint64_t>(first)) %
                    static_cast<std::uint64_t>(step) ==
                0)
                visit(next->second);
    }

private:
    bool isDense_ = true;  ///< whether the numbers and the nodes ascend in steps of 1
    std::vector<std::pair<std::int64_t, Index>> numbers_;
};

}  // namespace espalier::io
