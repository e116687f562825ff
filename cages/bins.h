// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace espalier::cages {

/// Lists, for each of some bins, the items in it, ascending.
class Bins {
public:
    struct Entry {
        Index bin, item;
    };

    Bins() = default;

    /// \param entries by ascending items
    Bins(Index binCount, std::span<const Entry> entries)
        : offsets_(Offset{binCount} + 1, 0), items_(entries.size()) {
        // Until all items have their places, an offset is the end of its bin; then the begin. There
        // may be many more bins than entries, so there is one array of them only.
        for (const Entry& entry : entries) ++offsets_[entry.bin];
        std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
        for (std::size_t i = entries.size(); i-- > 0;)
            items_[--offsets_[entries[i].bin]] = entries[i].item;
    }

    std::span<const Index> operator[](Index bin) const { return itemsIn(bin, bin); }

    /// Returns the items in the bins `first` to `last`, bin after bin.
    std::span<const Index> itemsIn(Index first, Index last) const {
        return std::span(items_).subspan(offsets_[first], offsets_[last + 1] - offsets_[first]);
    }

private:
    std::vector<std::uint32_t> offsets_;
    std::vector<Index> items_;
};

}  // namespace espalier::cages
