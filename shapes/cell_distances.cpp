// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/cell_distances.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace espalier::shapes {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Returns the point of a segment that is nearest to the origin.
Point3 nearestOnSegment(const Point3& a, const Point3& b) {
    const Point3 along = difference(b, a);
    const double square = dot(along, along);
    const double t = square > 0 ? std::clamp(-dot(a, along) / square, 0.0, 1.0) : 0;
    return sum(a, scaled(along, t));
}

/// Returns the distance of a triangle from the origin: the distance of its plane, or of one side.
double distanceOfTriangle(const std::array<Point3, 3>& corners) {
    const auto& [a, b, c] = corners;
    const Point3 normal = cross(difference(b, a), difference(c, a));
    const double size = length(normal);
    const auto isInside = [&](const Point3& from, const Point3& to) {
        return dot(cross(difference(to, from), scaled(from, -1)), normal) >= 0;
    };
    if (size > 0 && isInside(a, b) && isInside(b, c) && isInside(c, a))
        return std::abs(dot(a, normal)) / size;
    return std::min({length(nearestOnSegment(a, b)), length(nearestOnSegment(b, c)),
                     length(nearestOnSegment(c, a))});
}

double distanceOfFace(const Point3& point, const std::vector<Point3>& loop) {
    const Point3 middle = difference(mean(loop), point);
    double least = kInfinite;
    for (std::size_t i = 0; i < loop.size(); ++i)
        least = std::min(
            least, distanceOfTriangle({difference(loop[i], point),
                                       difference(loop[(i + 1) % loop.size()], point), middle}));
    return least;
}

}  // namespace

std::vector<double> distancesAlongCells(const far::CellComplex& complex,
                                        std::span<const Point3> positions,
                                        std::span<const WayStart> starts) {
    std::vector<double> distances(positions.size(), kInfinite);
    using Way = std::pair<double, Index>;  // the length, and the vertex at the end
    std::priority_queue<Way, std::vector<Way>, std::greater<>> ways;
    const auto reach = [&](Index vertex, double distance) {
        if (!(distance < distances[vertex])) return;
        distances[vertex] = distance;
        ways.emplace(distance, vertex);
    };
    for (const WayStart& start : starts) reach(start.vertex, start.length);
    const auto& cellsAt = complex.relation(0, 3);
    const auto& verticesOf = complex.relation(3, 0);
    for (Offset step = 0; !ways.empty(); ++step) {
        checkCancelledEvery(step, 10);
        const auto [distance, vertex] = ways.top();
        ways.pop();
        if (distance > distances[vertex]) continue;
        for (const Index cell : cellsAt[vertex])
            for (const Index other : verticesOf[cell])
                reach(other, distance + length(difference(positions[other], positions[vertex])));
    }
    return distances;
}

std::vector<WayStart> waysFrom(const Point3& point, const far::CellComplex& complex,
                               std::span<const Point3> positions, Index cell) {
    std::vector<WayStart> starts;
    for (const Index vertex : complex.relation(3, 0)[cell])
        starts.push_back({vertex, length(difference(positions[vertex], point))});
    return starts;
}

Index nearestFace(const far::CellComplex& complex, std::span<const Point3> positions,
                  const Point3& point, bool betweenCells) {
    Index nearest = -1;
    double least = kInfinite;
    for (Index face = 0; face < complex.count(2); ++face) {
        checkCancelledEvery(face, 12);
        if (betweenCells && complex.relation(2, 3)[face].size() != 2) continue;
        const double distance = distanceOfFace(point, loopOf(complex, positions, face));
        if (nearest >= 0 && !(distance < least)) continue;
        nearest = face;
        least = distance;
    }
    return nearest;
}

Index nearestCell(const far::CellComplex& complex, std::span<const Point3> positions,
                  const Point3& point) {
    const Index face = nearestFace(complex, positions, point);
    const auto cells = complex.relation(2, 3)[face];
    const auto loop = loopOf(complex, positions, face);
    const Point3 normal = areaVector(loop), middle = mean(loop);
    const double side = dot(normal, difference(point, middle));
    for (const Index cell : cells) {
        const Point3 inwards = difference(cellMiddle(complex, positions, cell), middle);
        if (dot(normal, inwards) * side > 0) return cell;
    }
    return cells.front();
}

std::vector<Point3> loopOf(const far::CellComplex& complex, std::span<const Point3> positions,
                           Index face) {
    std::vector<Point3> loop;
    for (const Index vertex : complex.relation(2, 0)[face]) loop.push_back(positions[vertex]);
    return loop;
}

double cellVolume(const far::CellComplex& complex, std::span<const Point3> positions, Index cell) {
    const Point3 top = cellMiddle(complex, positions, cell);
    double volume = 0;
    for (const Index face : complex.relation(3, 2)[cell]) {
        const auto loop = loopOf(complex, positions, face);
        const Point3 middle = difference(mean(loop), top);
        for (std::size_t i = 0; i < loop.size(); ++i)
            volume += std::abs(dot(middle, cross(difference(loop[i], top),
                                                 difference(loop[(i + 1) % loop.size()], top)))) /
                      6;
    }
    return volume;
}

Point3 cellMiddle(const far::CellComplex& complex, std::span<const Point3> positions, Index cell) {
    std::vector<Point3> corners;
    for (const Index vertex : complex.relation(3, 0)[cell]) corners.push_back(positions[vertex]);
    return mean(corners);
}

}  // namespace espalier::shapes
