// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace espalier {

/// A position in space. Topology has none; the folders that do share this type.
using Point3 = std::array<double, 3>;

/// Returns the length of a vector. Nothing overflows or vanishes on the way. The bits are the same
/// on every machine: std::hypot() of three numbers differs between standard libraries.
inline double length(const Point3& a) {
    const double x = std::abs(a[0]), y = std::abs(a[1]), z = std::abs(a[2]);
    const double largest = std::max({x, y, z});
    if (!(largest > 0 && largest < std::numeric_limits<double>::infinity())) return x + y + z;
    return largest * std::sqrt(x / largest * (x / largest) + y / largest * (y / largest) +
                               z / largest * (z / largest));
}

}  // namespace espalier
