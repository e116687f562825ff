// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cmath>

namespace espalier {

/// Returns two columns that span the left eigenvectors of the second and third eigenvalue of a
/// ring's matrix M: times the points of the ring, they give two tangents at the limit of its
/// vertex. (Eigen's EigenSolver gives them too, but takes 7 seconds to compile.) \param m its rows
/// sum to 1; the fourth eigenvalue is smaller than the third
inline Eigen::MatrixXd tangentWeights(const Eigen::MatrixXd& m) {
    // Iterates a plane. Weights of sum 0 have no part in the left eigenvector of eigenvalue 1.
    const auto orthonormal = [](Eigen::MatrixXd plane) {
        plane.row(0) -= plane.colwise().sum();
        plane.col(0).normalize();
        plane.col(1) -= plane.col(0).dot(plane.col(1)) * plane.col(0);
        plane.col(1).normalize();
        return plane;
    };
    Eigen::MatrixXd plane(m.rows(), 2);
    for (Eigen::Index i = 0; i < m.rows(); ++i)
        plane.row(i) << std::sin(double(i)), std::sin(double(i * i + 1));
    plane = orthonormal(plane);
    for (int step = 0; step < 2000; ++step) {
        const Eigen::MatrixXd next = orthonormal(m.transpose() * plane);
        const double change = (next - plane * (plane.transpose() * next)).norm();
        plane = next;
        if (change < 1e-15) break;  // only rounding is left
    }
    return plane;
}

}  // namespace espalier
