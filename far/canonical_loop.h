// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <algorithm>
#include <span>
#include <vector>

namespace espalier::far {

/// Appends a loop rotated to its smallest vertex and directed towards the smaller of that vertex's
/// two neighbours: the result is the same for all ways of writing one face.
inline void appendCanonicalLoop(std::span<const Index> loop, std::vector<Index>& out) {
    const std::size_t n = loop.size();
    const std::size_t start = std::min_element(loop.begin(), loop.end()) - loop.begin();
    const bool forward = loop[(start + 1) % n] < loop[(start + n - 1) % n];
    for (std::size_t i = 0; i < n; ++i) out.push_back(loop[(start + (forward ? i : n - i)) % n]);
}

}  // namespace espalier::far
