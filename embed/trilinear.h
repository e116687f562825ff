// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <Eigen/Core>
#include <array>
#include <optional>

namespace espalier::embed {

/// The trilinear map of a hexahedron from (u, v, w) in [0, 1]³ to space. Corners are in VTK's
/// order: corner 1 is at (1, 0, 0), 2 at (1, 1, 0), 3 at (0, 1, 0), and 4 to 7 are the same at w =
/// 1.
///
/// \cite MacCracken & Joy 1996, section 6
class ESPALIER_API Trilinear {
public:
    using Corners = std::array<Eigen::Vector3d, 8>;
    using Weights = std::array<double, 8>;

    explicit Trilinear(const Corners& corners) : corners_(corners) {}

    /// Returns the weights of the corners at a place.
    static Weights weights(const Eigen::Vector3d& uvw);

    /// Returns the derivatives of the weights by u, v and w.
    static std::array<Weights, 3> weightDerivatives(const Eigen::Vector3d& uvw);

    Eigen::Vector3d position(const Eigen::Vector3d& uvw) const { return tangent(uvw).position; }

    /// Returns the matrix whose columns are the derivatives by u, v and w. (The paper interpolates
    /// the Jacobians of the corners, which is exactly the same for a trilinear map.)
    Eigen::Matrix3d jacobian(const Eigen::Vector3d& uvw) const { return tangent(uvw).jacobian; }

    /// The position and the Jacobian at a place. Computing both together halves the time.
    struct Tangent {
        Eigen::Vector3d position;
        Eigen::Matrix3d jacobian;
    };
    Tangent tangent(const Eigen::Vector3d& uvw) const;

    /// Returns the place where the map takes the value 0, by Newton's method from `start`. To find
    /// the place of a point, subtract the point from the corners: rounding errors are then relative
    /// to the cell, not to its distance from the origin.
    ///
    /// \return nothing if the iteration meets a singular Jacobian, wanders off or does not settle
    std::optional<Eigen::Vector3d> findOrigin(
        const Eigen::Vector3d& start = Eigen::Vector3d::Constant(0.5)) const;

    /// Returns a place in the cell where the map is 0, even in a twisted cell where findOrigin()
    /// from the centre may miss it. Splits the parameter cube into parts, and searches the parts
    /// whose corners' box contains the origin.
    std::optional<Eigen::Vector3d> findOriginInside(double tolerance) const;

    /// Returns the place in [0, 1]³ whose position is (locally) nearest to 0, by Gauss-Newton steps
    /// within the cube. The first step is exact for a parallelepiped.
    Eigen::Vector3d nearestToOrigin() const;

private:
    Corners corners_;
};

/// Returns true if a place is in [0, 1]³, within `tolerance`.
ESPALIER_API bool isInUnitCube(const Eigen::Vector3d& uvw, double tolerance);

}  // namespace espalier::embed
