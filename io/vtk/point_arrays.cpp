// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/files/file.h>

#include <cmath>
#include <string>

#include "point_arrays.h"

namespace espalier::io {

std::vector<Point3> pointsOf(std::span<const double> coordinates) {
    std::vector<Point3> points(coordinates.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = {coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
    return points;
}

std::vector<double> coordinatesOf(std::span<const Point3> points) {
    std::vector<double> coordinates;
    coordinates.reserve(3 * points.size());
    for (const Point3& point : points)
        coordinates.insert(coordinates.end(), point.begin(), point.end());
    return coordinates;
}

void checkFinite(const std::filesystem::path& path, std::span<const Point3> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        for (const double coordinate : points[i])
            if (!std::isfinite(coordinate))
                throw FileError(path, "point " + std::to_string(i) + " is not finite");
}

const VtkDataArray& pointArray(const VtkXmlFile& file, const VtkPiece& piece) {
    const VtkSection& section = file.section(piece, "Points");
    if (section.arrays.size() != 1 || section.arrays[0].components != 3)
        file.fail(section.line, "Points has " + std::to_string(section.arrays.size()) +
                                    " arrays; expected one, of 3 components");
    return section.arrays[0];
}

std::vector<Point3> readPoints(const VtkXmlFile& file, const VtkPiece& piece) {
    const std::size_t count = file.count(piece, "NumberOfPoints");
    if (count == 0) return {};
    return pointsOf(file.reals(pointArray(file, piece), count));
}

}  // namespace espalier::io
