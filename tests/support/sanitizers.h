// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace espalier::test {

/// Whether this is a build under the address sanitizer, which takes ten times as long. A test that
/// goes through many shapes may leave some out there: what it is for is their memory, not their
/// numbers.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kIsSlow = true;
#else
inline constexpr bool kIsSlow = false;
#endif

/// All shapes; one of four in such a build.
template <class Shape>
std::vector<Shape> someOf(std::vector<Shape> all) {
    if (!kIsSlow) return all;
    std::vector<Shape> some;
    for (std::size_t i = 0; i < all.size(); i += 4) some.push_back(all[i]);
    return some;
}

}  // namespace espalier::test
