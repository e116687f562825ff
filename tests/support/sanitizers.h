// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace espalier::test {

/// Whether this is a build under the address sanitizer, where a test takes ten times as long. It
/// looks for errors of memory, which a few shapes show: the Release build tests the numbers of all.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kIsSlow = true;
#else
inline constexpr bool kIsSlow = false;
#endif

/// All shapes; under the address sanitizer one of four. zoo(), featureLattices() and meshZoo() give
/// no more.
template <class Shape>
std::vector<Shape> someOf(std::vector<Shape> all) {
    if (!kIsSlow) return all;
    std::vector<Shape> some;
    for (std::size_t i = 0; i < all.size(); i += 4) some.push_back(all[i]);
    return some;
}

/// How many of something the shapes have to show, where all of them show `count`.
constexpr int least(int count) {
    return kIsSlow ? count / 4 : count;
}

}  // namespace espalier::test
