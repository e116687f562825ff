// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <span>
#include <vector>

// Finds coincident points; not installed.
namespace espalier::shapes {

/// The result of welding points. Welded points are numbered in the order of first appearance.
struct Welding {
    std::vector<Index> newIndex;    ///< number of the welded point of each point
    std::vector<Point3> positions;  ///< position of the first point of each welded point
};

/// Welds each point to the nearest welded point before it, if the distance is at most `distance`;
/// otherwise the point becomes a new welded point. So welded points are more than `distance` apart.
///
/// \param points finite positions
/// \param distance 0 or more
/// \cost O(n log n), wherever the points are
Welding weld(std::span<const Point3> points, double distance);

}  // namespace espalier::shapes
