// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <filesystem>
#include <span>
#include <vector>

#include "vtk_xml.h"

namespace espalier::io {

/// Points from their coordinates, x y z x y z ...
std::vector<Point3> pointsOf(std::span<const double> coordinates);

/// The coordinates of points, x y z x y z ...
std::vector<double> coordinatesOf(std::span<const Point3> points);

/// \throws FileError naming the first point that is not finite
void checkFinite(const std::filesystem::path& path, std::span<const Point3> points);

/// The array that holds the points of a piece.
/// \throws FileError if Points is missing, or holds anything but one array of 3 components
const VtkDataArray& pointArray(const VtkXmlFile& file, const VtkPiece& piece);

/// The points of a piece, as many as it claims; none if that is 0.
/// \throws FileError as pointArray() and VtkXmlFile::reals()
std::vector<Point3> readPoints(const VtkXmlFile& file, const VtkPiece& piece);

}  // namespace espalier::io
