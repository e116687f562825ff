// SPDX-License-Identifier: Apache-2.0
#include "frames.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/around.h>

#include <algorithm>
#include <span>
#include <utility>

namespace espalier::cages {
namespace {

using shapes::Axes;

/// Returns the axes of the smallest box around points.
Axes orientedAxes(std::span<const Point3> points) {
    const Lattice box =
        shapes::around(points, {.cellsAlongLongest = 1, .margin = 0.01, .oriented = true});
    Axes axes;
    for (std::size_t axis = 0; axis < 3; ++axis)
        axes[axis] =
            normalised(difference(box.positions[std::size_t{1} << axis], box.positions[0]));
    return axes;
}

}  // namespace

Point3 Frame::sizeOf(std::span<const Point3> points, const MirrorPlanes& mirrors) {
    const BoundingBox box(points);
    Point3 size = box.size();
    for (int axis = 0; axis < 3; ++axis)
        if (const auto& plane = mirrors[axis])
            size[axis] = 2 * std::max(*plane - box.min[axis], box.max[axis] - *plane);
    return size;
}

Point3 toFrame(const Axes& axes, const Point3& point) {
    return {dot(axes[0], point), dot(axes[1], point), dot(axes[2], point)};
}

Point3 fromFrame(const Axes& axes, const Point3& coordinates) {
    return sum(sum(scaled(axes[0], coordinates[0]), scaled(axes[1], coordinates[1])),
               scaled(axes[2], coordinates[2]));
}

std::vector<Frame> framesOf(const ModelSurface& surface, const MirrorPlanes& mirrors) {
    std::vector<Frame> frames;
    frames.push_back({shapes::kCoordinateAxes, surface.points(), mirrors});
    const auto planeCount = std::ranges::count_if(mirrors, [](const auto& at) { return !!at; });
    if (planeCount > 1) return frames;
    const std::span<const Point3> points(surface.points().data(), surface.modelPointCount());
    const BoundingBox box(points);
    // Other axes are worth their time if their box is clearly smaller.
    constexpr double kSmaller = 0.8;
    const double least = 1e-3 * box.diagonal();  // of a side, for flat models
    const auto volume = [&](const Point3& size) {
        return (size[0] + least) * (size[1] + least) * (size[2] + least);
    };
    Axes axes;
    if (planeCount == 0) axes = orientedAxes(points);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (mirrors[axis]) axes = shapes::smallestBoxAbout(axis, points, least);
    std::vector<Point3> turned;
    for (const Point3& point : surface.points()) turned.push_back(toFrame(axes, point));
    if (volume(BoundingBox(turned).size()) < kSmaller * volume(box.size()))
        frames.push_back({axes, std::move(turned), mirrors});
    return frames;
}

}  // namespace espalier::cages
