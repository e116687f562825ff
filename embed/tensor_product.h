// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/basis_functions.h>
#include <espalier/embed/embedding.h>
#include <espalier/far/box_grid.h>

#include <Eigen/Core>
#include <array>
#include <functional>
#include <span>
#include <vector>

namespace espalier::embed {

/// A place in a box lattice, in cells along its axes (see far::BoxGrid). `offset` goes on from
/// there along the tangent of the map: 0 in the region, but for rounding.
struct TensorPlace {
    std::array<double, 3> at = {};  ///< in the region: axisRange() of each axis
    std::array<double, 3> offset = {};
};

using TensorEmbedding = PlacedPoints<TensorPlace>;

/// The free-form deformations that came before lattices of arbitrary topology: a box lattice that
/// lies on a parallelepiped, evenly divided, and weighs its vertices by products of one basis
/// function an axis.
///
/// Both bases have linear precision: at rest the map is the affine one of the parallelepiped, so
/// that the place of a point is its local coordinates. The region of a Bézier lattice is the whole
/// box; that of a B-spline lattice is the box without the outer layer of cells, which is the limit
/// of Boundary::Open, as its map is the limit of the subdivision.
///
/// Any number of threads may ask.
///
/// \cite MacCracken & Joy 1996, sections 1 and 4, on Sederberg & Parry 1986 and Griessmair &
///       Purgathofer 1989
class ESPALIER_API TensorLattice {
public:
    /// \param complex a box of hexahedra; kept (a cheap copy)
    /// \param rest one position a vertex; copied
    /// \throws TopologyError if `complex` is not a box; Error if `rest` does not fit it, is not
    ///         finite, or is not a parallelepiped evenly divided and with volume, naming the vertex
    ///         that is farthest from such a one and its distance; Error if a B-spline lattice has
    ///         under 3 cells along an axis, and so no region
    /// \cost O(cells)
    TensorLattice(const far::CellComplex& complex, std::span<const Point3> rest, Basis basis);

    const far::CellComplex& complex() const { return complex_; }

    /// The status, place and distance of a point, as PointLocator has them. A point outside goes
    /// with the nearest place of the region. The residual is that of the rest positions themselves:
    /// what they are off an affine grid, besides rounding.
    ///
    /// \param tolerance how far outside still counts as inside, in parts of the bounding box's
    ///        diagonal
    Located<TensorPlace> locate(const Point3& point, double tolerance, bool seekNearest) const;

    /// The weights of the vertices at a place: each vertex once, no zeros. At most 64 (B-spline) or
    /// all vertices (Bézier). They sum to 1, and are between 0 and 1 where the offset is 0.
    std::vector<VertexWeight> weights(const TensorPlace& place) const;

private:
    void fitAxes();
    void invertAxes();
    void checkFit() const;
    Eigen::Vector3d nearestInRegion(const Eigen::Vector3d& point) const;
    Eigen::Vector3d positionAt(const Eigen::Vector3d& at) const { return origin_ + axes_ * at; }
    Eigen::Vector3d restAt(Index vertex) const { return Eigen::Vector3d(rest_[vertex].data()); }

    far::CellComplex complex_;
    std::vector<Point3> rest_;
    Basis basis_;
    far::BoxGrid grid_;
    Eigen::Vector3d low_, high_;  ///< corners of the region, in cells
    double size_;                 ///< diagonal of the bounding box
    Eigen::Vector3d origin_;      ///< of the affine grid: where grid point (0, 0, 0) lies
    Eigen::Matrix3d axes_;        ///< column a: one cell along axis a
    Eigen::Matrix3d toCells_;     ///< inverse of axes_
};

/// Finds each point in a box lattice, as embedPoints() does in a refined one: the same statuses and
/// policies, errors included. \cost O(points · weights of a place), in parallel
ESPALIER_API TensorEmbedding embedPoints(const TensorLattice& lattice,
                                         std::span<const Point3> points,
                                         const EmbeddingOptions& options = {},
                                         const std::function<void(Offset)>& progress = {});

/// D: row i holds the weights of point i over the vertices of the lattice. Rows sum to 1, or are
/// empty for points without a place. Full of Bézier weights, it has points × vertices entries.
///
/// \throws Error if the embedding is in a lattice with another number of vertices
/// \cost O(entries), in parallel
ESPALIER_API stencils::StencilTable<double> buildDeformationTable(const TensorLattice& lattice,
                                                                  const TensorEmbedding& embedding);

}  // namespace espalier::embed
