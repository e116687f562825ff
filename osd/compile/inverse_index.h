// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/base/index.h>

#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace espalier::osd {

/// An inverse index: for each key from 0 on, such as a column of a table, the slots that refer to
/// it, ascending. `Slot` is any type in which the caller counts them.
template <class Slot>
class InverseIndex {
public:
    InverseIndex() = default;
    /// \param forEach calls its argument with each pair of key and slot, slots ascending. It is
    ///        called twice and must produce the same pairs both times
    template <class ForEach>
    InverseIndex(Index keyCount, ForEach forEach) : offsets_(Offset{keyCount} + 1, 0) {
        forEach([&](Index key, Slot) { ++offsets_[key + 1]; });
        std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
        slots_.resize(offsets_.back());
        std::vector<Offset> next(offsets_.begin(), offsets_.end() - 1);
        forEach([&](Index key, Slot slot) { slots_[next[key]++] = slot; });
    }

    /// The number of keys.
    Index count() const { return static_cast<Index>(offsets_.size()) - 1; }

    std::span<const Slot> of(Index key) const {
        return std::span(slots_).subspan(offsets_[key], offsets_[key + 1] - offsets_[key]);
    }

    /// The slots of all keys, key by key.
    std::span<const Slot> slots() const { return slots_; }

    std::size_t byteCount() const {
        return offsets_.size() * sizeof(Offset) + slots_.size() * sizeof(Slot);
    }

private:
    std::vector<Offset> offsets_ = {0};
    Array<Slot> slots_;
};

}  // namespace espalier::osd
