// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/embed/embedding.h>

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <functional>
#include <span>

namespace espalier::embed {

// Functions that all ways to embed a model in a lattice share.

inline std::array<double, 3> toArray(const Eigen::Vector3d& v) {
    return {v[0], v[1], v[2]};
}

/// \throws Error unless there is one finite position per vertex
void checkPositions(const far::CellComplex& complex, std::span<const Point3> positions);

/// Checks that points can be bound to a level of a lattice.
/// \throws ArgumentError if the level is not 1 to kMaxLevelOfPoints; Error if the base is not a
///         lattice or has been refined; as checkPositions(); and as refineUniform() if refinement
///         would leave no cells
void checkRest(const RestLattice& lattice, int level);

/// Returns the tolerance, checked.
/// \throws ArgumentError if it is negative or not finite
double checkedTolerance(double tolerance);

/// \throws Error if there are more points than an Index can count
void checkPointCount(std::span<const Point3> points);

/// Throws for a point that is not inside, under OutsidePolicy::Error.
/// \throws Error that names the point
[[noreturn]] void refusePoint(Offset index, const Point3& point, PointStatus status);

/// \throws Error if the points were placed in a lattice with another number of vertices
void checkVertexCount(Index placedIn, Index vertexCount);

/// \throws Error naming the first point that is not inside
void checkAllInside(std::span<const Point3> points, std::span<const PointStatus> statuses);

/// Returns options under which a point outside stays in place instead of being refused.
inline EmbeddingOptions withoutRefusal(EmbeddingOptions options) {
    if (options.outside == OutsidePolicy::Error) options.outside = OutsidePolicy::Keep;
    return options;
}

/// Returns the points with the given indices.
std::vector<Point3> chosenPoints(std::span<const Point3> points, std::span<const Index> numbers);

/// Returns the points' indices in an order in which consecutive points are near each other: they
/// use the same cells, which are then in the cache. That halves the time of locating them.
std::vector<Index> alongCurve(std::span<const Point3> points);

/// Locates each point, in parallel: locate(point, seekNearest) returns its Located<Place>. Threads
/// use copies of `locate`, so that it may keep memory from point to point.
/// \param order in which to process the points, or empty; affects the time, not the result
template <class Place, class Locate>
PointPlaces<Place> locatePoints(std::span<const Point3> points, Index vertexCount,
                                OutsidePolicy outside, const std::function<void(Offset)>& progress,
                                Locate locate, std::span<const Index> order = {}) {
    checkPointCount(points);
    PointPlaces<Place> placed;
    placed.points.resize(points.size());
    placed.vertexCount = vertexCount;
    std::atomic<Offset> done = 0;
    constexpr Offset kGrain = 1024;
    parallelFor(static_cast<Offset>(points.size()), kGrain, [&](Offset first, Offset last) {
        // Read all points of the chunk first: if they are scattered in memory, the reads overlap
        // instead of waiting for each other. Saves 0.1 µs per point.
        std::array<std::size_t, kGrain> numbers;
        std::array<Point3, kGrain> near;
        const std::size_t count = last - first;
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t at = first + i;
            numbers[i] = order.empty() ? at : static_cast<std::size_t>(order[at]);
            near[i] = points[numbers[i]];
        }
        Locate own = locate;
        for (std::size_t i = 0; i < count; ++i) {
            checkCancelledEvery(i, 4);
            placed.points[numbers[i]] = own(near[i], outside == OutsidePolicy::Nearest);
        }
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
