// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/mirror_images.h>
#include <espalier/shapes/pose.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <espalier/shapes/smallest_box.h>
#include "checks.h"

namespace espalier::shapes::pose {
namespace {

/// The positions, and the weight of each.
struct Weighted {
    std::string operation;  ///< name in messages
    std::span<const Point3> positions;
    std::span<const double> weights;

    Weighted(const std::string& name, std::span<const Point3> points,
             std::span<const double> weightsOrNone)
        : operation(name), positions(points), weights(weightsOrNone) {
        if (!weights.empty() && weights.size() != positions.size())
            throw Error(concat("weights has ", weights.size(),
                               " numbers; expected one for each of the ", positions.size(),
                               " positions"));
        requireFinite("positions", positions);
        for (std::size_t i = 0; i < weights.size(); ++i)
            if (!(weights[i] >= 0 && weights[i] <= 1))
                throw Error(concat(indexed("weights", i), " is ", weights[i], "; expected 0 to 1"));
    }

    double weight(std::size_t i) const { return weights.empty() ? 1 : weights[i]; }

    /// Returns the box, along some axes, around the positions whose weight is above 0.
    BoundingBox bounds(const Axes& axes) const {
        std::vector<Point3> moved;
        for (std::size_t i = 0; i < positions.size(); ++i)
            if (weight(i) > 0) moved.push_back(positions[i]);
        if (moved.empty()) throw Error("no position has a weight above 0");
        return boxAlong(axes, moved);
    }

    /// Returns the centre that the options ask for.
    Point3 center(const Options& options) const {
        if (options.center) {
            requireFinite(operation, "center", *options.center);
            return *options.center;
        }
        const BoundingBox box = bounds(kCoordinateAxes);
        return between(box.min, box.max, 0.5);
    }

    /// Returns map(position, weight) for each position with a weight above 0, and the others as
    /// they are.
    /// \throws Error if a result is too large for a number
    template <class Map>
    std::vector<Point3> mapped(const Map& map) const {
        return mappedEach([&](std::size_t, const Point3& p, double w) { return map(p, w); });
    }

    /// The same for map(number of the position, position, weight).
    template <class Map>
    std::vector<Point3> mappedEach(const Map& map) const {
        std::vector<Point3> result(positions.begin(), positions.end());
        for (std::size_t i = 0; i < result.size(); ++i) {
            checkCancelledEvery(i, 14);
            if (!(weight(i) > 0)) continue;
            result[i] = map(i, positions[i], weight(i));
            if (!isFinite(result[i]))
                throw Error(concat("position ", i, " moves to ", textOf(result[i]),
                                   "; expected finite numbers: an argument or the position is too "
                                   "large"));
        }
        return result;
    }
};

/// An axis through a centre, and the interval along it in which an operation varies.
struct AxisInterval {
    Point3 axis, center;
    double low, high;

    double fraction(double s) const { return std::clamp((s - low) / (high - low), 0.0, 1.0); }

    /// Returns the point of the axis that is nearest to a position.
    Point3 foot(const Point3& position) const {
        return sum(center, scaled(axis, dot(difference(position, center), axis)));
    }
};

AxisInterval along(const Weighted& moved, const Point3& axis, const Options& options) {
    const Point3 direction = unitVector(moved.operation, "axis", axis);
    AxisInterval result{direction, moved.center(options), 0, 0};
    if (options.range) {
        requireInterval(moved.operation, "range[0]", (*options.range)[0], "range[1]",
                        (*options.range)[1]);
        result.low = (*options.range)[0];
        result.high = (*options.range)[1];
        return result;
    }
    const BoundingBox bounds = moved.bounds(axesAlong(direction));
    result.low = bounds.min[2];
    result.high = bounds.max[2];
    if (options.startsAtCenter && options.center) result.low = dot(result.center, direction);
    // Less is the rounding of equal coordinates.
    constexpr double kRounding = 1e-12;
    const double size = std::max(std::abs(result.low), std::abs(result.high));
    if (!(result.high - result.low > kRounding * size))
        throw ArgumentError(
            moved.operation, "range", "none",
            options.startsAtCenter && options.center
                ? "two numbers, since no selected position lies beyond the centre along the axis"
                : "two numbers, since the selected positions are all at one place along the axis");
    return result;
}

/// Adds the displacement by Rodrigues' formula, so that an angle of 0 changes no bit.
/// \param axis a unit vector
Point3 rotated(const Point3& position, const Point3& axis, const Point3& center, double angle) {
    const Point3 across = cross(axis, difference(position, center));
    const double half = std::sin(angle / 2);
    return sum(position,
               sum(scaled(across, std::sin(angle)), scaled(cross(axis, across), 2 * half * half)));
}

/// Returns sin(x) / x.
double sinc(double x) {
    return x == 0 ? 1 : std::sin(x) / x;
}

}  // namespace

std::vector<Point3> move(std::span<const Point3> positions, const Point3& offset,
                         std::span<const double> weights) {
    requireFinite("move", "offset", offset);
    return Weighted("move", positions, weights).mapped([&](const Point3& p, double w) {
        return sum(p, scaled(offset, w));
    });
}

std::vector<Point3> displace(std::span<const Point3> positions,
                             std::span<const Point3> displacements,
                             std::span<const double> weights) {
    const Weighted moved("displace", positions, weights);
    if (displacements.size() != positions.size())
        throw Error(concat("displacements has ", displacements.size(),
                           " vectors; expected one for each of the ", positions.size(),
                           " positions"));
    requireFinite("displacements", displacements);
    return moved.mappedEach([&](std::size_t i, const Point3& p, double w) {
        return sum(p, scaled(displacements[i], w));
    });
}

std::vector<Point3> rotate(std::span<const Point3> positions, const Point3& axis, double angle,
                           const Options& options) {
    const Weighted moved("rotate", positions, options.weights);
    const Point3 direction = unitVector("rotate", "axis", axis), center = moved.center(options);
    requireFinite("rotate", "angle", angle);
    return moved.mapped(
        [&](const Point3& p, double w) { return rotated(p, direction, center, w * angle); });
}

std::vector<Point3> scale(std::span<const Point3> positions, const Point3& factors,
                          const Options& options) {
    const Weighted moved("scale", positions, options.weights);
    requireFinite("scale", "factors", factors);
    const Point3 center = moved.center(options);
    return moved.mapped([&](const Point3& p, double w) {
        Point3 result = p;
        for (std::size_t i = 0; i < 3; ++i) result[i] += w * (factors[i] - 1) * (p[i] - center[i]);
        return result;
    });
}

std::vector<Point3> twist(std::span<const Point3> positions, const Point3& axis, double angle,
                          const Options& options) {
    const Weighted moved("twist", positions, options.weights);
    const AxisInterval line = along(moved, axis, options);
    requireFinite("twist", "angle", angle);
    return moved.mapped([&](const Point3& p, double w) {
        return rotated(p, line.axis, line.center, w * angle * line.fraction(dot(p, line.axis)));
    });
}

std::vector<Point3> bend(std::span<const Point3> positions, const Point3& axis, double angle,
                         const Point3& toward, const Options& options) {
    const Weighted moved("bend", positions, options.weights);
    const AxisInterval line = along(moved, axis, options);
    requireFinite("bend", "angle", angle);
    const Point3 target = unitVector("bend", "toward", toward);
    const Point3 across = difference(target, scaled(line.axis, dot(target, line.axis)));
    // Less is the rounding of a parallel vector.
    constexpr double kRounding = 1e-9;
    if (!(length(across) > kRounding))
        throw ArgumentError("bend", "toward", textOf(toward),
                            "a vector that is not parallel to the axis");
    const Point3 normal = normalised(across);
    return moved.mapped([&](const Point3& p, double w) {
        const double s = dot(p, line.axis), r = dot(difference(p, line.center), normal);
        const double inside = std::clamp(s, line.low, line.high) - line.low,
                     beyond = s - line.low - inside;
        const double theta = w * angle * inside / (line.high - line.low);
        // sin(θ) / k and (1 − cos(θ)) / k, for k = θ / inside that may be 0.
        const double arc = inside * sinc(theta);
        const double half = std::sin(theta / 2), rise = inside * half * sinc(theta / 2);
        // The changes of s and r, so that an angle of 0 changes no bit. cos(θ) − 1 is −2 sin²(θ/2).
        const double sine = std::sin(theta), cosineLess1 = -2 * half * half;
        const double alongAxis = arc - inside - sine * r + cosineLess1 * beyond;
        const double acrossAxis = rise + cosineLess1 * r + sine * beyond;
        return sum(p, sum(scaled(line.axis, alongAxis), scaled(normal, acrossAxis)));
    });
}

std::vector<Point3> taper(std::span<const Point3> positions, const Point3& axis, double factor,
                          const Options& options) {
    const Weighted moved("taper", positions, options.weights);
    const AxisInterval line = along(moved, axis, options);
    requireFinite("taper", "factor", factor);
    if (factor < 0) throw ArgumentError("taper", "factor", textOf(factor), "0 or more");
    return moved.mapped([&](const Point3& p, double w) {
        const double change = w * (factor - 1) * line.fraction(dot(p, line.axis));
        return sum(p, scaled(difference(p, line.foot(p)), change));
    });
}

namespace {

/// Returns for each position with an image whether it decides where its image is.
std::vector<bool> leaders(const Weighted& chosen, std::span<const Point3> rest,
                          std::span<const Index> images, int axis) {
    // Which of the two is on which side follows from the two alone, also near the plane.
    const auto isUpper = [&](std::size_t i) { return rest[i][axis] > rest[images[i]][axis]; };
    double upper = 0, lower = 0;
    for (std::size_t i = 0; i < rest.size(); ++i)
        if (images[i] >= 0 && images[i] != static_cast<Index>(i))
            (isUpper(i) ? upper : lower) += chosen.weight(i);
    std::vector<bool> result(rest.size());
    for (std::size_t i = 0; i < rest.size(); ++i) {
        if (images[i] < 0) continue;
        const double own = chosen.weight(i), other = chosen.weight(images[i]);
        result[i] = own != other ? own > other : own > 0 && isUpper(i) == (upper >= lower);
    }
    return result;
}

}  // namespace

Mirrored mirror(std::span<const Point3> rest, std::span<const Point3> positions, int axis,
                std::span<const double> weights, std::optional<double> plane) {
    const Weighted chosen("mirror", positions, weights);
    if (rest.size() != positions.size())
        throw Error(
            concat("rest has ", rest.size(), " positions, and there are ", positions.size()));
    requireFinite("rest", rest);
    const BoundingBox box(rest);
    if (plane) requireFinite("mirror", "plane", *plane);
    if (axis < 0 || axis > 2) throw ArgumentError("mirror", "axis", std::to_string(axis), "0 to 2");
    Mirrored result;
    result.positions.assign(positions.begin(), positions.end());
    if (rest.empty()) return result;
    result.plane = plane.value_or(between(box.min, box.max, 0.5)[axis]);
    constexpr double kTolerance = 1e-3;  // see above
    const auto images = mirrorImages(rest, axis, result.plane, kTolerance * box.diagonal());
    const auto leads = leaders(chosen, rest, images, axis);
    for (std::size_t i = 0; i < rest.size(); ++i) {
        const Index image = images[i];
        if (!(chosen.weight(i) > 0)) continue;
        ++(image < 0 ? result.withoutImage : result.withImage);
        if (image == static_cast<Index>(i)) {
            result.positions[i][axis] = result.plane;
        } else if (image >= 0 && leads[i]) {
            result.positions[image] = positions[i];
            result.positions[image][axis] = 2 * result.plane - positions[i][axis];
        }
    }
    requireFinite("mirrored positions", result.positions);
    if (result.withImage == 0)
        throw Error(concat("mirror: no position with a weight above 0 has a mirror image at ",
                           std::string(1, "xyz"[axis]), " = ", textOf(result.plane),
                           "; the lattice at rest is not symmetric there"));
    return result;
}

}  // namespace espalier::shapes::pose
