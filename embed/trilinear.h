// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <Eigen/Core>
#include <array>
#include <optional>

namespace espalier::embed {

/// The trilinear map of a hexahedron: (u, v, w) in [0, 1]³ to space. Corners in VTK's order: corner
/// 1 is at (1, 0, 0), 2 at (1, 1, 0), 3 at (0, 1, 0), and 4 to 7 the same at w = 1.
///
/// \cite MacCracken & Joy 1996, section 6
class ESPALIER_API Trilinear {
public:
    using Corners = std::array<Eigen::Vector3d, 8>;
    using Weights = std::array<double, 8>;

    explicit Trilinear(const Corners& corners) : corners_(corners) {}

    /// Weights of the corners at a place.
    static Weights weights(const Eigen::Vector3d& uvw);

    /// Derivatives of the weights by u, v and w.
    static std::array<Weights, 3> weightDerivatives(const Eigen::Vector3d& uvw);

    Eigen::Vector3d position(const Eigen::Vector3d& uvw) const { return tangent(uvw).position; }

    /// Columns are the derivatives by u, v and w. (The paper interpolates the Jacobians of the
    /// corners; for a trilinear map that is this, exactly.)
    Eigen::Matrix3d jacobian(const Eigen::Vector3d& uvw) const { return tangent(uvw).jacobian; }

    /// The position and the Jacobian at a place: in one go, they take half the time.
    struct Tangent {
        Eigen::Vector3d position;
        Eigen::Matrix3d jacobian;
    };
    Tangent tangent(const Eigen::Vector3d& uvw) const;

    /// Where the map takes the value 0, by Newton's method from `start`. Put the point that is
    /// sought at the origin: rounding is then relative to the cell, not to where it lies.
    ///
    /// \return nothing if the iteration meets a singular Jacobian, wanders off or does not settle
    std::optional<Eigen::Vector3d> findOrigin(
        const Eigen::Vector3d& start = Eigen::Vector3d::Constant(0.5)) const;

    /// A place in the cell that findOrigin() from the centre may miss in a twisted cell: searched
    /// for by splitting the parameter cube, since each part lies in the box of its corners.
    std::optional<Eigen::Vector3d> findOriginInside(double tolerance) const;

    /// The place in [0, 1]³ that is (locally) nearest to the origin, by Gauss-Newton steps within
    /// the cube; in a parallelepiped, by the first of them.
    Eigen::Vector3d nearestToOrigin() const;

private:
    Corners corners_;
};

/// Whether a place lies in [0, 1]³, give or take `tolerance`.
ESPALIER_API bool isInUnitCube(const Eigen::Vector3d& uvw, double tolerance);

}  // namespace espalier::embed
