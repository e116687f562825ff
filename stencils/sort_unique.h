// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/index.h>

#include <algorithm>
#include <vector>

namespace espalier::stencils {

/// Sorts numbers, and leaves each once.
inline void sortUnique(std::vector<far::Index>& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace espalier::stencils
