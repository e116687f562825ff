// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace espalier::test {

/// True in builds with the address sanitizer, where a test takes ten times as long. These builds
/// look for memory errors, for which a few shapes suffice; the Release build tests the numbers of
/// all shapes. (tests/CMakeLists.txt defines the macro, since tests are not instrumented
/// themselves.)
#ifdef ESPALIER_ADDRESS_SANITIZER
inline constexpr bool kIsSlow = true;
#else
inline constexpr bool kIsSlow = false;
#endif

/// Returns all shapes; under the address sanitizer every fourth. zoo(), featureLattices() and
/// meshZoo() use it.
template <class Shape>
std::vector<Shape> someOf(std::vector<Shape> all) {
    if (!kIsSlow) return all;
    std::vector<Shape> some;
    for (std::size_t i = 0; i < all.size(); i += 4) some.push_back(all[i]);
    return some;
}

/// Returns the number of cases that the shapes of someOf() must show if all shapes show `count`.
constexpr int shownBySome(int count) {
    return kIsSlow ? count / 4 : count;
}

}  // namespace espalier::test
