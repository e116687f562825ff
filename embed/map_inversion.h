// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/box_least_squares.h>
#include <espalier/embed/rounded_product.h>
#include <espalier/embed/solve3.h>

#include <Eigen/Core>
#include <optional>

// Finds where a smooth map of the unit cube takes the value 0. To find the place of a point,
// subtract the point from the map first: rounding errors are then relative to the cell, not to its
// distance from the origin.
//
// A Map has tangent(uvw), which returns the position and the Jacobian, and position(uvw).
namespace espalier::embed {

/// Returns the place where the map is 0, by Newton's method from `start`.
/// \return nothing if the iteration meets a singular Jacobian, wanders off or does not settle
template <class Map>
std::optional<Eigen::Vector3d> findOrigin(const Map& map, const Eigen::Vector3d& start) {
    // Quadratic convergence: well-shaped cells take 3 to 6 steps.
    constexpr int kMaxSteps = 25;
    // Once a step is this short, the next would be about its square: below rounding.
    constexpr double kSettled = 1e-9;
    // A place this far outside is of no use, and returning from there would be luck.
    constexpr double kWanderedOff = 100;
    Eigen::Vector3d uvw = start;
    for (int step = 0; step < kMaxSteps; ++step) {
        const auto [value, slopes] = map.tangent(uvw);
        const Eigen::Vector3d move = solve3(slopes, value);
        if (!move.allFinite()) return std::nullopt;
        uvw -= move;
        if (uvw.template lpNorm<Eigen::Infinity>() > kWanderedOff) return std::nullopt;
        if (move.template lpNorm<Eigen::Infinity>() < kSettled) return uvw;
    }
    return std::nullopt;
}

/// Returns the place in [0, 1]³ whose position is (locally) nearest to 0, by Gauss-Newton steps
/// within the cube. The first step is exact for a linear map.
template <class Map>
Eigen::Vector3d nearestToOrigin(const Map& map) {
    using Eigen::Vector3d;
    constexpr int kMaxSteps = 50;
    // Far smaller than any difference of places that matters; the distance has settled long before.
    constexpr double kSettled = 1e-12;
    Vector3d uvw = Vector3d::Constant(0.5);
    double distance = map.position(uvw).stableNorm();
    for (int step = 0; step < kMaxSteps; ++step) {
        // The nearest place of the linear map that is tangent to the map here.
        const auto [value, j] = map.tangent(uvw);
        const Vector3d target = roundedProduct(j, uvw) - value;
        Vector3d move = nearestInBox(j, target, Vector3d::Zero(), Vector3d::Ones()) - uvw;
        // Halve the step until the distance decreases.
        double length = 0;
        for (int halving = 0; halving < 30; ++halving, move /= 2) {
            const Vector3d next = uvw + move;
            const double nextDistance = map.position(next).stableNorm();
            if (nextDistance < distance) {
                length = move.template lpNorm<Eigen::Infinity>();
                uvw = next;
                distance = nextDistance;
                break;
            }
        }
        if (length < kSettled) return uvw;
    }
    return uvw;
}

}  // namespace espalier::embed
