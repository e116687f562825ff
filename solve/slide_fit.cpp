// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "principal_axes.h"
#include "rotation_fit.h"
#include "slide_fit.h"

namespace espalier::solve {
namespace {

using Kind = SlideShape::Kind;

Point3 toPoint(const Eigen::Vector3d& vector) {
    return {vector[0], vector[1], vector[2]};
}

/// Returns the axis of coordinates that is nearest to a direction.
Point3 nearestAxis(const Point3& direction) {
    std::size_t largest = 0;
    for (std::size_t c = 1; c < 3; ++c)
        if (std::abs(direction[c]) > std::abs(direction[largest])) largest = c;
    Point3 axis = {};
    axis[largest] = 1;
    return axis;
}

FittedShape withDistance(const SlideShape& shape, std::span<const Index> points,
                         std::span<const Point3> places) {
    FittedShape fitted{shape};
    for (const Index point : points)
        fitted.distance = std::max(fitted.distance, distanceFrom(shape, places[point]));
    return fitted;
}

/// Returns true if `other` fits as well as `fitted`, which is of the same points: a shape that fits
/// best is off by the rounding of its direction, too.
bool isAsGood(const FittedShape& other, const FittedShape& fitted, double size) {
    constexpr double kRounding = 32 * std::numeric_limits<double>::epsilon();
    return other.distance <= 2 * fitted.distance + kRounding * size;
}

/// Returns the size of coordinates and of their box, whose rounding the distances have.
double roundedSize(std::span<const Index> points, std::span<const Point3> places) {
    double size = 0;
    for (const Index point : points)
        for (const double coordinate : places[point]) size = std::max(size, std::abs(coordinate));
    return size;
}

/// Fits a line or a plane, whose direction is one of the principal axes.
FittedShape fitFlat(Kind kind, std::span<const Index> points, std::span<const Point3> places) {
    const PrincipalAxes axes(points, places);
    SlideShape shape{kind, axes.mean, axes.directions[kind == Kind::Line ? 0 : 2]};
    const FittedShape fitted = withDistance(shape, points, places);
    shape.direction = nearestAxis(shape.direction);
    // The mean is rounded; a plane across an axis goes exactly through the first point.
    shape.origin = places[points[0]];
    const FittedShape along = withDistance(shape, points, places);
    return isAsGood(along, fitted, roundedSize(points, places)) ? along : fitted;
}

/// Points about their mean, in the unit of their size, so that fits need no scale.
struct Normalised {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double size = 1;
    Eigen::Matrix3Xd places;

    Normalised(std::span<const Index> points, std::span<const Point3> all)
        : places(3, static_cast<Eigen::Index>(points.size())) {
        const Eigen::Vector3d first = toEigen(all[points[0]]);
        for (Eigen::Index i = 0; i < places.cols(); ++i)
            places.col(i) = toEigen(all[points[std::size_t(i)]]) - first;
        const Eigen::Vector3d offset = places.rowwise().mean();
        places.colwise() -= offset;
        mean = first + offset;
        size = std::sqrt(places.colwise().squaredNorm().maxCoeff());
        if (size > 0) places /= size;
    }
};

/// A cylinder in normalised places.
struct Tube {
    Eigen::Vector3d axis, centre;
    double radius = 0;
};

/// Returns two vectors of length 1 across an axis and each other.
std::pair<Eigen::Vector3d, Eigen::Vector3d> across(const Eigen::Vector3d& axis) {
    const Eigen::Vector3d first = axis.unitOrthogonal();
    return {first, axis.cross(first)};
}

/// Fits the circle of a cylinder with a given axis, by an equation that is linear in its unknowns:
/// |x|² + d · x + f = 0.
Tube tubeAlong(const Eigen::Vector3d& axis, const Eigen::Matrix3Xd& places) {
    const auto [first, second] = across(axis);
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < places.cols(); ++i) {
        const Eigen::Vector3d row(first.dot(places.col(i)), second.dot(places.col(i)), 1);
        products += row * row.transpose();
        right -= row * (row[0] * row[0] + row[1] * row[1]);
    }
    const Eigen::Vector3d solution = products.completeOrthogonalDecomposition().solve(right);
    const Eigen::Vector3d centre = -0.5 * (solution[0] * first + solution[1] * second);
    const double square = centre.squaredNorm() - solution[2];
    return {axis, centre, std::sqrt(std::max(square, 0.0))};
}

double squaresOf(const Tube& tube, const Eigen::Matrix3Xd& places) {
    double squares = 0;
    for (Eigen::Index i = 0; i < places.cols(); ++i) {
        const Eigen::Vector3d offset = places.col(i) - tube.centre;
        const double distance = (offset - tube.axis * tube.axis.dot(offset)).norm() - tube.radius;
        squares += distance * distance;
    }
    return squares;
}

/// Improves a cylinder by the method of Levenberg and Marquardt.
/// \param turns whether the axis may turn
Tube improved(Tube tube, const Eigen::Matrix3Xd& places, bool turns) {
    constexpr int kMaxSteps = 60;
    double damping = 1e-3, squares = squaresOf(tube, places);
    for (int step = 0; step < kMaxSteps && damping < 1e8; ++step) {
        const auto [first, second] = across(tube.axis);
        Eigen::Matrix<double, 5, 5> products = Eigen::Matrix<double, 5, 5>::Zero();
        Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
        for (Eigen::Index i = 0; i < places.cols(); ++i) {
            const Eigen::Vector3d offset = places.col(i) - tube.centre;
            const double along = tube.axis.dot(offset);
            const Eigen::Vector3d radial = offset - tube.axis * along;
            const double length = radial.norm();
            if (!(length > 0)) continue;
            const double x = radial.dot(first) / length, y = radial.dot(second) / length;
            // Derivatives of |radial| − r by the centre, the radius and the turns of the axis.
            Eigen::Matrix<double, 5, 1> row;
            row << -x, -y, -1, turns ? -along * x : 0, turns ? -along * y : 0;
            products += row * row.transpose();
            right -= row * (length - tube.radius);
        }
        Eigen::Matrix<double, 5, 5> damped = products;
        // Unknowns without a derivative, as the turns of a fixed axis, stay.
        for (Eigen::Index i = 0; i < 5; ++i)
            damped(i, i) += damping * products(i, i) + std::numeric_limits<double>::min();
        const Eigen::Matrix<double, 5, 1> change =
            damped.completeOrthogonalDecomposition().solve(right);
        Tube next = tube;
        next.centre += change[0] * first + change[1] * second;
        next.radius += change[2];
        if (turns) next.axis = (tube.axis + change[3] * first + change[4] * second).normalized();
        const double smaller = squaresOf(next, places);
        if (smaller < squares) {
            const bool isDone = smaller > 0.999 * squares;
            tube = next;
            squares = smaller;
            damping *= 0.1;
            if (isDone) break;
        } else {
            damping *= 10;
        }
    }
    return tube;
}

SlideShape shapeOfTube(Kind kind, const Tube& tube, const Normalised& points) {
    return {kind, toPoint(points.mean + points.size * tube.centre), toPoint(tube.axis),
            points.size * tube.radius};
}

/// Returns directions that cover half of the unit sphere, 7 degrees apart.
std::vector<Eigen::Vector3d> someDirections() {
    constexpr int kCount = 480;
    std::vector<Eigen::Vector3d> directions;
    for (int i = 0; i < kCount; ++i) {
        const double z = (i + 0.5) / kCount, radius = std::sqrt(1 - z * z);
        const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));  // the golden angle
        directions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
    return directions;
}

}  // namespace

Point3 fromAxis(const SlideShape& shape, const Point3& place) {
    const Point3 offset = difference(place, shape.origin);
    return difference(offset, scaled(shape.direction, dot(offset, shape.direction)));
}

double distanceFrom(const SlideShape& shape, const Point3& place) {
    const auto fromPlane = [&] {
        return std::abs(dot(difference(place, shape.origin), shape.direction));
    };
    if (shape.kind == Kind::Plane) return fromPlane();
    const double radius = length(fromAxis(shape, place));
    if (shape.kind == Kind::Line) return radius;
    const double fromCylinder = std::abs(radius - shape.radius);
    return shape.kind == Kind::Cylinder ? fromCylinder : length({fromCylinder, fromPlane(), 0});
}

FittedShape fitLine(std::span<const Index> points, std::span<const Point3> places) {
    return fitFlat(Kind::Line, points, places);
}

FittedShape fitPlane(std::span<const Index> points, std::span<const Point3> places) {
    return fitFlat(Kind::Plane, points, places);
}

FittedShape fitCircle(std::span<const Index> points, std::span<const Point3> places) {
    const SlideShape plane = fitPlane(points, places).shape;
    const Normalised normalised(points, places);
    const Eigen::Vector3d axis = toEigen(plane.direction);
    const Tube tube = improved(tubeAlong(axis, normalised.places), normalised.places, false);
    SlideShape shape = shapeOfTube(Kind::Circle, tube, normalised);
    // The centre is in the plane.
    const double off = dot(difference(shape.origin, plane.origin), plane.direction);
    shape.origin = difference(shape.origin, scaled(plane.direction, off));
    return withDistance(shape, points, places);
}

FittedShape fitCylinder(std::span<const Index> points, std::span<const Point3> places) {
    const Normalised all(points, places);
    constexpr std::size_t kMaxSamples = 300;
    std::vector<Index> samples;
    const std::size_t count = std::min(points.size(), kMaxSamples);
    for (std::size_t i = 0; i < count; ++i) samples.push_back(points[i * points.size() / count]);
    const Normalised some(samples, places);
    // Long cylinders need an exact first direction, which is a principal axis.
    std::vector<Eigen::Vector3d> directions = someDirections();
    for (const Point3& direction : PrincipalAxes(points, places).directions)
        directions.push_back(toEigen(direction));
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < directions.size(); ++i)
        order.emplace_back(squaresOf(tubeAlong(directions[i], some.places), some.places), i);
    std::ranges::sort(order);
    constexpr std::size_t kImproved = 6;
    Tube best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < kImproved; ++i) {
        const Eigen::Vector3d& direction = directions[order[i].second];
        const Tube tube = improved(tubeAlong(direction, some.places), some.places, true);
        const double squares = squaresOf(tube, some.places);
        if (!(squares < least)) continue;
        least = squares;
        best = tube;
    }
    const Tube tube = improved(tubeAlong(best.axis, all.places), all.places, true);
    const FittedShape fitted = withDistance(shapeOfTube(Kind::Cylinder, tube, all), points, places);
    const Eigen::Vector3d axis = toEigen(nearestAxis(fitted.shape.direction));
    const Tube straight = improved(tubeAlong(axis, all.places), all.places, false);
    const FittedShape along =
        withDistance(shapeOfTube(Kind::Cylinder, straight, all), points, places);
    return isAsGood(along, fitted, roundedSize(points, places)) ? along : fitted;
}

}  // namespace espalier::solve
