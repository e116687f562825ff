// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/solve/sliding_points.h>

#include <span>

// The planes, cylinders, lines and circles that fit points best; not installed.
namespace espalier::solve {

/// A shape, and the largest distance of a point from it.
struct FittedShape {
    SlideShape shape;
    double distance = 0;
};

// Each function fits a shape to the points `points` of `places`, by least squares. The direction is
// exactly along an axis of coordinates if such a shape fits as well.

/// \param points two or more
FittedShape fitLine(std::span<const Index> points, std::span<const Point3> places);

/// \param points three or more
FittedShape fitPlane(std::span<const Index> points, std::span<const Point3> places);

/// Fits a circle: the plane first, and then the circle in it.
/// \param points three or more
FittedShape fitCircle(std::span<const Index> points, std::span<const Point3> places);

/// Fits a cylinder. Searches for the direction of the axis among some that cover the sphere, and
/// improves the best ones.
/// \param points six or more, not in one plane
/// \cost O(points); 10,000 points take about 10 ms
FittedShape fitCylinder(std::span<const Index> points, std::span<const Point3> places);

/// Returns the distance of a place from a shape.
double distanceFrom(const SlideShape& shape, const Point3& place);

/// Returns the vector from the axis of a cylinder or a circle to a place.
Point3 fromAxis(const SlideShape& shape, const Point3& place);

}  // namespace espalier::solve
