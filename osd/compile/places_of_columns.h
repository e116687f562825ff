// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace espalier::osd {

/// Of each column of a table the places, ascending, in which it was found: in whatever a caller
/// counts by Place.
template <class Place>
class PlacesOfColumns {
public:
    /// \param forEach calls what it is given with each column and place, places ascending; twice
    ///        the same
    template <class ForEach>
    PlacesOfColumns(Index columnCount, ForEach forEach) : offsets_(columnCount + 1, 0) {
        forEach([&](Index column, Place) { ++offsets_[column + 1]; });
        std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
        places_.resize(offsets_.back());
        std::vector<Offset> next(offsets_.begin(), offsets_.end() - 1);
        forEach([&](Index column, Place place) { places_[next[column]++] = place; });
    }

    std::span<const Place> of(Index column) const {
        return std::span(places_).subspan(offsets_[column],
                                          offsets_[column + 1] - offsets_[column]);
    }

    std::size_t byteCount() const {
        return offsets_.size() * sizeof(Offset) + places_.size() * sizeof(Place);
    }

private:
    std::vector<Offset> offsets_;
    std::vector<Place> places_;
};

}  // namespace espalier::osd
