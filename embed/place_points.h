// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/parallel.h>
#include <espalier/embed/embedding.h>

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <functional>
#include <span>

namespace espalier::embed {

// What all ways to embed a model in a lattice have in common.

inline std::array<double, 3> toArray(const Eigen::Vector3d& v) {
    return {v[0], v[1], v[2]};
}

/// \throws Error if `positions` are not one a vertex, or not finite
void checkPositions(const far::CellComplex& complex, std::span<const Point3> positions);

/// Checks that points can be bound to a level of a lattice.
/// \throws Error for a base that is no lattice or has been refined, and a level that is not 1 to
///         kMaxLevelOfPoints; as checkPositions(); and what refining a base throws of which
///         nothing is left
void checkRest(const RestLattice& lattice, int level);

/// The tolerance, if it is one.
/// \throws Error if it is not finite or negative
double checkedTolerance(double tolerance);

/// \throws Error if there are more than an Index counts
void checkPointCount(std::span<const Point3> points);

/// \throws Error naming a point that OutsidePolicy::Error does not let pass
[[noreturn]] void refusePoint(Offset index, const Point3& point, PointStatus status);

/// \throws Error if the points were placed in a lattice of another number of vertices
void checkVertexCount(Index placedIn, Index vertexCount);

/// \throws Error naming the first point that is not inside
void checkAllInside(std::span<const Point3> points, std::span<const PointStatus> statuses);

/// The points of some numbers.
std::vector<Point3> chosenPoints(std::span<const Point3> points, std::span<const Index> numbers);

/// The points in an order in which one is near the next: they ask for the same cells, which then
/// are in the cache. That halves the time of locating them.
std::vector<Index> alongCurve(std::span<const Point3> points);

/// Locates each point, in parallel: locate(point, seekNearest) returns its Located<Place>.
/// \param order to take the points in, or empty; the result does not depend on it, only the time
template <class Place, class Locate>
PlacedPoints<Place> locatePoints(std::span<const Point3> points, Index vertexCount,
                                 OutsidePolicy outside, const std::function<void(Offset)>& progress,
                                 Locate locate, std::span<const Index> order = {}) {
    checkPointCount(points);
    PlacedPoints<Place> placed;
    placed.points.resize(points.size());
    placed.vertexCount = vertexCount;
    std::atomic<Offset> done = 0;
    constexpr Offset kGrain = 1024;
    parallelFor(static_cast<Offset>(points.size()), kGrain, [&](Offset first, Offset last) {
        // First all are read: where they lie scattered, none of the reads waits for another. Saves
        // 0.1 µs a point.
        std::array<std::size_t, kGrain> numbers;
        std::array<Point3, kGrain> near;
        const auto count = static_cast<std::size_t>(last - first);
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = static_cast<std::size_t>(first) + i;
            numbers[i] = order.empty() ? at : static_cast<std::size_t>(order[at]);
            near[i] = points[numbers[i]];
        }
        for (std::size_t i = 0; i < count; ++i)
            placed.points[numbers[i]] = locate(near[i], outside == OutsidePolicy::Nearest);
        if (progress) progress(done += last - first);
    });
    if (outside == OutsidePolicy::Error) {
        std::vector<PointStatus> statuses;
        for (const Located<Place>& point : placed.points) statuses.push_back(point.status);
        checkAllInside(points, statuses);
    }
    return placed;
}

}  // namespace espalier::embed
