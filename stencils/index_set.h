// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace espalier::stencils {

/// A set of a few of many numbered items, each with its place in a list. To look one up is to read
/// an array; to forget them all costs as much as they are.
class IndexSet {
public:
    /// \param count items are 0 to count − 1
    explicit IndexSet(Index count) : places_(count, kNone) {}

    bool has(Index item) const { return places_[item] != kNone; }
    /// \param item one that is there
    Index placeOf(Index item) const { return places_[item]; }
    const std::vector<Index>& items() const { return items_; }

    /// \param item one that is not there
    void add(Index item) {
        places_[item] = static_cast<Index>(items_.size());
        items_.push_back(item);
    }

    /// Puts the items in ascending order.
    void sort() {
        std::sort(items_.begin(), items_.end());
        for (std::size_t place = 0; place < items_.size(); ++place)
            places_[items_[place]] = static_cast<Index>(place);
    }

    /// Forgets all but the first `count`.
    void shrink(std::size_t count) {
        for (; items_.size() > count; items_.pop_back()) places_[items_.back()] = kNone;
    }

private:
    static constexpr Index kNone = kMaxIndex;
    std::vector<Index> places_;
    std::vector<Index> items_;
};

}  // namespace espalier::stencils
