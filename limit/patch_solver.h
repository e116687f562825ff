// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/affine_hull.h>
#include <espalier/embed/trilinear.h>

#include <Eigen/Core>
#include <optional>

#include "tricubic_patch.h"

namespace espalier::limit {

/// The map of a tricubic patch: (u, v, w) in [0, 1]³ to space.
class TricubicMap {
public:
    explicit TricubicMap(const TricubicPatch::ControlPoints& points) : points_(points) {}

    /// The same map with a point at the origin.
    TricubicMap around(const Eigen::Vector3d& point) const;

    embed::Trilinear::Tangent tangent(const Eigen::Vector3d& uvw) const;
    Eigen::Vector3d position(const Eigen::Vector3d& uvw) const { return tangent(uvw).position; }

    const TricubicPatch::ControlPoints& controlPoints() const { return points_; }

private:
    TricubicPatch::ControlPoints points_;
};

/// Finds points in one tricubic patch.
class PatchSolver {
public:
    explicit PatchSolver(const TricubicPatch::ControlPoints& points);

    const TricubicMap& map() const { return map_; }

    enum class Answer {
        Here,      ///< in the patch
        NotHere,   ///< that is proved
        Undecided  ///< the patch is too strongly bent to tell: its children are less so
    };
    struct Found {
        Answer answer = Answer::Undecided;
        Eigen::Vector3d uvw = Eigen::Vector3d::Zero();
    };

    /// NotHere for all outside of a hull of the patch; else Newton's method, and where that leads
    /// out of the patch, Krawczyk's test that there is no solution in it. In a flat patch, and
    /// where neither decides, a point is Here if the nearest place of the patch gives it back. What
    /// is Here may lie outside of [0, 1]³ by 1e-9 and the rounding of the coordinates; what is
    /// outside of the hull by more than rounding is NotHere all the same.
    Found find(const Eigen::Vector3d& point) const;

    /// Whether the Jacobian is nearly the same all over the patch: then the place that nearest()
    /// finds is the nearest of all.
    bool isNearlyLinear() const;

    /// The place in [0, 1]³ that is (locally) nearest to a point.
    Eigen::Vector3d nearest(const Eigen::Vector3d& point) const;

private:
    bool isExcluded(const TricubicMap& map) const;

    TricubicMap map_;
    Eigen::Matrix3d inverse_;  ///< of the Jacobian at the centre
    embed::AffineHull hull_;   ///< of the patch
    Eigen::AlignedBox3d box_;  ///< of the patch
    /// Entry by entry the most that inverse · Jacobian is off the identity, anywhere in the patch.
    Eigen::Matrix3d spread_;
    double length_;    ///< the rounding of coordinates
    double rounding_;  ///< the same in u, v and w
};

}  // namespace espalier::limit
