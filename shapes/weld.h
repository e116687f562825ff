// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <span>
#include <vector>

// The search for coincident points; not installed.
namespace espalier::shapes {

/// Points that are the same, numbered in the order of their first appearance.
struct Welding {
    std::vector<Index> newIndex;    ///< per point
    std::vector<Point3> positions;  ///< per welded point: that of the first one
};

/// Makes each point one with the nearest of the points before it that are kept, if that is at most
/// `distance` away. Kept points are farther than that from one another.
///
/// \param points finite
/// \param distance 0 or more
/// \cost O(n) with a hash table of boxes, while few points share a box
Welding weld(std::span<const Point3> points, double distance);

/// The diagonal of the box around points; 0 for none.
double diagonal(std::span<const Point3> points);

}  // namespace espalier::shapes
