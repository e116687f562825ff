// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/affine_hull.h>
#include <espalier/embed/trilinear.h>

#include <Eigen/Core>
#include <optional>

#include "tricubic_patch.h"

namespace espalier::limit {

/// The map of a tricubic patch from (u, v, w) in [0, 1]³ to space.
class TricubicMap {
public:
    explicit TricubicMap(const TricubicPatch::ControlPoints& points) : points_(points) {}

    /// Returns the map shifted so that `point` is at the origin.
    TricubicMap around(const Eigen::Vector3d& point) const;

    embed::Trilinear::Tangent tangent(const Eigen::Vector3d& uvw) const;
    Eigen::Vector3d position(const Eigen::Vector3d& uvw) const;

    const TricubicPatch::ControlPoints& controlPoints() const { return points_; }

private:
    TricubicPatch::ControlPoints points_;
};

/// Finds the place of a point in one tricubic patch.
class PatchSolver {
public:
    explicit PatchSolver(const TricubicPatch::ControlPoints& points);

    const TricubicMap& map() const { return map_; }

    enum class Answer {
        Inside,    ///< in the patch
        Outside,   ///< proved not to be in the patch
        Undecided  ///< the patch is too strongly bent to decide; its children are bent less
    };
    struct Found {
        Answer answer = Answer::Undecided;
        Eigen::Vector3d uvw = Eigen::Vector3d::Zero();
    };

    /// Decides whether a point is in the patch, and finds its place.
    ///
    /// A point outside a hull of the patch is Outside. Otherwise Newton's method runs; where it
    /// leaves the patch, Krawczyk's test may prove that the patch has no solution; if it does not,
    /// the answer is Undecided. In a flat patch, and where Newton's method does not converge, the
    /// point is Inside if the nearest place of the patch coincides with it. A place that is Inside
    /// may be outside [0, 1]³ by up to 1e-9 and the rounding of the coordinates. A point outside
    /// the hull by more than rounding is always Outside.
    Found find(const Eigen::Vector3d& point) const;

    /// True if the Jacobian is nearly constant over the patch. Then nearest() finds the global
    /// minimum.
    bool isNearlyLinear() const;

    /// Returns the place in [0, 1]³ that is nearest to a point, at least locally.
    Eigen::Vector3d nearest(const Eigen::Vector3d& point) const;

private:
    bool isExcluded(const TricubicMap& map) const;

    TricubicMap map_;
    Eigen::Vector3d middle_;   ///< position of the centre
    Eigen::Matrix3d inverse_;  ///< inverse of the Jacobian at the centre
    embed::AffineHull hull_;   ///< contains the patch
    Eigen::AlignedBox3d box_;  ///< contains the patch
    /// Upper bound of |inverse · Jacobian − identity| over the patch, entry by entry.
    Eigen::Matrix3d spread_;
    double length_;    ///< rounding of coordinates
    double rounding_;  ///< rounding of u, v and w
};

}  // namespace espalier::limit
