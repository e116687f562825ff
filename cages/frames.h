// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/shapes/smallest_box.h>

#include <span>
#include <vector>

#include "model_surface.h"
#include "symmetry.h"

namespace espalier::cages {

/// Axes for a grid of cells, with the points of the model along them.
struct Frame {
    shapes::Axes axes;
    std::vector<Point3> points;
    MirrorPlanes mirrors;  ///< across axes that are coordinate axes
    /// The size of the box around the points and their mirror images.
    Point3 size = sizeOf(points, mirrors);

    bool isSymmetric() const { return mirrors != MirrorPlanes(); }
    static Point3 sizeOf(std::span<const Point3> points, const MirrorPlanes& mirrors);
};

/// Returns the coordinates of a point along axes.
Point3 toFrame(const shapes::Axes& axes, const Point3& point);
/// Returns the point with some coordinates along axes.
Point3 fromFrame(const shapes::Axes& axes, const Point3& coordinates);

/// Returns the axes along which grids are tried for a model: the coordinate axes, and the axes of
/// the smallest box around the model if it is clearly smaller.
///
/// An axis across a plane of symmetry stays, so that the box is turned about the axis of the only
/// plane. With several planes, there are no other axes.
std::vector<Frame> framesOf(const ModelSurface& surface, const MirrorPlanes& mirrors);

}  // namespace espalier::cages
