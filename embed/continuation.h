// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/cell_place.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <optional>
#include <span>

// Points beside a cell: the cell's map goes on to them along its tangent.
namespace espalier::embed {

/// A place must give its point back within this part of the lattice's size, or of how far off the
/// point lies: what the project promises of the rest pose.
inline constexpr double kResidual = 1e-12;

/// A sum of weighted positions, and the sum of the terms' sizes, which its rounding goes by.
struct WeightedSum {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double size = 0;
};

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

/// Returns true if the position of a place is the point, up to the rounding of the sum of weights.
/// \param size of the lattice
inline bool isSettled(const WeightedSum& position, const Eigen::Vector3d& point, double size) {
    // Weights grow with the distance over the size of the cell, and so does the rounding of sums.
    constexpr double kRounding = 1e-15;
    return (position.sum - point).norm() <=
           std::max(kResidual * std::max(size, point.norm()), kRounding * position.size);
}

/// An offset that leads from a place to a point, in the coordinates of its cell.
struct Continuation {
    Eigen::Vector3d offset;
    WeightedSum position;  ///< of the place with that offset
};

/// The offset from a place to a point, along the tangent.
///
/// The Jacobian is rounded by the cell's distance from the origin over its size. So what is left is
/// solved for again, by the weights themselves.
/// \param size of the lattice
/// \param positionAt returns the WeightedSum of the place with an offset
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
