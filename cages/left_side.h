// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <utility>

namespace espalier::cages {

/// Returns true if `p` is on the left of the line from `a` to `b` in the xy-plane. A point on the
/// line counts as moved by an infinitesimal step, which is the same for a and b exchanged: so a
/// vertical ray through `p` passes through exactly one of two triangles with a common side.
inline bool isLeft(const Point3& a, const Point3& b, const Point3& p) {
    if (std::pair(b[0], b[1]) < std::pair(a[0], a[1])) return !isLeft(b, a, p);
    const double area = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    return area >= 0;
}

}  // namespace espalier::cages
