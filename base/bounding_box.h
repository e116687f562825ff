// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace espalier {

/// The smallest box that holds some points. Its sides are parallel to the axes of the points'
/// coordinates. A box that holds no point has `min` above `max`.
struct BoundingBox {
    Point3 min = {kInfinity, kInfinity, kInfinity};
    Point3 max = {-kInfinity, -kInfinity, -kInfinity};

    BoundingBox() = default;
    BoundingBox(const Point3& least, const Point3& greatest) : min(least), max(greatest) {}
    explicit BoundingBox(std::span<const Point3> points) { include(points); }

    void include(const Point3& point) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            min[axis] = std::min(min[axis], point[axis]);
            max[axis] = std::max(max[axis], point[axis]);
        }
    }
    void include(std::span<const Point3> points) {
        for (const Point3& point : points) include(point);
    }

    /// Returns true if the point is in the box or on its surface.
    bool contains(const Point3& point) const {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (!(point[axis] >= min[axis] && point[axis] <= max[axis])) return false;
        return true;
    }

    /// Returns the lengths of the sides; zeros without a point.
    Point3 size() const {
        return {std::max(max[0] - min[0], 0.0), std::max(max[1] - min[1], 0.0),
                std::max(max[2] - min[2], 0.0)};
    }

    /// Returns the length of the diagonal; 0 without a point.
    double diagonal() const { return length(size()); }

private:
    static constexpr double kInfinity = std::numeric_limits<double>::infinity();
};

}  // namespace espalier
