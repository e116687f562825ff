// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace espalier::embed {

/// The least parallelepiped with the directions of some axes that holds some points. Around a thin
/// plate that lies aslant it is far smaller than a box is.
class AffineHull {
public:
    /// Holds everything.
    AffineHull() = default;

    /// Empty yet.
    /// \param inverse of the matrix of the axes; if it is not finite, this holds everything
    explicit AffineHull(const Eigen::Matrix3d& inverse) {
        // With infinite entries some places would be numbers, and others not.
        if (inverse.allFinite()) inverse_ = inverse;
    }

    void extend(const Eigen::Vector3d& point) { box_.extend(Eigen::Vector3d(inverse_ * point)); }

    /// \param margin on each side, in lengths of the axes
    void widen(double margin) {
        box_.min().array() -= margin;
        box_.max().array() += margin;
    }

    bool contains(const Eigen::Vector3d& point) const {
        // Written so that what is not a number is inside.
        const Eigen::Array3d place = inverse_ * point;
        return !((place < box_.min().array()).any() || (place > box_.max().array()).any());
    }

private:
    Eigen::Matrix3d inverse_ = Eigen::Matrix3d::Constant(std::nan(""));
    Eigen::AlignedBox3d box_;  ///< of the points times that
};

}  // namespace espalier::embed
