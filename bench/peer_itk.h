// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <span>

namespace espalier::bench {

/// Moves points by itk::BSplineTransform<double, 3, 3>, which computes the 64 weights of each point
/// anew. In a file of its own, because ITK brings its own version of Eigen.
///
/// \param rest, pose positions of the vertices of an evenly divided unit cube, in any order
/// \param moved one for each point
void moveByItk(std::span<const Point3> rest, std::span<const Point3> pose,
               std::span<const Point3> points, std::span<Point3> moved);

}  // namespace espalier::bench
