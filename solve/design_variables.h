// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::solve {

/// The variables of a design: which displacements of the lattice an optimiser may choose.
///
/// At first each coordinate of each vertex is a variable. Coordinates that are linked share one,
/// each with a factor of its own; frozen ones have none. B says how: its row 3v + c holds the
/// weights of the variables in the displacement of coordinate c of vertex v. With D, points ×
/// vertices, J = (D ⊗ I₃) · B is the Jacobian of the points' coordinates by the variables.
class ESPALIER_API DesignVariables {
public:
    explicit DesignVariables(Index vertexCount);

    /// Keeps a vertex, or one coordinate of it, where it is; and with it all that is linked to it.
    /// \throws Error for a vertex that is not there, or an axis that is not 0 to 2
    void freeze(Index vertex);
    void freeze(Index vertex, int axis);

    /// Makes a vertex move as another does, each coordinate times its factor: 1, 1, 1 to move
    /// alike; −1, 1, 1 to mirror at a plane across the first axis. Links join: all that is linked
    /// to either vertex shares their variable. What could only move by 0 to keep all links, such as
    /// a coordinate that is its own mirror image, is frozen.
    ///
    /// \throws Error for a vertex that is not there; for factors that are 0 or not finite, also as
    ///         products with those of other links. Nothing is linked then
    void link(Index vertex, Index to, const std::array<double, 3>& factors = {1, 1, 1});

    /// Links each vertex with its mirror image at a plane across an axis.
    ///
    /// \param positions of the vertices, at rest
    /// \param axis 0 to 2
    /// \param at where the plane is on that axis
    /// \param tolerance how far an image may be from its vertex
    /// \throws Error naming the first vertex without an image, or with more than one, in which case
    ///         nothing is linked; if there are not as many positions as vertices, or one is not
    ///         finite
    /// \cost O(vertices · log vertices)
    void mirror(std::span<const Point3> positions, int axis, double at, double tolerance);

    /// Sets by how much a vertex moves, or one coordinate of it, when its variable grows by 1, so
    /// that variables can be of about the same size for an optimiser. At first 1. Coordinates that
    /// are linked share a variable: what is set last holds for all of them, each by its own factor;
    /// a link that is made later keeps the unit of the lower-numbered variable.
    ///
    /// \throws Error for a vertex that is not there, or an axis that is not 0 to 2; for a unit that
    ///         is 0 or not finite, also as a quotient with the factor of a link
    void scale(Index vertex, double unit);
    void scale(Index vertex, int axis, double unit);

    /// B: 3 · vertices × variables. Columns are in the order of their first coordinates.
    stencils::StencilTable<double> matrix() const;

private:
    /// Coordinate = factor · another.
    struct Link {
        Index to;
        double factor;
    };
    Index coordinate(Index vertex, int axis) const;
    Link rootOf(Index coordinate);
    double joinedFactor(Index coordinate, Index to, double factor);
    void join(Index coordinate, Index to, double factor);

    std::vector<Link> links_;     ///< one a coordinate, to a lower one; roots to themselves
    std::vector<char> isFrozen_;  ///< of roots
    std::vector<double> units_;   ///< of roots: by how much they move
};

/// J = (D ⊗ I₃) · B: row 3i + c holds the derivatives of coordinate c of point i by the variables.
/// J·v moves the points, Jᵀ·g (transposeTable()) carries gradients back.
///
/// \param deformation D, points × vertices
/// \param design B
/// \throws Error if B has not three rows for each column of D; if there are more than 2^31 / 3
///         points
/// \cost O(products of entries), in parallel
ESPALIER_API stencils::StencilTable<double> buildJacobian(
    const stencils::StencilTable<double>& deformation,
    const stencils::StencilTable<double>& design);

}  // namespace espalier::solve
