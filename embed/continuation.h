// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/cell_place.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

// Points outside a cell: they get a place by continuing the cell's map along its tangent.
namespace espalier::embed {

/// The position of a place must agree with its point within this fraction of the lattice's size, or
/// of the point's distance from the origin if that is larger. The project promises this accuracy
/// for the rest pose.
inline constexpr double kResidual = 1e-12;

/// A weighted sum of positions, and the sum of the lengths of its terms, to which its rounding
/// error is proportional.
struct WeightedSum {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double size = 0;
};

/// Returns the weighted sum of some vertices.
/// \param positionOf returns the position of a vertex
template <class PositionOf>
WeightedSum weightedSum(std::span<const VertexWeight> weights, PositionOf positionOf) {
    WeightedSum result;
    for (const auto& [vertex, weight] : weights) {
        const Eigen::Vector3d term = weight * positionOf(vertex);
        result.sum += term;
        result.size += term.norm();
    }
    return result;
}

/// Returns true if the position of a place equals the point, up to the rounding of the weighted
/// sum.
/// \param size of the lattice
inline bool isSettled(const WeightedSum& position, const Eigen::Vector3d& point, double size) {
    // Weights grow with the distance divided by the size of the cell, and so does the rounding
    // error of the sum.
    constexpr double kRounding = 1e-15;
    return (position.sum - point).norm() <=
           std::max(kResidual * std::max(size, point.norm()), kRounding * position.size);
}

/// Returns true if each coordinate of an offset is at most `length`.
inline bool isWithin(const std::array<double, 3>& offset, double length) {
    return std::ranges::all_of(offset, [&](double along) { return std::abs(along) <= length; });
}

/// An offset from a place to a point, in the coordinates of the place's cell.
struct Continuation {
    Eigen::Vector3d offset;
    WeightedSum position;  ///< position of the place with that offset
};

/// Returns the offset from a place to a point along the tangent of the map.
///
/// The rounding error of the Jacobian is proportional to the cell's distance from the origin
/// divided by its size. So the remaining difference is computed from the weights themselves, and
/// solved for again in up to four steps.
/// \param size of the lattice
/// \param positionAt returns the WeightedSum of the place with a given offset
/// \return nothing if the map is singular there
template <class PositionAt>
std::optional<Continuation> continueTo(const Eigen::Vector3d& point,
                                       const Eigen::Matrix3d& jacobian, double size,
                                       PositionAt positionAt) {
    constexpr int kMaxSteps = 4;
    const Eigen::FullPivLU<Eigen::Matrix3d> solver(jacobian);
    Continuation now{Eigen::Vector3d::Zero(), positionAt(Eigen::Vector3d(Eigen::Vector3d::Zero()))};
    for (int step = 0; step < kMaxSteps; ++step) {
        now.offset += solver.solve(point - now.position.sum);
        if (!now.offset.allFinite()) return std::nullopt;
        now.position = positionAt(now.offset);
        if (isSettled(now.position, point, size)) break;
    }
    return now;
}

}  // namespace espalier::embed
