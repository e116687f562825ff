// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/selection.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "checks.h"
#include "distance_weights.h"

namespace espalier::shapes {

double weightAt(double distance, const Falloff& falloff) {
    if (distance <= 0) return 1;
    if (distance >= falloff.radius) return 0;
    const double u = distance / falloff.radius;
    return falloff.profile == Falloff::Profile::Linear ? 1 - u : 1 - u * u * (3 - 2 * u);
}

namespace {

/// Returns the weights, given a function that returns the distance of a position from the region.
template <class Distance>
std::vector<double> weightsFor(const std::string& function, std::span<const Point3> positions,
                               const Falloff& falloff, const Distance& distance) {
    return weightsOfDistances(function, positions, falloff,
                              [&](std::size_t i) { return distance(positions[i]); });
}

}  // namespace

std::vector<double> selectBox(std::span<const Point3> positions, const Point3& corner,
                              const Point3& opposite, const Falloff& falloff) {
    requireFinite("selectBox", "corner", corner);
    requireFinite("selectBox", "opposite", opposite);
    return weightsFor("selectBox", positions, falloff, [&](const Point3& position) {
        Point3 outside;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto [low, high] = std::minmax(corner[axis], opposite[axis]);
            outside[axis] = std::max({low - position[axis], position[axis] - high, 0.0});
        }
        return length(outside);
    });
}

std::vector<double> selectBall(std::span<const Point3> positions, const Point3& center,
                               double radius, const Falloff& falloff) {
    requireFinite("selectBall", "center", center);
    if (!(radius >= 0) || !std::isfinite(radius))
        throw ArgumentError("selectBall", "radius", textOf(radius), "a finite number of 0 or more");
    return weightsFor("selectBall", positions, falloff, [&](const Point3& position) {
        return length(difference(position, center)) - radius;
    });
}

std::vector<double> selectHalfSpace(std::span<const Point3> positions, const Point3& point,
                                    const Point3& normal, const Falloff& falloff) {
    requireFinite("selectHalfSpace", "point", point);
    const Point3 inwards = unitVector("selectHalfSpace", "normal", normal);
    return weightsFor("selectHalfSpace", positions, falloff, [&](const Point3& position) {
        return dot(difference(point, position), inwards);
    });
}

std::vector<double> selectEnd(std::span<const Point3> positions, const Point3& direction,
                              const Falloff& falloff) {
    const Point3 outwards = unitVector("selectEnd", "direction", direction);
    if (positions.empty()) throw Error("there are no positions");
    constexpr double kPart = 0.01;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Point3& position : positions) {
        low = std::min(low, dot(position, outwards));
        high = std::max(high, dot(position, outwards));
    }
    const double start = high - kPart * (high - low);
    return weightsFor("selectEnd", positions, falloff,
                      [&](const Point3& position) { return start - dot(position, outwards); });
}

std::vector<double> selectNumbers(std::span<const Point3> positions, std::span<const Index> numbers,
                                  const Falloff& falloff) {
    std::vector<char> isSelected(positions.size(), 0);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (numbers[i] < 0 || numbers[i] >= std::ssize(positions))
            throw ArgumentError("selectNumbers", indexed("numbers", i), std::to_string(numbers[i]),
                                concat("0 to ", std::ssize(positions) - 1));
        isSelected[numbers[i]] = 1;
    }
    return weightsFor("selectNumbers", positions, falloff, [&](const Point3& position) {
        if (isSelected[&position - positions.data()]) return 0.0;
        double nearest = std::numeric_limits<double>::infinity();
        if (falloff.radius > 0)
            for (const Index number : numbers)
                nearest = std::min(nearest, length(difference(position, positions[number])));
        return nearest;
    });
}

}  // namespace espalier::shapes
