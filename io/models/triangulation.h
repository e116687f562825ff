// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace espalier::io {

/// Splits a polygon into triangles by cutting off ears (Meisters 1975): triangles of three
/// successive corners that contain no other corner. The polygon is projected along its area vector.
///
/// The triangles have the winding of the polygon, and together each edge of the polygon once. A
/// plane polygon that does not cross itself is covered exactly, convex or not. In other polygons
/// there may be no ear at some point; then the rest is split into a fan. Corners on one line give a
/// fan from the first corner.
///
/// \param polygon corners of the polygon; fewer than three have no triangle
/// \return corners of polygon.size() − 2 triangles, by their numbers in `polygon`
/// \cost with n corners: O(n) if the polygon is convex or its corners are on one line; for most
///       others O(n log n) tests of a triangle, each of which takes O(log n), at most O(√n)
std::vector<std::array<std::size_t, 3>> triangulated(std::span<const Point3> polygon);

}  // namespace espalier::io
