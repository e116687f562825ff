// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <algorithm>
#include <span>
#include <vector>

namespace espalier {

/// Sorts numbers, and leaves each once.
inline void sortUnique(std::vector<Index>& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// Where a value is among ascending ones, which hold it.
inline Index placeIn(std::span<const Index> ascending, Index value) {
    return static_cast<Index>(std::lower_bound(ascending.begin(), ascending.end(), value) -
                              ascending.begin());
}

}  // namespace espalier
