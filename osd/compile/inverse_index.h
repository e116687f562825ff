// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/base/index.h>

#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace espalier::osd {

/// An inverse index: for each key from 0 on, such as a column of a table, the places that refer to
/// it, ascending. `Place` is any type in which the caller counts them.
template <class Place>
class InverseIndex {
public:
    InverseIndex() = default;
    /// \param forEach calls its argument with each pair of key and place, places ascending. It is
    ///        called twice and must produce the same pairs both times
    template <class ForEach>
    InverseIndex(Index keyCount, ForEach forEach) : offsets_(Offset{keyCount} + 1, 0) {
        forEach([&](Index key, Place) { ++offsets_[key + 1]; });
        std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
        places_.resize(offsets_.back());
        std::vector<Offset> next(offsets_.begin(), offsets_.end() - 1);
        forEach([&](Index key, Place place) { places_[next[key]++] = place; });
    }

    /// The number of keys.
    Index count() const { return static_cast<Index>(offsets_.size()) - 1; }

    std::span<const Place> of(Index key) const {
        return std::span(places_).subspan(offsets_[key], offsets_[key + 1] - offsets_[key]);
    }

    /// The places of all keys, key by key.
    std::span<const Place> places() const { return places_; }

    std::size_t byteCount() const {
        return offsets_.size() * sizeof(Offset) + places_.size() * sizeof(Place);
    }

private:
    std::vector<Offset> offsets_ = {0};
    Array<Place> places_;
};

}  // namespace espalier::osd
