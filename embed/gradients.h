// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/deformation_gradient.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/embed/basis_functions.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::embed {

/// Three tables that give the deformation gradient F = ∂x'/∂X at each point: table j times the
/// displacements of a pose from the rest is column j of F − 1. Rows sum to 0, or, for a point with
/// a weight (bind::PointWeights), to the slope of its weight by coordinate j.
using GradientTables = std::array<stencils::StencilTable<double>, 3>;

/// Places of points in hexahedra of a level. There the map is trilinear, and F follows from the
/// corners. A place takes 32 bytes; the rows take 300, or 3,000 over the base.
struct CellPlaces {
    /// The corners in the order of far::hexahedronVertices(): rows of Gradients::vertices.
    using Cell = std::array<Index, 8>;

    struct Place {
        Index point = 0;
        Index cell = 0;
        std::array<double, 3> uvw = {};
        friend bool operator==(const Place&, const Place&) = default;
    };

    std::vector<Cell> cells = {};
    std::vector<Place> places = {};  ///< ascending by point

    friend bool operator==(const CellPlaces&, const CellPlaces&) = default;
};

/// Places of points in regular cells of the base or, in the limit, of a level. There the map is a
/// product of splines, and F follows from the vertices around the cell. A place takes 32 bytes; the
/// rows take 2,300.
struct SplinePlaces {
    /// The vertices around a regular cell, rows of Gradients::vertices: vertex i + 4j + 16k is
    /// i − 1 cells along u, j − 1 along v and k − 1 along w away from corner 0 of the cell.
    /// kMaxIndex where a boundary has no layer.
    using Patch = std::array<Index, 64>;

    struct Place {
        Index point = 0;
        Index patch = 0;
        std::array<double, 3> uvw = {};  ///< in the axes of the patch, 0 to 1
        friend bool operator==(const Place&, const Place&) = default;
    };

    double spacing = 0;  ///< 2⁻ⁿ in regular cells of the base, for level n; 0 in the limit
    std::vector<Patch> patches = {};
    std::vector<Place> places = {};  ///< ascending by point

    friend bool operator==(const SplinePlaces&, const SplinePlaces&) = default;
};

/// Places of points in a lattice with a Bézier or B-spline basis. F follows from the vertices of
/// the lattice, by the derivatives of the basis. A place takes 32 bytes; the rows take 2,300, or
/// with a Bézier basis 36 for each vertex.
struct BasisPlaces {
    struct Place {
        Index point = 0;
        std::array<double, 3> at = {};  ///< in cells, within axisRange() of each axis
        friend bool operator==(const Place&, const Place&) = default;
    };

    Basis basis = Basis::Bezier;

    /// Number of cells along each axis. Row i + (cells[0] + 1) (j + (cells[1] + 1) k) of
    /// Gradients::vertices is the vertex i cells along the first axis, j along the second and k
    /// along the third.
    std::array<Index, 3> cells = {};
    std::vector<Place> places = {};  ///< ascending by point

    friend bool operator==(const BasisPlaces&, const BasisPlaces&) = default;
};

/// How the deformation gradient at each point follows from a pose.
///
/// In a level, F is the derivative of the trilinear map of the cell that contains the point; on a
/// face between two cells, of one of them. In the limit and under a basis it is the derivative of
/// the limit or of the basis. For a point outside that is carried along, it is the derivative at
/// the place that carries it. A point that no vertex moves, and a point at which the lattice at
/// rest has no volume, have the identity.
///
/// For an affine pose, F is the matrix of the pose to 1e-12; in a cell that is 10,000 times as long
/// as thick, to 1e-11. Transform normals by the cofactor matrix of F, tangents by F.
struct Gradients {
    /// The vertices that the points below refer to. Each row has the weights of a vertex over the
    /// base: 1 for a base vertex, several for a vertex of a level.
    stencils::StencilTable<double> vertices;

    /// The points with rows of their own, ascending, and the rows, three for each, over `vertices`:
    /// row 3i + j times the displacements of the vertices is column j of F − 1 of points[i]. Rows
    /// sum to 0.
    std::vector<Index> points = {};
    stencils::StencilTable<double> rows = {};

    CellPlaces cells = {};
    SplinePlaces splines = {};
    BasisPlaces basis = {};

    Index columnCount() const { return vertices.columnCount(); }

    /// Returns how many points have the identity in every pose.
    /// \param pointCount number of all points
    ESPALIER_API Index identityCount(Index pointCount) const;

    /// \throws Error unless the tables fit together, no point has gradients twice or is beyond the
    ///         number of points, and each place is in a cell or patch that exists, with finite
    ///         coordinates, and each of these has vertices that exist
    ESPALIER_API void check(Index pointCount) const;

    friend bool operator==(const Gradients&, const Gradients&) = default;
};

/// Adds F − 1 of all points for one pose.
/// \param rest, displacements one per base vertex: the lattice at rest, and p' − p
/// \param sums one per point
/// \cost 0.5 µs for each point in a regular cell and 0.2 µs for each other one, on two cores
ESPALIER_API void addGradients(const Gradients& gradients, std::span<const Point3> rest,
                               std::span<const Point3> displacements,
                               std::span<DeformationGradient> sums);

/// Returns the gradients as tables over the base, with a row for each point.
/// \param rest the lattice at rest, one position per base vertex
/// \cost O(entries of the result), in parallel
ESPALIER_API GradientTables gradientTables(const Gradients& gradients, std::span<const Point3> rest,
                                           Index pointCount);

}  // namespace espalier::embed
