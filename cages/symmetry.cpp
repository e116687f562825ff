// SPDX-License-Identifier: Apache-2.0
#include "symmetry.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "bins.h"
#include "point_groups.h"

namespace espalier::cages {
namespace {

/// A plane this near to 0, in diagonals, is at 0.
constexpr double kNearZero = 1e-6;

/// Largest difference between the faces of both sides: their mean distance from the plane, with a
/// sign for each side, in diagonals. Polygons that are not flat have other areas if they are
/// divided by another diagonal.
constexpr double kFaceTolerance = 0.01;

/// Points that count for the distance of a model that is not symmetric.
constexpr std::size_t kMaxProbes = 1000;

/// The points of a model in the cubes of a grid.
class PointSearch {
public:
    PointSearch(std::span<const Point3> points, const BoundingBox& box, double least)
        : points_(points),
          grid_(box.min, box.max, std::max(least, sizeOfCubes(box.diagonal(), points.size()))),
          bins_([&] {
              std::vector<Bins::Entry> entries;
              entries.reserve(points.size());
              for (std::size_t i = 0; i < points.size(); ++i) {
                  checkCancelledEvery(i, 16);
                  entries.push_back({grid_.cubeOf(points[i]), static_cast<Index>(i)});
              }
              return Bins(grid_.cubeCount(), entries);
          }()) {}

    /// Returns the distance of the nearest point, if it is in a cube at most `rings` rings away.
    double distance(const Point3& place, Index rings) const {
        const auto nearest = grid_.nearest(
            place, rings,
            [&](Index first, Index last, auto visit) {
                for (const Index point : bins_.itemsIn(first, last)) visit(point);
            },
            [&](Index point) -> const Point3& { return points_[point]; },
            [](Index) { return true; });
        return nearest ? length(difference(points_[*nearest], place)) : kInfinity;
    }

    Index ringCount() const { return *std::ranges::max_element(grid_.counts); }

private:
    static constexpr double kInfinity = std::numeric_limits<double>::infinity();

    static double sizeOfCubes(double diagonal, std::size_t count) {
        return diagonal / std::clamp(std::cbrt(static_cast<double>(count)) * 2, 4.0, 200.0);
    }

    std::span<const Point3> points_;
    CubeGrid grid_;
    Bins bins_;
};

Point3 mirrored(Point3 point, int axis, double at) {
    point[axis] = at - (point[axis] - at);
    return point;
}

/// Returns the largest distance of mirrored points from the points.
/// \param tolerance a larger distance is an estimate
double offOfPoints(std::span<const Point3> points, const PointSearch& search, int axis, double at,
                   double tolerance) {
    double most = 0;
    bool isSymmetric = true;
    for (std::size_t i = 0; i < points.size() && isSymmetric; ++i) {
        checkCancelledEvery(i, 10);
        most = std::max(most, search.distance(mirrored(points[i], axis, at), 1));
        isSymmetric = most <= tolerance;
    }
    if (isSymmetric) return most;
    most = 0;
    const std::size_t step = (points.size() + kMaxProbes - 1) / kMaxProbes;
    for (std::size_t i = 0; i < points.size(); i += step) {
        checkCancelledEvery(i, 4);
        most = std::max(most, search.distance(mirrored(points[i], axis, at), search.ringCount()));
    }
    // The point that was found first may not be among the probes.
    return std::max(most, std::nextafter(tolerance, 2 * tolerance + 1));
}

/// Returns the largest distance between moments of the area and its mirror image, in diagonals. The
/// moments of a symmetric surface that are odd across the plane are 0.
double offOfFaces(const ModelSurface& surface, const Point3& middle, double diagonal, int axis,
                  double at) {
    const auto& points = surface.points();
    constexpr std::size_t kMoments = 6;
    std::array<double, kMoments> sums = {};
    const int second = (axis + 1) % 3, third = (axis + 2) % 3;
    const auto add = [&](const Point3& place, double weight) {
        const double x = (place[axis] - at) / diagonal;
        const double y = 2 * (place[second] - middle[second]) / diagonal,
                     z = 2 * (place[third] - middle[third]) / diagonal;
        const std::array<double, kMoments> moments = {x,         x * y,     x * z,
                                                      x * y * y, x * z * z, 4 * x * x * x};
        for (std::size_t i = 0; i < kMoments; ++i) sums[i] += weight * moments[i];
    };
    double area = 0;
    std::size_t number = 0;
    for (const Triangle& t : surface.triangles()) {
        checkCancelledEvery(number++, 14);
        const Point3 way =
            cross(difference(points[t[1]], points[t[0]]), difference(points[t[2]], points[t[0]]));
        const double size = length(way) / 2;
        if (!(size > 0)) continue;
        area += size;
        // The rule of four points is exact for all moments, so that polygons may be divided by any
        // diagonals.
        const Point3 centre = scaled(sum(sum(points[t[0]], points[t[1]]), points[t[2]]), 1.0 / 3);
        add(centre, size * -27 / 48);
        for (const Index corner : t) add(between(centre, points[corner], 0.4), size * 25 / 48);
    }
    double most = 0;
    for (const double moment : sums) most = std::max(most, std::abs(moment));
    return area > 0 ? most / area : 0;
}

}  // namespace

std::array<ModelSymmetry::Plane, 3> measureSymmetry(const ModelSurface& surface, double tolerance) {
    const std::span<const Point3> points(surface.points().data(), surface.modelPointCount());
    const BoundingBox box(points);
    const double diagonal = box.diagonal();
    const PointSearch search(points, box, 1.01 * tolerance * diagonal);
    const Point3 middle = between(box.min, box.max, 0.5);
    std::array<ModelSymmetry::Plane, 3> planes;
    for (int axis = 0; axis < 3; ++axis) {
        const double unit = unitOfMirror(middle[axis], diagonal);
        double at = unit > 0 ? std::round(middle[axis] / unit) * unit : middle[axis];
        if (std::abs(at) <= kNearZero * diagonal) at = 0;
        const double off = offOfPoints(points, search, axis, at, tolerance * diagonal) / diagonal;
        const double ofFaces = offOfFaces(surface, middle, diagonal, axis, at);
        planes[axis].at = at;
        planes[axis].off =
            ofFaces > std::max(kFaceTolerance, tolerance) ? std::max(off, ofFaces) : off;
        planes[axis].isOfModel = planes[axis].off <= tolerance;
    }
    return planes;
}

double unitOfMirror(double at, double diagonal) {
    if (at == 0) return 0;
    // Lattices with the widest margins reach a few diagonals away from the model.
    constexpr double kReach = 64;
    int exponent = 0;
    std::frexp(std::abs(at) + kReach * diagonal, &exponent);
    return std::ldexp(1.0, exponent - 52);
}

void makeSymmetric(std::span<const VertexMirror> mirrors, std::span<Point3> positions) {
    for (const VertexMirror& mirror : mirrors)
        for (std::size_t vertex = 0; vertex < positions.size(); ++vertex) {
            const std::size_t image = mirror.images[vertex];
            if (image < vertex) continue;
            double& coordinate = positions[vertex][mirror.axis];
            if (image == vertex) {
                coordinate = mirror.at;
                continue;
            }
            double way = coordinate - mirror.at;
            if (mirror.unit > 0) way = std::round(way / mirror.unit) * mirror.unit;
            coordinate = mirror.at + way;
            positions[image] = positions[vertex];
            positions[image][mirror.axis] = mirror.at - way;
        }
}

void makeGradientSymmetric(std::span<const VertexMirror> mirrors, std::span<Point3> gradient) {
    for (const VertexMirror& mirror : mirrors)
        for (std::size_t vertex = 0; vertex < gradient.size(); ++vertex) {
            const std::size_t image = mirror.images[vertex];
            if (image < vertex) continue;
            Point3 reflected = gradient[image];
            reflected[mirror.axis] = -reflected[mirror.axis];
            gradient[vertex] = scaled(sum(gradient[vertex], reflected), 0.5);
            gradient[image] = gradient[vertex];
            if (image == vertex)
                gradient[vertex][mirror.axis] = 0;
            else
                gradient[image][mirror.axis] = -gradient[image][mirror.axis];
        }
}

namespace {

/// Returns a part of the diagonal: "8.3 %", or "2e-7 of the diagonal" for less than 0.1 %.
std::string partText(double part) {
    constexpr double kLeastPercent = 1e-3;
    if (part >= kLeastPercent) return concat(fixedText(100 * part, part < 0.0995 ? 1 : 0), " %");
    if (!(part > 0)) return "0";
    int exponent = static_cast<int>(std::floor(std::log10(part)));
    int digit = static_cast<int>(std::ceil(part / std::pow(10.0, exponent)));
    if (digit > 9) {
        digit = 1;
        ++exponent;
    }
    return concat(digit, "e", exponent, " of the diagonal");
}

/// Returns a number with at most eight digits.
std::string shortText(double number) {
    if (number == 0) return "0";
    const double scale = std::pow(10.0, 7 - std::floor(std::log10(std::abs(number))));
    return textOf(std::round(number * scale) / scale);
}

std::string joinedBy(const std::vector<std::string>& parts, std::string_view separator) {
    std::string text;
    for (const std::string& part : parts)
        text += (text.empty() ? "" : std::string(separator)) + part;
    return text;
}

}  // namespace

std::string symmetryText(const ModelSymmetry& symmetry) {
    if (!symmetry.isMeasured) return {};
    constexpr double kRounding = 1e-12;
    constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
    std::vector<std::string> used, lost, others;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const ModelSymmetry::Plane& plane = symmetry.planes[axis];
        const std::string place = concat(kNames[axis], " = ", shortText(plane.at));
        if (plane.isUsed && plane.isOfModel)
            used.push_back(plane.off > kRounding ? concat(place, " within ", partText(plane.off))
                                                 : place);
        else if (plane.isUsed)
            used.push_back(concat(place, " (the model is off by ", partText(plane.off), ")"));
        else if (plane.isOfModel)
            lost.push_back(place);
        else
            others.push_back(concat(partText(plane.off), " about ", kNames[axis]));
    }
    std::vector<std::string> parts;
    parts.push_back(used.empty() ? "not symmetric"
                                 : concat("symmetric about ", joinedBy(used, ", ")));
    if (!lost.empty())
        parts.push_back(concat("the model is symmetric about ", joinedBy(lost, ", "), ", too"));
    if (!others.empty()) parts.push_back(concat("off by ", joinedBy(others, ", ")));
    return joinedBy(parts, "; ");
}

}  // namespace espalier::cages
