// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace espalier::stencils {

/// A set of numbered items, of which few are in the set. Each item has a position in a list.
/// Looking up an item reads one array element, and removing all items takes time proportional to
/// their number.
class IndexSet {
public:
    /// \param count items are 0 to count − 1
    explicit IndexSet(Index count) : slots_(count, kNone) {}

    bool has(Index item) const { return slots_[item] != kNone; }
    /// \param item must be in the set
    Index slotOf(Index item) const { return slots_[item]; }
    const std::vector<Index>& items() const { return items_; }

    /// \param item must not be in the set
    void add(Index item) {
        slots_[item] = static_cast<Index>(items_.size());
        items_.push_back(item);
    }

    /// Puts the items in ascending order.
    void sort() {
        std::sort(items_.begin(), items_.end());
        for (std::size_t slot = 0; slot < items_.size(); ++slot)
            slots_[items_[slot]] = static_cast<Index>(slot);
    }

    /// Removes all items but the first `count`.
    void shrink(std::size_t count) {
        for (; items_.size() > count; items_.pop_back()) slots_[items_.back()] = kNone;
    }

private:
    static constexpr Index kNone = kMaxIndex;
    std::vector<Index> slots_;
    std::vector<Index> items_;
};

}  // namespace espalier::stencils
