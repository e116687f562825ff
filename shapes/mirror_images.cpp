// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/shapes/mirror_images.h>

#include <cmath>
#include <string>

#include "checks.h"
#include "weld.h"

namespace espalier::shapes {

std::vector<Index> mirrorImages(std::span<const Point3> positions, int axis, double plane,
                                double tolerance) {
    if (axis < 0 || axis > 2) throw ArgumentError("", "axis", std::to_string(axis), "0 to 2");
    requireFinite("", "at", plane);
    if (!(tolerance >= 0) || !std::isfinite(tolerance))
        throw ArgumentError("", "tolerance", textOf(tolerance), "a finite number of 0 or more");
    requireFinite("positions", positions);
    const std::size_t count = positions.size();
    // Points that are welded are near each other: positions first, then their images.
    std::vector<Point3> points(positions.begin(), positions.end());
    for (Point3 image : positions) {
        image[axis] = 2 * plane - image[axis];
        points.push_back(image);
    }
    requireFinite("points", points);
    const Welding welding = weld(points, tolerance);
    std::vector<Index> positionOf(welding.positions.size(), kNoImage);
    for (std::size_t i = 0; i < count; ++i) {
        Index& position = positionOf[welding.newIndex[i]];
        position = position == kNoImage ? static_cast<Index>(i) : kSeveralImages;
    }
    std::vector<Index> images(count);
    for (std::size_t i = 0; i < count; ++i) images[i] = positionOf[welding.newIndex[count + i]];
    std::vector<Index> result = images;
    for (std::size_t i = 0; i < count; ++i)
        if (images[i] >= 0 && images[images[i]] != static_cast<Index>(i)) result[i] = kNoImage;
    return result;
}

}  // namespace espalier::shapes
