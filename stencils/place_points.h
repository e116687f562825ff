// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/parallel.h>
#include <espalier/stencils/embedding.h>
#include <espalier/stencils/table_builder.h>

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <functional>
#include <span>

namespace espalier::stencils {

// What all ways to embed a model in a lattice have in common.

inline std::array<double, 3> toArray(const Eigen::Vector3d& v) {
    return {v[0], v[1], v[2]};
}

/// \throws Error if `positions` are not one a vertex, or not finite
void checkPositions(const far::CellComplex& complex, std::span<const Point3> positions);

/// The tolerance, if it is one.
/// \throws Error if it is not finite or negative
double checkedTolerance(double tolerance);

/// \throws Error if there are more than an Index counts
void checkPointCount(std::span<const Point3> points);

/// \throws Error naming a point that OutsidePolicy::Error does not let pass
[[noreturn]] void refusePoint(Offset index, const Point3& point, PointStatus status);

/// \throws Error if the points were placed in a lattice of another number of vertices
void checkVertexCount(Index placedIn, Index vertexCount);

/// Locates each point, in parallel: locate(point, seekNearest) returns its Located<Place>.
template <class Place, class Locate>
PlacedPoints<Place> locatePoints(std::span<const Point3> points, Index vertexCount,
                                 OutsidePolicy outside, const std::function<void(Offset)>& progress,
                                 Locate locate) {
    checkPointCount(points);
    PlacedPoints<Place> placed;
    placed.points.resize(points.size());
    placed.vertexCount = vertexCount;
    std::atomic<Offset> done = 0;
    constexpr Offset kGrain = 1024;
    far::parallelFor(static_cast<Offset>(points.size()), kGrain, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i) {
            const Point3& point = points[static_cast<std::size_t>(i)];
            Located<Place>& located = placed.points[static_cast<std::size_t>(i)];
            located = locate(point, outside == OutsidePolicy::Nearest);
            if (outside == OutsidePolicy::Error && located.status != PointStatus::Inside)
                refusePoint(i, point, located.status);
        }
        if (progress) progress(done += last - first);
    });
    return placed;
}

/// The weights of each point over the vertices of the lattice: weightsOf(place) returns them. The
/// row of a point without a place is empty.
template <class Real, class Place, class WeightsOf>
StencilTable<Real> buildPlaceTable(const PlacedPoints<Place>& placed, Index vertexCount,
                                   WeightsOf weightsOf) {
    checkVertexCount(placed.vertexCount, vertexCount);
    return buildTable<Real>(static_cast<Index>(placed.points.size()), vertexCount,
                            [&](Index row, RowAccumulator& accumulator) {
                                const auto& place =
                                    placed.points[static_cast<std::size_t>(row)].place;
                                if (!place) return;
                                for (const auto& [vertex, weight] : weightsOf(*place))
                                    accumulator.add(vertex, weight);
                            });
}

}  // namespace espalier::stencils
