// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/deformation_gradient.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::embed {

/// Three tables that give the deformation gradient F = ∂x'/∂X at each point: table j times the
/// displacements of a pose from the rest is column j of F − 1. Rows sum to 0, or, for a point with
/// a PointWeight, to the slope of its weight by coordinate j.
using GradientTables = std::array<stencils::StencilTable<double>, 3>;

/// How far a point follows the lattice, and how this changes from point to point
/// (bind::PointWeights).
struct PointWeight {
    double value = 1;   ///< 0 to 1
    Point3 slope = {};  ///< by the coordinates of the point at rest
    friend bool operator==(const PointWeight&, const PointWeight&) = default;
};

/// Places of points in regular cells of a lattice. There the map is a product of splines, and the
/// rows of F follow from the place by a formula. A place takes 32 bytes; the rows take 2,300.
struct SplinePlaces {
    /// The vertices around a regular cell: vertex i + 4j + 16k is i − 1 cells along u, j − 1 along
    /// v and k − 1 along w away from corner 0 of the cell. kMaxIndex where a boundary has no layer.
    using Patch = std::array<Index, 64>;

    struct Place {
        std::array<double, 3> uvw = {};  ///< in the axes of the patch, 0 to 1
        Index patch = kMaxIndex;         ///< kMaxIndex: the point has no such place
        friend bool operator==(const Place&, const Place&) = default;
    };

    double spacing = 0;  ///< 2⁻ⁿ for level n; 0 for the limit
    std::vector<Patch> patches = {};
    std::vector<Place> places = {};         ///< one per point, or none at all
    std::vector<PointWeight> weights = {};  ///< one per place; or none, and all points follow fully

    friend bool operator==(const SplinePlaces&, const SplinePlaces&) = default;
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
/// as thick, to 1e-11. Transform normals by the cofactor
/// matrix of F, tangents by F.
struct Gradients {
    GradientTables tables;  ///< points × base vertices; a row is empty if the point has a place
    SplinePlaces splines = {};

    Index rowCount() const { return tables[0].rowCount(); }
    Index columnCount() const { return tables[0].columnCount(); }

    /// Returns how many points have the identity in every pose.
    ESPALIER_API Index identityCount() const;

    /// \throws Error unless the tables have one shape, each place is in a patch that exists and
    ///         has finite coordinates, each patch has the 8 vertices of its cell, of the base, and
    ///         weights are 0 to 1 with finite slopes
    ESPALIER_API void check() const;

    friend bool operator==(const Gradients&, const Gradients&) = default;
};

/// Adds F − 1 of the points that have a place to `sums`, for one pose.
/// \param rest, displacements one per base vertex: the lattice at rest, and p' − p
/// \param sums one per point
/// \cost 0.5 µs for each point on two cores
ESPALIER_API void addSplineGradients(const SplinePlaces& splines, std::span<const Point3> rest,
                                     std::span<const Point3> displacements,
                                     std::span<DeformationGradient> sums);

/// Returns the tables with a row for each point, also for those that have a place.
/// \param rest the lattice at rest, one position per base vertex
/// \cost O(entries), in parallel
ESPALIER_API GradientTables gradientTables(const Gradients& gradients,
                                           std::span<const Point3> rest);

/// Returns the tables of F from three directions at each point. F maps the directions T X of the
/// rest X to the directions T x of the pose x: Fᵀ = (T X)⁻¹ T x. Rows are empty where T X spans no
/// volume.
/// \param directions T: three rows for each point, over the base; they sum to 0
/// \param rest X
/// \param scale factor for the gradients by X
/// \cost O(entries), in parallel
ESPALIER_API GradientTables gradientsOf(const stencils::StencilTable<double>& directions,
                                        std::span<const Point3> rest, double scale);

}  // namespace espalier::embed
