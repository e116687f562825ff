// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace espalier::embed {

/// Converts lengths to and from units near the size of a lattice. Squares of lengths like 1e200 or
/// 1e-200 overflow or underflow; squares of lengths in units do not. The unit is a power of two, so
/// lattices whose sizes differ by a power of two give the same results to the last bit.
class LengthUnit {
public:
    /// \param positions of the lattice's vertices; if a coordinate is not finite, the unit is 1
    explicit LengthUnit(std::span<const Point3> positions) {
        double largest = 0;
        for (const Point3& position : positions)
            for (const double coordinate : position)
                largest = std::max(largest, std::abs(coordinate));
        // If all vertices are at the origin, any other point is far away.
        if (largest == 0) largest = std::numeric_limits<double>::denorm_min();
        int exponent = 0;
        if (std::isfinite(largest)) std::frexp(largest, &exponent);
        // In two factors: the inverse of the smallest double would overflow.
        half_ = std::ldexp(1, exponent / 2);
        rest_ = std::ldexp(1, exponent - exponent / 2);
    }

    /// A finite length stays finite.
    double toUnits(double length) const {
        const double units = length / half_ / rest_;
        if (!std::isinf(units) || !std::isfinite(length)) return units;
        return std::copysign(std::numeric_limits<double>::max(), length);
    }
    double fromUnits(double length) const { return length * half_ * rest_; }
    Point3 toUnits(const Point3& point) const {
        return {toUnits(point[0]), toUnits(point[1]), toUnits(point[2])};
    }
    Point3 fromUnits(const Point3& point) const {
        return {fromUnits(point[0]), fromUnits(point[1]), fromUnits(point[2])};
    }
    std::vector<Point3> toUnits(std::span<const Point3> points) const {
        std::vector<Point3> result;
        result.reserve(points.size());
        for (const Point3& point : points) result.push_back(toUnits(point));
        return result;
    }

private:
    double half_, rest_;
};

}  // namespace espalier::embed
