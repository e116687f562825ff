// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/rounded_product.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace espalier::embed {

/// Tells whether a point lies in the smallest parallelepiped that contains some given points and
/// whose edges are parallel to given axes. Around a thin plate that is oblique to the coordinate
/// axes, it is far smaller than a box.
class AffineHull {
public:
    /// Contains every point.
    AffineHull() = default;

    /// Empty until extend() is called.
    /// \param inverse inverse of the matrix whose columns are the axes; if it is not finite, the
    ///        hull contains every point
    explicit AffineHull(const Eigen::Matrix3d& inverse) {
        // A matrix with some infinite entries would give finite coordinates to some points only.
        if (inverse.allFinite()) inverse_ = inverse;
    }

    void extend(const Eigen::Vector3d& point) {
        box_.extend(Eigen::Vector3d(roundedProduct(inverse_, point)));
    }

    /// \param margin added on each side, in lengths of the axes
    void widen(double margin) {
        box_.min().array() -= margin;
        box_.max().array() += margin;
    }

    bool contains(const Eigen::Vector3d& point) const {
        // The comparisons are such that a point whose coordinates are NaN is inside.
        const Eigen::Array3d place = roundedProduct(inverse_, point);
        return !((place < box_.min().array()).any() || (place > box_.max().array()).any());
    }

private:
    Eigen::Matrix3d inverse_ = Eigen::Matrix3d::Constant(std::nan(""));
    Eigen::AlignedBox3d box_;  ///< the box of the points in axis coordinates
};

}  // namespace espalier::embed
