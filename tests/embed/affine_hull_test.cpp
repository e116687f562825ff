// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/affine_hull.h>

#include <Eigen/LU>

#include "support/test.h"

namespace espalier::embed {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Returns the hull of the parallelepiped whose corners are sums of columns.
AffineHull hullOf(const Matrix3d& axes) {
    AffineHull hull(axes.inverse());
    for (int corner = 0; corner < 8; ++corner)
        hull.extend(axes * Vector3d(corner & 1, corner >> 1 & 1, corner >> 2));
    return hull;
}

// The plate is a thousandth thick along (1, 1, 1). Its box contains (0.5, 0, 0), which is 0.29 off
// the plate's plane.
TEST(AffineHull, ObliquePlateHasATightHull) {
    Matrix3d axes;
    axes.col(0) = Vector3d(1, -1, 0);
    axes.col(1) = Vector3d(0, 1, -1);
    axes.col(2) = Vector3d::Constant(1e-3);
    AffineHull hull = hullOf(axes);
    EXPECT_TRUE(hull.contains(axes * Vector3d(0.3, 0.6, 0.9)));
    EXPECT_FALSE(hull.contains(Vector3d(0.5, 0, 0)));
    EXPECT_FALSE(hull.contains(axes * Vector3d(0.3, 0.6, 1.2)));
    hull.widen(0.25);
    EXPECT_TRUE(hull.contains(axes * Vector3d(0.3, 0.6, 1.2)));
    EXPECT_FALSE(hull.contains(axes * Vector3d(0.3, 0.6, 1.3)));
}

// The inverse of such axes has infinite entries of both signs, which must not exclude any point.
TEST(AffineHull, FlatHullContainsEveryPoint) {
    Matrix3d flat;
    flat.col(0) = Vector3d(1, -1, 0);
    flat.col(1) = Vector3d(0, 1, -1);
    flat.col(2) = Vector3d(1, 0, -1);
    for (const AffineHull& hull : {hullOf(flat), hullOf(Matrix3d::Zero()), AffineHull()})
        for (int octant = 0; octant < 8; ++octant)
            EXPECT_TRUE(hull.contains(
                Vector3d(octant & 1 ? 2 : -2, octant & 2 ? 3 : -3, octant & 4 ? 5 : -5)))
                << octant;
}

}  // namespace
}  // namespace espalier::embed
