// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <span>
#include <vector>

namespace espalier::io {

/// The points of a mesh that is stored in parts, which repeat the points on their common border.
struct SharedPoints {
    /// For each part, the number in the mesh of each of its points. The points of the mesh are in
    /// the order in which the parts first have them.
    std::vector<std::vector<Index>> numbers;

    Index count = 0;  ///< number of points of the mesh
};

/// Finds the points that parts share, which have equal coordinates. If a part has several points at
/// one place, as on both sides of a baffle, the first one is shared with the first ones of other
/// parts, the second one with the second ones, and so on.
/// \param parts the points of each part
/// \throws Error if there are more points than an Index can count
/// \cost O(n log n)
SharedPoints findSharedPoints(std::span<const std::span<const Point3>> parts);

}  // namespace espalier::io
