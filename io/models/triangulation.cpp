// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

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

/// Places of corners, from which corners can be removed. A tree of boxes: each half of its places
/// is on one side along the longer side of the box.
class CornerTree {
public:
    CornerTree() = default;
    /// \param corners some corners of the polygon; corners at one place are one place of the tree
    CornerTree(std::span<const Point2> points, std::vector<std::size_t> corners)
        : places_(points.size()) {
        std::sort(corners.begin(), corners.end(), [&](std::size_t a, std::size_t b) {
            return std::pair(points[a], a) < std::pair(points[b], b);
        });
        std::vector<Leaf> leaves;
        for (const std::size_t corner : corners) {
            if (leaves.empty() || leaves.back().point != points[corner])
                leaves.push_back({points[corner], {}});
            leaves.back().corners.push_back(corner);
        }
        if (leaves.empty()) return;
        nodes_.resize(2 * std::bit_ceil(leaves.size()));
        build(1, leaves);
    }

    /// Removes a corner. Returns its place, if the tree had it and the place has no corner any
    /// more.
    std::optional<std::size_t> remove(std::size_t corner) {
        const std::size_t place = places_[corner];
        for (std::size_t node = place; node > 0; node /= 2) --nodes_[node].count;
        return place > 0 && nodes_[place].count == 0 ? std::optional(place) : std::nullopt;
    }

    /// Returns an upper bound of the numbers of places.
    std::size_t placeBound() const { return nodes_.size(); }

    /// Returns the place of a corner in a triangle, or on its edges; nothing if there is none. The
    /// places of the corners of the triangle do not count.
    /// \cost O(√n) at most if the tree has n corners, O(log n) for most triangles
    std::optional<std::size_t> findIn(const Point2& a, const Point2& b, const Point2& c) const {
        if (nodes_.empty()) return std::nullopt;
        Query query = {{a, b, c}, {}, {}};
        for (std::size_t axis = 0; axis < 2; ++axis)
            std::tie(query.low[axis], query.high[axis]) = std::minmax({a[axis], b[axis], c[axis]});
        return findIn(query, 1);
    }

private:
    struct Leaf {
        Point2 point;
        std::vector<std::size_t> corners;
    };

    /// Nodes 2 i and 2 i + 1 are the halves of node i.
    struct Node {
        Point2 low = {}, high = {};
        std::size_t count = 0;  ///< number of corners that are left
        bool isLeaf = true;
    };

    /// A triangle and its box.
    struct Query {
        std::array<Point2, 3> corners;
        Point2 low, high;
    };

    void build(std::size_t number, std::span<Leaf> leaves) {
        Node& node = nodes_[number];
        node.low = node.high = leaves[0].point;
        for (const Leaf& leaf : leaves) {
            node.count += leaf.corners.size();
            for (std::size_t axis = 0; axis < 2; ++axis) {
                node.low[axis] = std::min(node.low[axis], leaf.point[axis]);
                node.high[axis] = std::max(node.high[axis], leaf.point[axis]);
            }
        }
        node.isLeaf = leaves.size() == 1;
        if (node.isLeaf) {
            for (const std::size_t corner : leaves[0].corners) places_[corner] = number;
            return;
        }
        const std::size_t axis = node.high[0] - node.low[0] > node.high[1] - node.low[1] ? 0 : 1;
        const std::size_t half = leaves.size() / 2;
        std::nth_element(leaves.begin(), leaves.begin() + static_cast<std::ptrdiff_t>(half),
                         leaves.end(), [&](const Leaf& p, const Leaf& q) {
                             return std::pair(p.point[axis], p.point[1 - axis]) <
                                    std::pair(q.point[axis], q.point[1 - axis]);
                         });
        build(2 * number, leaves.first(half));
        build(2 * number + 1, leaves.subspan(half));
    }

    std::optional<std::size_t> findIn(const Query& query, std::size_t number) const {
        const Node& node = nodes_[number];
        if (node.count == 0) return std::nullopt;
        for (std::size_t axis = 0; axis < 2; ++axis)
            if (node.high[axis] < query.low[axis] || node.low[axis] > query.high[axis])
                return std::nullopt;
        for (std::size_t i = 0; i < 3; ++i) {
            const Point2 &from = query.corners[i], &to = query.corners[(i + 1) % 3];
            // The corner of the box that is farthest on the inner side of the edge.
            const Point2 inner = {to[1] > from[1] ? node.low[0] : node.high[0],
                                  to[0] > from[0] ? node.high[1] : node.low[1]};
            if (doubleArea(from, to, inner) < 0) return std::nullopt;
        }
        if (node.isLeaf) {
            const bool isCorner = std::ranges::count(query.corners, node.low) > 0;
            return isCorner ? std::nullopt : std::optional(number);
        }
        const auto found = findIn(query, 2 * number);
        return found ? found : findIn(query, 2 * number + 1);
    }

    std::vector<Node> nodes_;          ///< numbered from 1
    std::vector<std::size_t> places_;  ///< the leaf of each corner of the polygon; 0: it is in none
};

/// Cuts ears off. A corner is tested at first, when one of its neighbours was cut, and when the
/// corner that lay in its triangle was cut: at no other time can it become an ear.
class EarClipper {
public:
    explicit EarClipper(std::span<const Point3> polygon)
        : points_(projected(polygon)),
          before_(polygon.size()),
          after_(polygon.size()),
          isCut_(polygon.size()) {
        const std::size_t size = polygon.size();
        for (std::size_t i = 0; i < size; ++i) {
            before_[i] = (i + size - 1) % size;
            after_[i] = (i + 1) % size;
        }
        // Only corners that are not convex at first can lie in the triangle of an ear.
        std::vector<std::size_t> reflex;
        for (std::size_t i = 0; i < size; ++i)
            if (areaAt(i) <= 0) reflex.push_back(i);
        reflex_ = CornerTree(points_, std::move(reflex));
        waiting_.resize(reflex_.placeBound());
    }

    std::vector<Triangle> clip() {
        const std::size_t count = points_.size() - 2;
        for (std::size_t i = 1; i <= points_.size(); ++i) candidates_.push_back(i % points_.size());
        for (; !candidates_.empty() && triangles_.size() < count; candidates_.pop_front())
            if (const std::size_t corner = candidates_.front(); !isCut_[corner] && isEar(corner))
                cut(corner);
        // The polygon crosses itself: any triangles of the rest will do.
        if (triangles_.size() < count) addFan(count);
        return std::move(triangles_);
    }

private:
    double areaAt(std::size_t corner) const {
        return doubleArea(points_[before_[corner]], points_[corner], points_[after_[corner]]);
    }

    /// Returns true if a corner is an ear. If a corner lies in its triangle, it waits for this one.
    bool isEar(std::size_t corner) {
        if (!(areaAt(corner) > 0)) return false;
        // Corners at one place are one point, as where a slit joins a hole to the outline.
        const auto place =
            reflex_.findIn(points_[before_[corner]], points_[corner], points_[after_[corner]]);
        if (place) waiting_[*place].push_back(corner);
        return !place;
    }

    void cut(std::size_t corner) {
        const std::size_t a = before_[corner], c = after_[corner];
        triangles_.push_back({a, corner, c});
        after_[a] = c;
        before_[c] = a;
        isCut_[corner] = true;
        candidates_.insert(candidates_.end(), {a, c});
        if (const auto place = reflex_.remove(corner)) {
            std::vector<std::size_t>& waiting = waiting_[*place];
            candidates_.insert(candidates_.end(), waiting.begin(), waiting.end());
            waiting.clear();
        }
    }

    /// Splits the corners that are left into a fan.
    /// \param count of all triangles
    void addFan(std::size_t count) {
        std::size_t apex = 1;
        while (isCut_[apex]) apex = (apex + 1) % points_.size();
        for (std::size_t corner = after_[apex]; triangles_.size() < count; corner = after_[corner])
            triangles_.push_back({apex, corner, after_[corner]});
    }

    std::vector<Point2> points_;
    std::vector<std::size_t> before_, after_;  ///< the neighbours of each corner that is not cut
    std::vector<bool> isCut_;
    CornerTree reflex_;  ///< the corners that are not convex, or once were not
    std::vector<std::vector<std::size_t>> waiting_;  ///< one list per place of reflex_
    std::deque<std::size_t> candidates_;
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
