// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::solve {

/// Selects the displacements of a lattice that an optimiser may choose, as variables.
///
/// Initially each coordinate of each vertex is a variable. Linked coordinates share a variable,
/// each with its own factor; frozen coordinates have none. Row 3v + c of the matrix B holds the
/// weights of the variables in the displacement of coordinate c of vertex v. With D, points ×
/// vertices, J = (D ⊗ I₃) · B is the Jacobian of the coordinates of the points by the variables.
class ESPALIER_API DesignVariables {
public:
    explicit DesignVariables(Index vertexCount);

    /// Keeps a vertex, or one coordinate of it, in place, and everything that is linked to it.
    /// \throws Error for a vertex that does not exist; ArgumentError for an axis that is not 0 to 2
    void freeze(Index vertex);
    void freeze(Index vertex, int axis);

    /// Makes `vertex` move as `to` does, each coordinate multiplied by its factor: 1, 1, 1 to move
    /// alike; −1, 1, 1 to mirror at a plane across the first axis. Links are transitive: all
    /// vertices that are linked to either one share a variable. A coordinate that can satisfy all
    /// links only by staying in place, such as one that is its own mirror image, is frozen.
    ///
    /// \throws ArgumentError for factors that are 0 or not finite; Error if their products with the
    ///         factors of other links are, and for a vertex that does not exist. The links are then
    ///         unchanged
    void link(Index vertex, Index to, const std::array<double, 3>& factors = {1, 1, 1});

    /// Links each vertex with its mirror image at a plane across an axis.
    ///
    /// \param positions positions of the vertices at rest
    /// \param axis 0 to 2
    /// \param at coordinate of the plane on that axis
    /// \param tolerance largest distance of a vertex from the image of another one
    /// \throws ArgumentError for a number that is not finite, and a tolerance below 0; Error naming
    ///         the first vertex without an image, or with several, in which case nothing is linked;
    ///         if the number of positions is not the number of vertices, or a position is not
    ///         finite
    /// \cost O(vertices · log vertices)
    void mirror(std::span<const Point3> positions, int axis, double at, double tolerance);

    /// Sets how far a vertex, or one coordinate of it, moves when its variable grows by 1, so that
    /// an optimiser sees variables of similar size. Initially 1. Linked coordinates share a
    /// variable: the last call decides for all of them, each by its own factor. A link made later
    /// keeps the unit of the lower-numbered coordinate.
    ///
    /// \throws ArgumentError for an axis that is not 0 to 2, and a unit that is 0 or not finite;
    ///         Error if its quotient with the factor of a link is, and for a vertex that does not
    ///         exist
    void scale(Index vertex, double unit);
    void scale(Index vertex, int axis, double unit);

    /// Returns B: 3 · vertices × variables. Columns are ordered by the first coordinate of each
    /// variable.
    stencils::StencilTable<double> matrix() const;

private:
    /// This coordinate = factor · coordinate `to`.
    struct Link {
        Index to;
        double factor;
    };
    Index coordinate(Index vertex, int axis) const;
    Link rootOf(Index coordinate);
    double joinedFactor(Index coordinate, Index to, double factor);
    void join(Index coordinate, Index to, double factor);

    std::vector<Link> links_;  ///< one for each coordinate, to a lower one; a root links to itself
    std::vector<char> isFrozen_;  ///< whether a coordinate is frozen; roots only
    std::vector<double> units_;   ///< distance moved for 1 unit of the variable; roots only
};

/// Builds J = (D ⊗ I₃) · B: row 3i + c holds the derivatives of coordinate c of point i by the
/// variables. J·v moves the points, Jᵀ·g (transposeTable()) carries gradients back.
///
/// \param deformation D, points × vertices
/// \param design B
/// \throws Error unless B has three rows for each column of D; if there are more than 2^31 / 3
///         points
/// \cost O(products of entries), in parallel
ESPALIER_API stencils::StencilTable<double> buildJacobian(
    const stencils::StencilTable<double>& deformation,
    const stencils::StencilTable<double>& design);

}  // namespace espalier::solve
