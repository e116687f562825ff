// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <vector>

namespace espalier::solve {

using Positions = std::vector<Point3>;

/// Returns the positions at fraction `t` of the way from rest to a pose.
inline Positions moved(const Positions& rest, const Positions& pose, double t) {
    Positions result = rest;
    for (std::size_t v = 0; v < rest.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) result[v][c] += t * (pose[v][c] - rest[v][c]);
    return result;
}

}  // namespace espalier::solve
