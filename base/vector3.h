// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

// Vector arithmetic for sources; not installed.
namespace espalier {

inline Point3 sum(const Point3& a, const Point3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline Point3 difference(const Point3& a, const Point3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline Point3 scaled(const Point3& a, double factor) {
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}

/// Returns the point from a (at t = 0) to b (at t = 1), exactly at both ends.
inline Point3 between(const Point3& a, const Point3& b, double t) {
    return {std::lerp(a[0], b[0], t), std::lerp(a[1], b[1], t), std::lerp(a[2], b[2], t)};
}

inline double dot(const Point3& a, const Point3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Point3 cross(const Point3& a, const Point3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Returns a times the power of two that brings its largest component to between 1 and 2, so that
/// products with the result do not vanish or overflow. A power of two is exact: vectors of common
/// lengths keep their digits. Returns the zero vector for itself.
/// \param a finite
inline Point3 scaledNearOne(const Point3& a) {
    const double largest = std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])});
    if (!(largest > 0)) return a;
    const int exponent = std::ilogb(largest);
    return {std::scalbn(a[0], -exponent), std::scalbn(a[1], -exponent),
            std::scalbn(a[2], -exponent)};
}

/// Returns the vector of length 1 in the direction of a. The length of a may be a denormal, or
/// overflow.
/// \param a not the zero vector, finite
inline Point3 normalised(const Point3& a) {
    const Point3 near1 = scaledNearOne(a);
    return scaled(near1, 1 / length(near1));
}

/// Returns the mean of one or more points.
inline bool isFinite(const Point3& point) {
    return std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
}

inline Point3 mean(std::span<const Point3> points) {
    Point3 total = {0, 0, 0};
    for (const Point3& point : points) total = sum(total, point);
    return scaled(total, 1 / static_cast<double>(points.size()));
}

/// Returns half the sum of the cross products around a loop. Its length is the area of a flat loop,
/// and it points to the side from which the loop runs anticlockwise.
inline Point3 areaVector(std::span<const Point3> loop) {
    Point3 total = {0, 0, 0};
    // Relative to a corner of the loop, so that a loop far from the origin loses no digits.
    for (std::size_t i = 2; i < loop.size(); ++i)
        total = sum(total, cross(difference(loop[i - 1], loop[0]), difference(loop[i], loop[0])));
    return scaled(total, 0.5);
}

}  // namespace espalier
