// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/bounding_box.h>
#include <espalier/base/number_text.h>
#include <espalier/base/parallel.h>
#include <espalier/base/vector3.h>
#include <espalier/solve/constraints.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace espalier::solve {
namespace {

using stencils::StencilTable;
using Triangle = std::array<Index, 3>;

/// Throws unless all points are finite, and their coordinates can be numbered.
void requirePoints(std::span<const Point3> points) {
    if (points.size() > static_cast<std::size_t>(kMaxIndex / 3))
        throw Error(concat("cannot number the coordinates of ", points.size(), " points"));
    for (std::size_t i = 0; i < points.size(); ++i)
        for (const double coordinate : points[i])
            if (!std::isfinite(coordinate))
                throw Error(concat("the position of point ", i, " is not finite"));
}

/// Throws unless all numbers are of points.
/// \param item what has the numbers: "triangle"; empty for a single list
template <class Numbers>
void requireNumbers(std::span<const Point3> points, const Numbers& numbers, const std::string& item,
                    std::size_t index) {
    for (const Index number : numbers)
        if (number < 0 || number >= std::ssize(points))
            throw Error(concat(item.empty() ? std::string() : concat(item, " ", index, ": "),
                               "there is no point ", number, "; there are ", points.size(),
                               ", numbered from 0"));
}

void requireTriangles(std::span<const Point3> points, std::span<const Triangle> triangles) {
    for (std::size_t t = 0; t < triangles.size(); ++t)
        requireNumbers(points, triangles[t], "triangle", t);
}

/// The derivatives of one measure by the points.
class Gradient {
public:
    void add(Index point, const Point3& derivative) { parts_.emplace_back(point, derivative); }

    /// Adds the derivatives to a row of a table.
    void addTo(stencils::RowAccumulator& row) const {
        for (const auto& [point, derivative] : parts_)
            for (std::size_t c = 0; c < 3; ++c)
                row.add(3 * point + static_cast<Index>(c), derivative[c]);
    }

private:
    std::vector<std::pair<Index, Point3>> parts_;
};

/// Makes a table with one row for each gradient.
StencilTable<double> tableOf(std::span<const Gradient> gradients, std::size_t pointCount) {
    return stencils::buildTable(
        static_cast<Index>(gradients.size()), 3 * static_cast<Index>(pointCount),
        [&](Index row, stencils::RowAccumulator& sums) { gradients[row].addTo(sums); });
}

/// Returns measures, if they are finite.
/// \throws Error if products of coordinates overflowed or vanished
Measures finite(Measures measures) {
    for (std::size_t k = 0; k < measures.values.size(); ++k)
        if (!std::isfinite(measures.values[k]))
            throw Error(concat("measure ", k,
                               " is not finite, since the points are too near or too far for its "
                               "products; scale the points nearer to 1"));
    return measures;
}

Measures one(double value, const Gradient& gradient, std::size_t pointCount) {
    return finite({{value}, tableOf(std::span(&gradient, 1), pointCount)});
}

/// The distance from `a` to `b`, and its derivative by `b`; the derivative by `a` is the opposite.
struct Distance {
    double length;
    Point3 direction;
};

/// Returns nothing if the points are at the same place.
std::optional<Distance> distanceOf(const Point3& a, const Point3& b) {
    const Point3 difference = espalier::difference(b, a);
    const double size = length(difference);
    if (!(size > 0)) return std::nullopt;
    return Distance{size, scaled(difference, 1 / size)};
}

/// A place on a triangle.
struct Crossing {
    std::size_t triangle;
    std::array<double, 3> weights;
    double at;  ///< along the line
};

/// Returns where a line meets a triangle; nothing if it does not. Places a little beside an edge
/// count, so that no line slips through between two triangles.
/// \cite Möller & Trumbore 1997, Fast, minimum storage ray/triangle intersection
std::optional<Crossing> meet(const Line& line, const Point3& a, const Point3& b, const Point3& c) {
    constexpr double kBeside = 1e-9;
    const Point3 ab = difference(b, a), ac = difference(c, a), arm = difference(line.point, a);
    const Point3 normal = cross(ab, ac);
    const double across = -dot(normal, line.direction);
    // A smaller value is rounding: the line is in the plane of the triangle.
    constexpr double kRounding = 1e-14;
    if (!(std::abs(across) > kRounding * length(normal) * length(line.direction)))
        return std::nullopt;
    const Point3 turned = cross(arm, line.direction);
    const double u = dot(ac, turned) / across, v = -dot(ab, turned) / across;
    if (u < -kBeside || v < -kBeside || u + v > 1 + kBeside) return std::nullopt;
    std::array<double, 3> weights = {std::max(1 - u - v, 0.0), std::max(u, 0.0), std::max(v, 0.0)};
    const double total = weights[0] + weights[1] + weights[2];
    for (double& weight : weights) weight /= total;
    return Crossing{0, weights, dot(normal, arm) / across};
}

/// Finds the first crossings of a line in its direction and in the opposite direction.
std::array<std::optional<Crossing>, 2> crossingsOf(const Line& line, std::span<const Point3> points,
                                                   std::span<const Triangle> triangles) {
    std::array<std::optional<Crossing>, 2> first;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto& [a, b, c] = triangles[t];
        std::optional<Crossing> found = meet(line, points[a], points[b], points[c]);
        if (!found) continue;
        found->triangle = t;
        std::optional<Crossing>& best = first[found->at > 0 ? 0 : 1];
        if (!best || std::abs(found->at) < std::abs(best->at)) best = found;
    }
    return first;
}

/// Throws unless each edge is in two triangles, in opposite directions.
void requireClosed(std::span<const Triangle> triangles) {
    // The edges from the lower to the higher point count 1, the others −1.
    std::vector<std::pair<std::array<Index, 2>, int>> edges;
    edges.reserve(3 * triangles.size());
    for (const Triangle& triangle : triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const Index a = triangle[k], b = triangle[(k + 1) % 3];
            edges.push_back({{std::min(a, b), std::max(a, b)}, a < b ? 1 : -1});
        }
    std::ranges::sort(edges);
    for (std::size_t first = 0; first < edges.size();) {
        const auto& [a, b] = edges[first].first;
        std::size_t last = first;
        int sum = 0;
        for (; last < edges.size() && edges[last].first == edges[first].first; ++last)
            sum += edges[last].second;
        if (sum != 0)
            throw Error(concat("the surface is not closed: the triangles at the edge from point ",
                               a, " to point ", b,
                               " are not pairs that run along it in opposite directions"));
        first = last;
    }
}

}  // namespace

Measures measureDistances(std::span<const Point3> points,
                          std::span<const std::array<Index, 2>> pairs) {
    requirePoints(points);
    Measures result;
    std::vector<Gradient> gradients;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        requireNumbers(points, pairs[k], "pair", k);
        const auto& [a, b] = pairs[k];
        const auto distance = distanceOf(points[a], points[b]);
        if (!distance)
            throw Error(concat("pair ", k, ": points ", a, " and ", b,
                               " are at the same place, where their distance has no derivative"));
        result.values.push_back(distance->length);
        Gradient& gradient = gradients.emplace_back();
        gradient.add(a, scaled(distance->direction, -1));
        gradient.add(b, distance->direction);
    }
    result.derivatives = tableOf(gradients, points.size());
    return finite(std::move(result));
}

StencilTable<double> findCrossings(std::span<const Point3> points,
                                   std::span<const Triangle> triangles,
                                   std::span<const Line> lines) {
    requirePoints(points);
    requireTriangles(points, triangles);
    std::vector<Line> unit;
    for (std::size_t k = 0; k < lines.size(); ++k) {
        for (const Point3& vector : {lines[k].point, lines[k].direction})
            for (const double coordinate : vector)
                if (!std::isfinite(coordinate)) throw Error(concat("line ", k, " is not finite"));
        if (!(length(lines[k].direction) > 0))
            throw ArgumentError("", concat("lines[", k, "].direction"), textOf(lines[k].direction),
                                "a vector other than 0");
        unit.push_back({lines[k].point, normalised(lines[k].direction)});
    }
    std::vector<std::array<std::optional<Crossing>, 2>> crossings(lines.size());
    parallelFor(std::ssize(lines), 1, [&](Offset k, Offset end) {
        for (; k < end; ++k) crossings[k] = crossingsOf(unit[k], points, triangles);
    });
    // A smaller distance is rounding: the point is on the surface.
    const double rounding = points.empty() ? 0 : 1e-9 * BoundingBox(points).diagonal();
    for (std::size_t k = 0; k < crossings.size(); ++k) {
        const auto& [ahead, behind] = crossings[k];
        for (const std::optional<Crossing>& side : crossings[k])
            if (side && std::abs(side->at) <= rounding)
                throw Error(concat("line ", k,
                                   ": its point is on the surface; give a point between the two "
                                   "sides of the shape"));
        if (!ahead || !behind)
            throw Error(concat("line ", k, " does not meet the surface ",
                               ahead ? "in the opposite direction" : "in its direction",
                               "; give a point between the two sides of the shape"));
    }
    return stencils::buildTable(
        2 * static_cast<Index>(lines.size()), static_cast<Index>(points.size()),
        [&](Index row, stencils::RowAccumulator& sums) {
            const Crossing& crossing = *crossings[row / 2][row % 2];
            for (std::size_t corner = 0; corner < 3; ++corner)
                sums.add(triangles[crossing.triangle][corner], crossing.weights[corner]);
        });
}

Measures measureThicknesses(std::span<const Point3> points, const StencilTable<double>& crossings) {
    requirePoints(points);
    if (crossings.rowCount() % 2 != 0 || crossings.columnCount() != std::ssize(points))
        throw Error(concat("the crossings are ", crossings.rowCount(), " × ",
                           crossings.columnCount(), "; expected two rows for each line, and ",
                           points.size(), " columns, one for each point"));
    Measures result;
    std::vector<Gradient> gradients;
    const auto placeOf = [&](Index row) {
        Point3 place = {0, 0, 0};
        for (std::size_t k = 0; k < crossings.columns(row).size(); ++k)
            place =
                sum(place, scaled(points[crossings.columns(row)[k]], crossings.weights(row)[k]));
        return place;
    };
    for (Index row = 0; row < crossings.rowCount(); row += 2) {
        const auto distance = distanceOf(placeOf(row + 1), placeOf(row));
        if (!distance)
            throw Error(concat("line ", row / 2,
                               ": the two sides are at the same place, where the thickness has no "
                               "derivative"));
        result.values.push_back(distance->length);
        Gradient& gradient = gradients.emplace_back();
        for (const auto& [side, sign] : {std::pair{row, 1.0}, std::pair{row + 1, -1.0}})
            for (std::size_t k = 0; k < crossings.columns(side).size(); ++k)
                gradient.add(crossings.columns(side)[k],
                             scaled(distance->direction, sign * crossings.weights(side)[k]));
    }
    result.derivatives = tableOf(gradients, points.size());
    return finite(std::move(result));
}

Measures measureVolume(std::span<const Point3> points, std::span<const Triangle> triangles) {
    requirePoints(points);
    requireTriangles(points, triangles);
    requireClosed(triangles);
    double volume = 0;
    Gradient gradient;
    // Measured from a point of the surface, so that a surface far from the origin loses no digits.
    const Point3 origin = triangles.empty() ? Point3{0, 0, 0} : points[triangles[0][0]];
    for (const auto& [a, b, c] : triangles) {
        const Point3 p = difference(points[a], origin), q = difference(points[b], origin),
                     r = difference(points[c], origin);
        volume += dot(p, cross(q, r)) / 6;
        gradient.add(a, scaled(cross(q, r), 1.0 / 6));
        gradient.add(b, scaled(cross(r, p), 1.0 / 6));
        gradient.add(c, scaled(cross(p, q), 1.0 / 6));
    }
    return one(volume, gradient, points.size());
}

Measures measureArea(std::span<const Point3> points, std::span<const Triangle> triangles) {
    requirePoints(points);
    requireTriangles(points, triangles);
    double area = 0;
    Gradient gradient;
    for (const auto& [a, b, c] : triangles) {
        const Point3 normal =
            cross(difference(points[b], points[a]), difference(points[c], points[a]));
        const double size = length(normal);
        if (!(size > 0)) continue;
        area += size / 2;
        const Point3 half = scaled(normal, 0.5 / size);
        gradient.add(a, cross(half, difference(points[c], points[b])));
        gradient.add(b, cross(half, difference(points[a], points[c])));
        gradient.add(c, cross(half, difference(points[b], points[a])));
    }
    return one(area, gradient, points.size());
}

Measures measureCurvatures(std::span<const Point3> points, std::span<const Index> line) {
    requirePoints(points);
    requireNumbers(points, line, "", 0);
    if (line.size() < 3)
        throw Error(concat("the line has ", line.size(), " points; expected three or more"));
    Measures result;
    std::vector<Gradient> gradients;
    const auto required = [&](Index a, Index b) {
        const auto distance = distanceOf(points[a], points[b]);
        if (!distance)
            throw Error(concat("points ", a, " and ", b,
                               " of the line are at the same place, where it has no curvature"));
        return *distance;
    };
    for (std::size_t k = 1; k + 1 < line.size(); ++k) {
        const Index a = line[k - 1], b = line[k], c = line[k + 1];
        const Distance ab = required(a, b), bc = required(b, c), ac = required(a, c);
        const Point3 p = difference(points[b], points[a]), q = difference(points[c], points[b]);
        const Point3 normal = cross(p, q);
        const double size = length(normal), product = ab.length * bc.length * ac.length;
        const double curvature = 2 * size / product;
        result.values.push_back(curvature);
        Gradient& gradient = gradients.emplace_back();
        if (!(size > 0)) continue;
        const Point3 unit = scaled(normal, 2 / (product * size));
        // Derivatives of the area by p and q, and of the logarithms of the three lengths.
        const Point3 byP = difference(cross(q, unit), scaled(ab.direction, curvature / ab.length));
        const Point3 byQ = difference(cross(unit, p), scaled(bc.direction, curvature / bc.length));
        const Point3 byAc = scaled(ac.direction, -curvature / ac.length);
        gradient.add(a, scaled(sum(byP, byAc), -1));
        gradient.add(b, difference(byP, byQ));
        gradient.add(c, sum(byQ, byAc));
    }
    result.derivatives = tableOf(gradients, points.size());
    return finite(std::move(result));
}

Measures measurePlanarity(std::span<const Point3> points, std::span<const Index> some) {
    requirePoints(points);
    requireNumbers(points, some, "", 0);
    if (some.size() < 3)
        throw Error(concat("there are ", some.size(), " points; expected three or more"));
    std::vector<Point3> chosen;
    chosen.reserve(some.size());
    for (const Index number : some) chosen.push_back(points[number]);
    const Point3 middle = mean(chosen);
    const double count = static_cast<double>(some.size());
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const Point3& point : chosen) {
        const Point3 arm = difference(point, middle);
        const Eigen::Map<const Eigen::Vector3d> vector(arm.data());
        moments += vector * vector.transpose() / count;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments);
    const Eigen::Vector3d axis = solver.eigenvectors().col(0);
    const Point3 normal = {axis[0], axis[1], axis[2]};
    double value = 0;
    Gradient gradient;
    for (std::size_t k = 0; k < some.size(); ++k) {
        // The normal is the best one, so that its own derivative does not count.
        const double distance = dot(difference(chosen[k], middle), normal);
        value += distance * distance / count;
        gradient.add(some[k], scaled(normal, 2 * distance / count));
    }
    return one(value, gradient, points.size());
}

StencilTable<double> byVertices(const StencilTable<double>& derivatives,
                                const StencilTable<double>& deformation) {
    if (Offset{derivatives.columnCount()} != 3 * Offset{deformation.rowCount()})
        throw Error(concat("the derivatives are by ", derivatives.columnCount(),
                           " coordinates; expected three for each of ", deformation.rowCount(),
                           " points"));
    if (deformation.columnCount() > kMaxIndex / 3)
        throw Error(
            concat("cannot number the coordinates of ", deformation.columnCount(), " vertices"));
    return stencils::buildTable(
        derivatives.rowCount(), 3 * deformation.columnCount(),
        [&](Index row, stencils::RowAccumulator& sums) {
            for (std::size_t k = 0; k < derivatives.columns(row).size(); ++k) {
                const Index coordinate = derivatives.columns(row)[k], point = coordinate / 3;
                for (std::size_t j = 0; j < deformation.columns(point).size(); ++j)
                    sums.add(3 * deformation.columns(point)[j] + coordinate % 3,
                             derivatives.weights(row)[k] * deformation.weights(point)[j]);
            }
        });
}

StencilTable<double> byVariables(const StencilTable<double>& derivatives,
                                 const StencilTable<double>& jacobian) {
    if (derivatives.columnCount() != jacobian.rowCount())
        throw Error(concat("the derivatives are by ", derivatives.columnCount(),
                           " coordinates; expected ", jacobian.rowCount(),
                           ", one for each row of the Jacobian"));
    return stencils::buildTable(
        derivatives.rowCount(), jacobian.columnCount(),
        [&](Index row, stencils::RowAccumulator& sums) {
            for (std::size_t k = 0; k < derivatives.columns(row).size(); ++k) {
                const Index coordinate = derivatives.columns(row)[k];
                for (std::size_t j = 0; j < jacobian.columns(coordinate).size(); ++j)
                    sums.add(jacobian.columns(coordinate)[j],
                             derivatives.weights(row)[k] * jacobian.weights(coordinate)[j]);
            }
        });
}

}  // namespace espalier::solve
