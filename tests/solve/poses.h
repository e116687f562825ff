// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <vector>

#include "support/zoo.h"

namespace espalier::solve {

using Positions = std::vector<Point3>;

/// A part of the way from rest to a pose.
inline Positions moved(const Positions& rest, const Positions& pose, double t) {
    Positions result = rest;
    for (std::size_t v = 0; v < rest.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) result[v][c] += t * (pose[v][c] - rest[v][c]);
    return result;
}

inline Positions randomlyMoved(Positions positions, double size, unsigned seed) {
    const auto moves = test::randomValues(3 * positions.size(), seed);
    for (std::size_t i = 0; i < moves.size(); ++i) positions[i / 3][i % 3] += size * moves[i];
    return positions;
}

}  // namespace espalier::solve
