// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace espalier {

/// A position in space. Topology has none; the folders that do share this type.
using Point3 = std::array<double, 3>;

/// Returns the length of a vector. std::hypot() of three numbers has another formula in each
/// standard library, and so other last bits.
inline double length(const Point3& a) {
    const Point3 sides = {std::abs(a[0]), std::abs(a[1]), std::abs(a[2])};
    const double largest = std::max({sides[0], sides[1], sides[2]});
    if (largest == 0) return 0;
    const double x = sides[0] / largest, y = sides[1] / largest, z = sides[2] / largest;
    return largest * std::sqrt(x * x + y * y + z * z);
}

}  // namespace espalier
