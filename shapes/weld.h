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
    std::vector<Index> newIndex;    ///< per point: number of its welded point
    std::vector<Point3> positions;  ///< per welded point: position of its first point
};

/// Welds each point to the nearest welded point before it, if the distance is at most `distance`;
/// otherwise the point becomes a new welded point. So welded points are more than `distance` apart.
///
/// \param points finite positions
/// \param distance 0 or more
/// \cost O(n log n), wherever the points are
Welding weld(std::span<const Point3> points, double distance);

}  // namespace espalier::shapes
