// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "triangulation.h"

namespace espalier::io {
namespace {

using Point2 = std::array<double, 2>;
using Triangle = std::array<std::size_t, 3>;

/// Returns twice the area of a triangle, positive if it is anticlockwise.
double doubleArea(const Point2& a, const Point2& b, const Point2& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Projects a polygon along the largest component of its area vector, and scales it, so that no
/// product overflows. The result is anticlockwise as a whole.
std::vector<Point2> projected(std::span<const Point3> polygon) {
    double size = 0;
    for (const Point3& corner : polygon)
        for (std::size_t axis = 0; axis < 3; ++axis)
            size = std::max(size, std::abs(corner[axis] / 2 - polygon[0][axis] / 2));
    std::vector<Point3> scaledLoop;
    for (const Point3& corner : polygon) {
        Point3& point = scaledLoop.emplace_back(Point3{});
        for (std::size_t axis = 0; axis < 3 && size > 0; ++axis)
            point[axis] = (corner[axis] / 2 - polygon[0][axis] / 2) / size;
    }
    const Point3 area = areaVector(scaledLoop);
    std::size_t dropped = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
        if (std::abs(area[axis]) > std::abs(area[dropped])) dropped = axis;
    std::size_t u = (dropped + 1) % 3, v = (dropped + 2) % 3;
    if (area[dropped] < 0) std::swap(u, v);
    std::vector<Point2> result;
    for (const Point3& point : scaledLoop) result.push_back({point[u], point[v]});
    return result;
}

/// Returns true if all corners lie on one line or at one place, up to the rounding of their
/// coordinates: if no corner is farther from the line through the first corner and the farthest one
/// than the rounding of a coordinate.
bool isOnLine(std::span<const Point3> polygon) {
    // Halves, so that no difference overflows.
    std::vector<Point3> offsets;
    double largest = 0, size = 0;
    std::size_t farthest = 0;
    for (const Point3& corner : polygon) {
        const Point3 offset = difference(scaled(corner, 0.5), scaled(polygon[0], 0.5));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            largest = std::max(largest, std::abs(corner[axis] / 2));
            if (std::abs(offset[axis]) <= size) continue;
            size = std::abs(offset[axis]);
            farthest = offsets.size();
        }
        offsets.push_back(offset);
    }
    if (size == 0) return true;
    for (Point3& offset : offsets)
        for (double& number : offset) number /= size;
    // A corner and the first one are each rounded by up to half an epsilon of a coordinate, and the
    // products of the cross product by as much of their size, which is at most 1.
    const double rounding = 4 * std::numeric_limits<double>::epsilon() * (1 + largest / size);
    return std::ranges::all_of(offsets, [&](const Point3& offset) {
        return std::ranges::all_of(cross(offset, offsets[farthest]), [&](double component) {
            return std::abs(component) <= rounding;
        });
    });
}

class EarClipper {
public:
    explicit EarClipper(std::span<const Point3> polygon)
        : points_(projected(polygon)), before_(polygon.size()), after_(polygon.size()) {
        const std::size_t size = polygon.size();
        for (std::size_t i = 0; i < size; ++i) {
            before_[i] = (i + size - 1) % size;
            after_[i] = (i + 1) % size;
        }
        for (std::size_t i = 0; i < size; ++i)
            if (areaAt(i) <= 0) reflex_.push_back(i);
    }

    std::vector<Triangle> clip() {
        const std::size_t count = points_.size() - 2;
        std::vector<bool> isCut(points_.size());
        // An ear may appear where a corner is cut, or (rarely) elsewhere: then all corners are
        // tested again.
        while (triangles_.size() < count) {
            const std::size_t countBefore = triangles_.size();
            std::deque<std::size_t> candidates;
            for (std::size_t i = 1; i <= points_.size(); ++i)
                if (!isCut[i % points_.size()]) candidates.push_back(i % points_.size());
            const std::size_t first = candidates.front();
            for (; !candidates.empty() && triangles_.size() < count; candidates.pop_front()) {
                const std::size_t corner = candidates.front();
                if (isCut[corner] || !isEar(corner)) continue;
                isCut[corner] = true;
                cut(corner);
                candidates.insert(candidates.end(), {before_[corner], after_[corner]});
            }
            // The polygon crosses itself: any triangles of the rest will do.
            if (triangles_.size() == countBefore) addFan(first, count);
        }
        return std::move(triangles_);
    }

private:
    double areaAt(std::size_t corner) const {
        return doubleArea(points_[before_[corner]], points_[corner], points_[after_[corner]]);
    }

    bool isEar(std::size_t corner) const {
        if (!(areaAt(corner) > 0)) return false;
        const Point2 &a = points_[before_[corner]], &b = points_[corner],
                     &c = points_[after_[corner]];
        return std::ranges::none_of(reflex_, [&](std::size_t other) {
            const Point2& p = points_[other];
            // Corners at one place are one point, as where a slit joins a hole to the outline.
            if (p == a || p == b || p == c) return false;
            return doubleArea(a, b, p) >= 0 && doubleArea(b, c, p) >= 0 && doubleArea(c, a, p) >= 0;
        });
    }

    void cut(std::size_t corner) {
        const std::size_t a = before_[corner], c = after_[corner];
        triangles_.push_back({a, corner, c});
        after_[a] = c;
        before_[c] = a;
        std::erase(reflex_, corner);
    }

    /// Splits the corners that are left into a fan.
    /// \param count of all triangles
    void addFan(std::size_t apex, std::size_t count) {
        for (std::size_t corner = after_[apex]; triangles_.size() < count; corner = after_[corner])
            triangles_.push_back({apex, corner, after_[corner]});
    }

    std::vector<Point2> points_;
    std::vector<std::size_t> before_, after_;  ///< the neighbours of each corner that is not cut
    std::vector<std::size_t> reflex_;  ///< the corners that are not convex, or once were not
    std::vector<Triangle> triangles_;
};

}  // namespace

std::vector<Triangle> triangulated(std::span<const Point3> polygon) {
    if (polygon.size() < 3) return {};
    if (!isOnLine(polygon)) return EarClipper(polygon).clip();
    std::vector<Triangle> fan;
    for (std::size_t corner = 2; corner < polygon.size(); ++corner)
        fan.push_back({0, corner - 1, corner});
    return fan;
}

}  // namespace espalier::io
