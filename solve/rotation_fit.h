// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <Eigen/Dense>

// The rotation nearest to a matrix; not installed.
namespace espalier::solve {

inline Eigen::Vector3d toEigen(const Point3& point) {
    return {point[0], point[1], point[2]};
}

/// Returns the rotation R with the largest trace of Rᵀ A, by the singular values of A. It maps
/// points q to targets y best if A = Σ y qᵀ.
/// \cite Sorkine & Alexa 2007, equation 6
inline Eigen::Matrix3d rotationBySingularValues(const Eigen::Matrix3d& matrix) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> parts(matrix,
                                                  Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d left = parts.matrixU();
    if (left.determinant() * parts.matrixV().determinant() < 0) left.col(2) *= -1;
    return left * parts.matrixV().transpose();
}

/// Returns the same rotation, in a tenth of the time for matrices that are not nearly singular and
/// not mirrored: Newton's iteration for the polar factor.
/// \cite Higham 1986, Computing the polar decomposition, with applications, section 3
inline Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& matrix) {
    constexpr double kSingular = 1e-4;  // of the determinant of a matrix of size 1
    constexpr double kDone = 1e-15;
    constexpr int kMaxSteps = 20;
    const double size = matrix.norm();
    if (!(size > 0)) return Eigen::Matrix3d::Identity();
    Eigen::Matrix3d rotation = matrix / size;
    if (!(rotation.determinant() > kSingular)) return rotationBySingularValues(matrix);
    for (int step = 0; step < kMaxSteps; ++step) {
        // Cofactors: the transpose of the inverse times the determinant.
        Eigen::Matrix3d cofactors;
        cofactors.col(0) = rotation.col(1).cross(rotation.col(2));
        cofactors.col(1) = rotation.col(2).cross(rotation.col(0));
        cofactors.col(2) = rotation.col(0).cross(rotation.col(1));
        const Eigen::Matrix3d inverse = cofactors / rotation.col(0).dot(cofactors.col(0));
        const double scale = std::sqrt(inverse.norm() / rotation.norm());
        const Eigen::Matrix3d next = 0.5 * (scale * rotation + inverse / scale);
        const double change = (next - rotation).squaredNorm();
        rotation = next;
        if (change <= kDone * kDone * 9) return rotation;
    }
    return rotation;
}

}  // namespace espalier::solve
