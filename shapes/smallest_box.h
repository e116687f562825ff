// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/bounding_box.h>
#include <espalier/base/point.h>

#include <array>
#include <span>

// Finds the orientation of the smallest box around points; not installed.
namespace espalier::shapes {

/// Three perpendicular unit vectors, right-handed: the axes of a box.
using Axes = std::array<Point3, 3>;

inline constexpr Axes kCoordinateAxes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// Returns axes whose third is `direction`, a unit vector.
Axes axesAlong(const Point3& direction);

/// Returns the smallest box around points with sides along `axes`, in coordinates along them.
BoundingBox boxAlong(const Axes& axes, std::span<const Point3> points);

/// Returns the axes for which the box around the points is smallest, as far as a search finds them.
/// There are 24 ways to name the axes of a box; this returns the one nearest to x, y and z.
///
/// The search starts from a few dozen directions. It turns the box about each of its axes in turn
/// until the volume no longer decreases. Each turn is exact: one side of the smallest rectangle
/// around a convex polygon lies on a side of the polygon (Freeman & Shapira 1975).
///
/// \param padding added to each side before volumes are compared: of the boxes around points in a
///        plane, all of volume 0, a positive padding chooses one with a small area
Axes smallestBox(std::span<const Point3> points, double padding);

/// Returns the axes for which the box around the points is smallest, of all boxes of which one axis
/// is the coordinate axis with a number, 0 to 2. The two others are turned by at most 45 degrees.
/// \param padding as in smallestBox()
/// \cost O(points log points)
ESPALIER_API Axes smallestBoxAbout(std::size_t axis, std::span<const Point3> points,
                                   double padding);

}  // namespace espalier::shapes
