// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "ranked_bits.h"

namespace espalier::cages {

/// Lists, for each of some bins, the items in it, ascending. Above kMaxDense bins, an empty bin
/// takes 1.5 bits.
class Bins {
public:
    struct Entry {
        Index bin, item;
    };

    Bins() = default;

    /// \param entries by ascending items
    Bins(Index binCount, std::span<const Entry> entries) : items_(entries.size()) {
        if (binCount > kMaxDense) {
            used_ = RankedBits(binCount);
            for (const Entry& entry : entries) used_.insert(entry.bin);
            used_.makeRanks();
        }
        offsets_.assign(placeOf(binCount) + 1, 0);
        // Until all items have their places, an offset is the end of its bin; then the begin.
        for (const Entry& entry : entries) ++offsets_[placeOf(entry.bin)];
        std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
        for (std::size_t i = entries.size(); i-- > 0;)
            items_[--offsets_[placeOf(entries[i].bin)]] = entries[i].item;
    }

    std::span<const Index> operator[](Index bin) const { return itemsIn(bin, bin); }

    /// Returns the items in the bins `first` to `last`, bin after bin.
    std::span<const Index> itemsIn(Index first, Index last) const {
        const std::uint32_t begin = offsets_[placeOf(first)];
        return std::span(items_).subspan(begin, offsets_[placeOf(Offset{last} + 1)] - begin);
    }

private:
    /// Up to this number of bins, all have an offset: a cage of 100 cells with thin limbs took 7 %
    /// more CPU time with ranks.
    static constexpr Index kMaxDense = 1 << 20;

    bool isDense() const { return used_.size() == 0; }
    std::size_t placeOf(std::size_t bin) const { return isDense() ? bin : used_.rank(bin); }

    RankedBits used_;  ///< the bins that are not empty; empty if all bins have an offset
    std::vector<std::uint32_t> offsets_;  ///< the first item of each bin, or of each that is used
    std::vector<Index> items_;
};

}  // namespace espalier::cages
