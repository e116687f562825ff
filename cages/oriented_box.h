// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/bounding_box.h>
#include <espalier/base/point.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace espalier::cages {

/// A box around points, with axes of its own.
struct OrientedBox {
    std::array<Point3, 3> axes = {};  ///< unit vectors
    Point3 low = {}, high = {};       ///< along the axes
    Point3 middle = {}, half = {};    ///< the middle as a point; half of the sizes

    OrientedBox() = default;

    /// \param boxAxes orthogonal unit vectors
    /// \param points one or more
    OrientedBox(const std::array<Point3, 3>& boxAxes, std::span<const Point3> points)
        : axes(boxAxes) {
        BoundingBox bounds;
        for (const Point3& at : points)
            bounds.include({dot(axes[0], at), dot(axes[1], at), dot(axes[2], at)});
        low = bounds.min;
        high = bounds.max;
        half = scaled(difference(high, low), 0.5);
        for (std::size_t axis = 0; axis < 3; ++axis)
            middle = sum(middle, scaled(axes[axis], (low[axis] + high[axis]) / 2));
    }

    /// Returns true if the distance of a point from the box is at most `margin`.
    bool isNear(const Point3& point, double margin) const {
        double square = 0;
        for (int axis = 2; axis >= 0; --axis) {
            const double value = dot(axes[axis], point);
            const double away = std::max({low[axis] - value, value - high[axis], 0.0});
            if (away > margin) return false;
            square += away * away;
        }
        return square <= margin * margin;
    }

    /// Returns half of the size of the box along a direction, times the length of `way`.
    double reach(const Point3& way) const {
        return std::abs(dot(axes[0], way)) * half[0] + std::abs(dot(axes[1], way)) * half[1] +
               std::abs(dot(axes[2], way)) * half[2];
    }

    /// Returns true if another box is further away than `margin` along an axis of this box.
    bool isApart(const OrientedBox& other, double margin) const {
        for (int axis = 2; axis >= 0; --axis) {
            const double value = dot(axes[axis], other.middle);
            const double reach = other.reach(axes[axis]) + margin;
            if (value + reach < low[axis] || value - reach > high[axis]) return true;
        }
        return false;
    }
};

/// Returns orthogonal unit vectors; the last one is along `normal`, unless it is zero.
/// \param along orthogonal to the normal, not zero
inline std::array<Point3, 3> axesAround(const Point3& normal, const Point3& along) {
    const double size = length(normal);
    if (!(size > 0)) return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const Point3 last = scaled(normal, 1 / size), first = normalised(along);
    return {first, cross(last, first), last};
}

}  // namespace espalier::cages
