// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/index.h>

#include <algorithm>
#include <span>
#include <vector>

namespace espalier::stencils {

/// Sorts numbers, and leaves each once.
inline void sortUnique(std::vector<far::Index>& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// Where a value is among ascending ones, which hold it.
inline far::Index placeIn(std::span<const far::Index> ascending, far::Index value) {
    return static_cast<far::Index>(std::lower_bound(ascending.begin(), ascending.end(), value) -
                                   ascending.begin());
}

}  // namespace espalier::stencils
