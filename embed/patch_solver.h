// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/affine_hull.h>
#include <espalier/embed/tricubic_patch.h>
#include <espalier/embed/trilinear.h>

#include <Eigen/Core>

namespace espalier::embed {

/// The map of a tricubic patch from (u, v, w) in [0, 1]³ to space: the limit or a level.
class ESPALIER_API TricubicMap {
public:
    explicit TricubicMap(const TricubicPatch::ControlPoints& points,
                         double spacing = kLimitSpacing);

    Trilinear::Tangent tangent(const Eigen::Vector3d& uvw) const;
    Eigen::Vector3d position(const Eigen::Vector3d& uvw) const;

private:
    TricubicPatch::ControlPoints coefficients_;
    double spacing_;
};

/// Finds the place of a point in one tricubic patch.
class ESPALIER_API PatchSolver {
public:
    explicit PatchSolver(const TricubicPatch::ControlPoints& points,
                         double spacing = kLimitSpacing);

    Eigen::Vector3d position(const Eigen::Vector3d& uvw) const {
        return origin_ + map_.position(uvw);
    }

    /// Returns the distance of a point from the position of a place near it. It is more accurate
    /// than a difference of positions, whose rounding is relative to their distance from the
    /// origin.
    double distance(const Eigen::Vector3d& uvw, const Eigen::Vector3d& point) const {
        return (map_.position(uvw) - (point - origin_)).norm();
    }

    enum class Answer {
        Inside,    ///< found in the patch
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

    /// True if the map is proved to be one-to-one on the patch, at every level and in the limit.
    bool isOneToOne() const;

private:
    struct MapAround;
    bool isExcluded(const MapAround& map) const;

    Eigen::Vector3d origin_;  ///< a point of the patch; all that follows is relative to it
    TricubicMap map_;
    Eigen::Vector3d middle_;   ///< position of the centre
    Eigen::Matrix3d inverse_;  ///< inverse of the Jacobian at the centre
    AffineHull hull_;          ///< contains the patch
    Eigen::AlignedBox3d box_;  ///< contains the patch
    /// Upper bound of |inverse · Jacobian − identity| over the patch, entry by entry.
    Eigen::Matrix3d spread_;
    double length_;    ///< rounding of coordinates
    double rounding_;  ///< rounding of u, v and w
};

}  // namespace espalier::embed
