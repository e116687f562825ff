// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/smallest_box.h>

#include <espalier/base/cancellable_sort.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace espalier::shapes {
namespace {

using Point2 = std::array<double, 2>;

/// Returns `count` directions, spread evenly over a half sphere on a spiral.
std::vector<Point3> directions(int count) {
    std::vector<Point3> result;
    for (int i = 0; i < count; ++i) {
        const double z = (i + 0.5) / count, radius = std::sqrt(1 - z * z);
        const double angle = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
        result.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
    return result;
}

/// Returns twice the signed area of a triangle: positive if its corners are anticlockwise.
double turn(const Point2& a, const Point2& b, const Point2& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Returns the corners of the convex hull, anticlockwise (Andrew's monotone chain).
std::vector<Point2> convexHull(std::vector<Point2> points) {
    sortCancellably(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.size() < 3) return points;
    std::vector<Point2> hull;
    const auto addChain = [&hull](const auto& chain) {
        const std::size_t start = hull.size();
        for (std::size_t i = 0; i < chain.size(); ++i) {
            checkCancelledEvery(i, 16);
            const Point2& point = chain[i];
            while (hull.size() >= start + 2 &&
                   turn(hull[hull.size() - 2], hull[hull.size() - 1], point) <= 0)
                hull.pop_back();
            hull.push_back(point);
        }
        hull.pop_back();  // The other chain begins with it.
    };
    addChain(points);
    std::ranges::reverse(points);
    addChain(points);
    return hull;
}

/// Returns the unit vector along a side of the rectangle of smallest area around a convex polygon
/// whose two sides are longer by `padding`.
Point2 smallestRectangle(const std::vector<Point2>& hull, double padding) {
    const std::size_t count = hull.size();
    Point2 best = {1, 0};
    if (count < 2) return best;
    double least = std::numeric_limits<double>::infinity();
    // The corners farthest along the side, across it, and against it. They go around with the side.
    std::size_t ahead = 0, across = 0, behind = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Point2& from = hull[i];
        const Point2& to = hull[(i + 1) % count];
        const double length = espalier::length({to[0] - from[0], to[1] - from[1], 0});
        if (!(length > 0)) continue;
        const Point2 side = {(to[0] - from[0]) / length, (to[1] - from[1]) / length};
        const auto along = [&](std::size_t k, const Point2& direction) {
            return hull[k % count][0] * direction[0] + hull[k % count][1] * direction[1];
        };
        const auto advance = [&](std::size_t& corner, const Point2& direction) {
            for (std::size_t steps = 0; steps < count; ++steps, ++corner)
                if (!(along(corner + 1, direction) > along(corner, direction))) return;
        };
        const Point2 normal = {-side[1], side[0]}, back = {-side[0], -side[1]};
        ahead = std::max(ahead, i);
        advance(ahead, side);
        across = std::max(across, ahead);
        advance(across, normal);
        behind = std::max(behind, across);
        advance(behind, back);
        const double area =
            (along(ahead, side) - along(behind, side) + padding) *
            (along(across, normal) - (from[0] * normal[0] + from[1] * normal[1]) + padding);
        if (area < least) {
            least = area;
            best = side;
        }
    }
    return best;
}

double paddedVolume(const BoundingBox& box, double padding) {
    const Point3 size = box.size();
    return (size[0] + padding) * (size[1] + padding) * (size[2] + padding);
}

/// Turns a box about one of its axes, so that it becomes as small as possible.
void turnAbout(std::size_t axis, std::span<const Point3> points, double padding, Axes& current) {
    const Point3 u = current[(axis + 1) % 3], v = current[(axis + 2) % 3];
    std::vector<Point2> projected;
    projected.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        checkCancelledEvery(i, 16);
        projected.push_back({dot(points[i], u), dot(points[i], v)});
    }
    Point2 side = smallestRectangle(convexHull(std::move(projected)), padding);
    // The sides have four directions. The one nearest to u becomes the new u, so that the axes
    // keep their numbers and the search turns the box about each axis in turn.
    if (std::abs(side[1]) > std::abs(side[0])) side = {side[1], -side[0]};
    if (side[0] < 0) side = {-side[0], -side[1]};
    Point3 first;
    for (std::size_t i = 0; i < 3; ++i) first[i] = side[0] * u[i] + side[1] * v[i];
    first = normalised(first);
    current[(axis + 1) % 3] = first;
    current[(axis + 2) % 3] = cross(current[axis], first);
}

/// Turns a box about its axes, by the smallest rectangles, until its volume no longer decreases.
struct Search {
    std::span<const Point3> points;
    double padding;
    Axes axes = kCoordinateAxes;
    double volume = std::numeric_limits<double>::infinity();

    void start(const Axes& from) {
        Axes current = from;
        double smallest = paddedVolume(boxAlong(current, points), padding);
        take(current, smallest);
        // Each turn makes the box smaller; the limit is for turns that gain almost nothing.
        constexpr int kMaxTurns = 60;
        int withoutGain = 0;
        for (int turns = 0; turns < kMaxTurns && withoutGain < 3; ++turns) {
            turnAbout(turns % 3, points, padding, current);
            const double next = paddedVolume(boxAlong(current, points), padding);
            withoutGain = next < smallest * (1 - kGain) ? 0 : withoutGain + 1;
            smallest = next;
            take(current, next);
        }
    }

private:
    /// A smaller gain is rounding, or not worth a turn: the axes of a box that is parallel to the
    /// coordinate axes stay exact.
    static constexpr double kGain = 1e-9;

    void take(const Axes& candidate, double size) {
        if (!(size < volume * (1 - kGain))) return;
        volume = size;
        axes = candidate;
    }
};

/// Returns the points that are farthest along some directions.
std::vector<Point3> extremePoints(std::span<const Point3> points) {
    constexpr int kDirections = 400;
    std::vector<Point3> result;
    for (const Point3& direction : directions(kDirections)) {
        checkCancelled();
        const auto [low, high] = std::ranges::minmax_element(
            points, {}, [&](const Point3& point) { return dot(point, direction); });
        result.push_back(*low);
        result.push_back(*high);
    }
    std::ranges::sort(result);
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

/// Returns the axes in another order and with other signs. There are 24 right-handed choices; this
/// returns the one nearest to x, y and z.
Axes named(const Axes& axes) {
    std::array<std::size_t, 3> order = {0, 1, 2};
    Axes best = axes;
    double most = -std::numeric_limits<double>::infinity();
    do {
        Axes candidate;
        double sum = 0;
        std::size_t least = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            candidate[i] = axes[order[i]];
            if (candidate[i][i] < 0) candidate[i] = scaled(candidate[i], -1);
            sum += candidate[i][i];
            if (candidate[i][i] < candidate[least][least]) least = i;
        }
        if (dot(cross(candidate[0], candidate[1]), candidate[2]) < 0) {
            sum -= 2 * candidate[least][least];
            candidate[least] = scaled(candidate[least], -1);
        }
        // A smaller difference is rounding: the first of equal choices remains.
        if (sum > most + 1e-12) {
            most = sum;
            best = candidate;
        }
    } while (std::ranges::next_permutation(order).found);
    return best;
}

}  // namespace

Axes axesAlong(const Point3& direction) {
    // The coordinate axis that is farthest from parallel.
    std::size_t least = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (std::abs(direction[i]) < std::abs(direction[least])) least = i;
    const Point3 first = normalised(cross(kCoordinateAxes[least], direction));
    return {first, cross(direction, first), direction};
}

BoundingBox boxAlong(const Axes& axes, std::span<const Point3> points) {
    BoundingBox box;
    for (std::size_t i = 0; i < points.size(); ++i) {
        checkCancelledEvery(i, 16);
        const Point3& point = points[i];
        box.include({dot(point, axes[0]), dot(point, axes[1]), dot(point, axes[2])});
    }
    return box;
}

Axes smallestBox(std::span<const Point3> points, double padding) {
    // From every direction with few points; then from the best box with all points.
    constexpr int kStarts = 48;
    const std::vector<Point3> extremes = extremePoints(points);
    Search rough{extremes, padding};
    rough.start(kCoordinateAxes);
    for (const Point3& direction : directions(kStarts)) rough.start(axesAlong(direction));
    Search search{points, padding};
    search.start(kCoordinateAxes);
    search.start(rough.axes);
    return named(search.axes);
}

Axes smallestBoxAbout(std::size_t axis, std::span<const Point3> points, double padding) {
    Axes axes = kCoordinateAxes;
    turnAbout(axis, points, padding, axes);
    return axes;
}

}  // namespace espalier::shapes
