// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <algorithm>
#include <span>
#include <vector>

namespace espalier {

/// Sorts numbers and removes duplicates.
inline void sortUnique(std::vector<Index>& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// Returns the position of a value in ascending numbers that contain it.
inline Index placeIn(std::span<const Index> ascending, Index value) {
    return static_cast<Index>(std::lower_bound(ascending.begin(), ascending.end(), value) -
                              ascending.begin());
}

}  // namespace espalier
