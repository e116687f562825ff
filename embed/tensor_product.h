// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/basis_functions.h>
#include <espalier/embed/local_binding.h>
#include <espalier/embed/rounded_product.h>
#include <espalier/far/box_grid.h>

#include <Eigen/Core>
#include <array>
#include <functional>
#include <span>
#include <vector>

namespace espalier::embed {

/// A place in a box lattice, in cells along its axes (see far::BoxGrid). For a point outside the
/// region, `offset` continues from there along the tangent of the map; inside, it is 0 up to
/// rounding.
struct TensorPlace {
    std::array<double, 3> at = {};  ///< a place in the region: within axisRange() of each axis
    std::array<double, 3> offset = {};
};

using TensorEmbedding = PointPlaces<TensorPlace>;

/// A lattice as in the free-form deformations before subdivision: an evenly divided parallelepiped,
/// whose vertices are weighted by products of three basis functions, one per axis.
///
/// Both bases have linear precision: at rest, the map is the affine map of the parallelepiped, so
/// the place of a point is its local coordinates. The region of a Bézier lattice is the whole box.
/// The region of a B-spline lattice is the box without the outer layer of cells; region and map are
/// the limit of subdivision under Boundary::Open.
///
/// Any number of threads may use it at once.
///
/// \cite MacCracken & Joy 1996, sections 1 and 4, on Sederberg & Parry 1986 and Griessmair &
///       Purgathofer 1989
class ESPALIER_API TensorLattice {
public:
    /// \param complex a box of hexahedra; kept (a cheap copy)
    /// \param rest one position per vertex; copied
    /// \throws TopologyError if `complex` is not a box; Error if `rest` does not fit it, is not
    ///         finite, or is not an evenly divided parallelepiped with a volume (names the vertex
    ///         farthest from its place in one, and its distance); Error if a B-spline lattice has
    ///         fewer than 3 cells along an axis, and so no region
    /// \cost O(cells)
    TensorLattice(const far::CellComplex& complex, std::span<const Point3> rest, Basis basis);

    const far::CellComplex& complex() const { return complex_; }
    Basis basis() const { return basis_; }
    const far::BoxGrid& grid() const { return grid_; }

    /// Memory for the weights of one place after another.
    struct Row {
        std::array<AxisFunctions, 3> axes = {};
        std::vector<VertexWeight> weights = {};
    };

    /// Returns the status, place and distance of a point, defined as in PointLocator. The nearest
    /// place of the region carries a point outside. The residual is the deviation of the rest
    /// positions from an affine grid, plus rounding.
    ///
    /// \param tolerance distance within which a point outside still counts as inside, as a fraction
    ///        of the bounding box's diagonal
    Located<TensorPlace> locate(const Point3& point, double tolerance, bool seekNearest) const;

    /// Does the same with existing memory for the weights of the place.
    Located<TensorPlace> locate(const Point3& point, double tolerance, bool seekNearest,
                                Row& row) const;

    /// Returns the weights of the vertices at a place, in ascending order of the vertices, without
    /// zeros: at most 64 (B-spline) or one for every vertex (Bézier). They sum to 1, and are
    /// between 0 and 1 if the offset is 0.
    std::vector<VertexWeight> weights(const TensorPlace& place) const;

    std::span<const Point3> rest() const { return rest_; }

    /// Sets row.weights to these weights.
    void setWeights(const TensorPlace& place, Row& row) const;

private:
    void fitAxes();
    void invertAxes();
    void checkFit() const;
    Eigen::Vector3d nearestInRegion(const Eigen::Vector3d& point) const;
    Eigen::Vector3d positionAt(const Eigen::Vector3d& at) const {
        return origin_ + roundedProduct(axes_, at);
    }
    Eigen::Vector3d restAt(Index vertex) const { return Eigen::Vector3d(rest_[vertex].data()); }

    far::CellComplex complex_;
    std::vector<Point3> rest_;
    Basis basis_;
    far::BoxGrid grid_;
    bool isAscending_;            ///< true if the vertices of the grid are in ascending order
    Eigen::Vector3d low_, high_;  ///< corners of the region, in cells
    double size_;                 ///< diagonal of the bounding box
    Eigen::Vector3d origin_;      ///< the position of grid point (0, 0, 0) of the affine grid
    Eigen::Matrix3d axes_;        ///< column a: one cell along axis a
    Eigen::Matrix3d toCells_;     ///< inverse of axes_
};

/// Finds each point in a box lattice, with the same statuses and policies as embedPoints() for a
/// refined lattice.
/// \throws Error under OutsidePolicy::Error if a point is not inside (names the first one);
///         ArgumentError if the tolerance is out of range
/// \cost O(points · weights per place), in parallel
ESPALIER_API TensorEmbedding embedPoints(const TensorLattice& lattice,
                                         std::span<const Point3> points,
                                         const EmbeddingOptions& options = {},
                                         const std::function<void(Offset)>& progress = {});

/// Returns D: row i contains the weights of point i over the vertices of the lattice. Rows sum to
/// 1, or are empty for points without a place and where weights would exceed kMaxRowSum. With a
/// Bézier basis, D has up to points × vertices entries.
///
/// \throws Error if the embedding is in a lattice with another number of vertices
/// \cost O(entries), in parallel
ESPALIER_API stencils::StencilTable<double> buildDeformationTable(const TensorLattice& lattice,
                                                                  const TensorEmbedding& embedding);

/// Returns the gradients of D, by the derivatives of the basis at the places.
/// \throws Error if the embedding is in a lattice with another number of vertices
/// \cost O(points + vertices)
ESPALIER_API Gradients buildGradients(const TensorLattice& lattice,
                                      const TensorEmbedding& embedding);

/// Binds points to a box lattice with Bézier or B-spline weights: embedPoints(),
/// buildDeformationTable() and, on request, buildGradients().
/// \param options the level has no meaning here
/// \throws Error under OutsidePolicy::Error if a point is not inside (names the first one);
///         ArgumentError if the tolerance is out of range
ESPALIER_API BoundRows<> bindPoints(const TensorLattice& lattice, std::span<const Point3> points,
                                    const BindingOptions& options = {});

/// Binds points as bindPoints() does, but makes no D: gives the rows of each group of points to
/// `sink` (embed::bindInGroups()).
/// \throws ArgumentError if the tolerance is out of range
ESPALIER_API void bindInGroups(const TensorLattice& lattice, std::span<const Point3> points,
                               const BindingOptions& options, RowSink sink);

}  // namespace espalier::embed
