// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/vector3.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <span>

#include "rotation_fit.h"

namespace espalier::solve {

/// The mean of some points, and their principal axes by descending extent.
struct PrincipalAxes {
    Point3 mean = {};
    std::array<Point3, 3> directions = {};
    std::array<double, 3> extents = {};  ///< root mean squares along the directions

    /// \param points at least one
    PrincipalAxes(std::span<const Index> points, std::span<const Point3> positions) {
        const Point3& origin = positions[points[0]];
        const auto count = static_cast<double>(points.size());
        Eigen::Vector3d offset = Eigen::Vector3d::Zero();
        for (const Index point : points)
            offset += toEigen(difference(positions[point], origin)) / count;
        Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
        for (const Index point : points) {
            const Eigen::Vector3d place = toEigen(difference(positions[point], origin)) - offset;
            moments += place * place.transpose() / count;
        }
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moments, Eigen::ComputeFullU);
        mean = sum(origin, {offset[0], offset[1], offset[2]});
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3d direction = svd.matrixU().col(axis);
            directions[axis] = {direction[0], direction[1], direction[2]};
            extents[axis] = std::sqrt(svd.singularValues()[axis]);
        }
    }
};

}  // namespace espalier::solve
