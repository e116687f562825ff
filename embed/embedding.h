// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/base/word.h>
#include <espalier/embed/located_point.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/factored_table.h>
#include <espalier/stencils/levels.h>
#include <espalier/stencils/row_order.h>
#include <espalier/stencils/stencil_table.h>

#include <algorithm>
#include <functional>
#include <span>
#include <vector>

namespace espalier::embed {

/// How to treat a point outside the region of the lattice.
enum class OutsidePolicy {
    Keep,  ///< the point stays in place: its row of D is empty
    /// The nearest cell carries the point, along the tangent of the cell's map. A point whose
    /// weights would sum to more than kMaxRowSum in absolute value stays in place, as under Keep.
    Nearest,
    Error  ///< binding throws an exception
};
inline constexpr Word<OutsidePolicy> kOutsidePolicyWords[] = {{"keep", OutsidePolicy::Keep},
                                                              {"nearest", OutsidePolicy::Nearest},
                                                              {"error", OutsidePolicy::Error}};

/// Upper bound of Σ |w| in each row of D. No pose moves a point farther than this multiple of the
/// largest displacement of a vertex.
///
/// The weights of points in cells of well-shaped lattices sum to little more than 1. They grow with
/// the distance of a point outside: by 2 for each cell of the base along an axis. So a point beside
/// a face of a box is carried up to 3.5 cells away. Beside a cell that is nearly flat or folded,
/// the tangent is no guide to the surroundings of the cell, and weights grow beyond all bounds.
inline constexpr double kMaxRowSum = 8;

/// The finest level that points can be bound to. Its cells are a millionth of a base cell across,
/// about the default tolerance: on finer levels a point would be within the tolerance of more and
/// more cells.
inline constexpr int kMaxLevelOfPoints = 20;

/// A lattice at rest, which points are bound to.
struct RestLattice {
    const far::TopologyRefiner& base;   ///< a lattice at level 0
    std::span<const Point3> positions;  ///< one per vertex of the base
};

struct EmbeddingOptions {
    OutsidePolicy outside = OutsidePolicy::Keep;

    /// Distance within which a point outside still counts as inside, as a fraction of the diagonal
    /// of the lattice's bounding box. Models in single precision are rounded to 6e-8 of their
    /// coordinates, so a point that is meant to be on the boundary may be outside by about this
    /// distance.
    double tolerance = 1e-6;
};

/// The places of a model's points in a lattice.
template <class Place>
struct PointPlaces {
    Array<Located<Place>> points;  ///< one per point, in the order of the points
    Index vertexCount = 0;         ///< number of vertices of the lattice

    Index count(PointStatus status) const {
        return static_cast<Index>(
            std::count_if(points.begin(), points.end(),
                          [&](const auto& point) { return point.status == status; }));
    }

    /// Largest distance between a point and the position of its place; 0 if no point has a place.
    double largestResidual() const {
        double largest = 0;
        for (const Located<Place>& point : points)
            if (point.place) largest = std::max(largest, point.residual);
        return largest;
    }

    /// The same for the points that have a row.
    /// \param rows one per point
    double largestResidual(const stencils::StencilTable<double>& rows) const {
        double largest = 0;
        for (std::size_t i = 0; i < points.size(); ++i)
            if (!rows.columns(static_cast<Index>(i)).empty())
                largest = std::max(largest, points[i].residual);
        return largest;
    }
};

/// Places of points in the cells of level 1 or above.
using Embedding = PointPlaces<CellPlace>;

/// Finds each point in a refined lattice.
///
/// \param complex a lattice of level 1 or above
/// \param positions of the vertices of `complex`, at rest
/// \param progress called now and then with the number of points done, from any thread; may be
///        empty
/// \throws Error under OutsidePolicy::Error if a point is not inside (names the first one); if
///         `complex` is not a lattice of quadrilaterals, `positions` do not fit it or are not
///         finite, or the tolerance is out of range
/// \cost O(cells log cells + points log cells), in parallel. The result does not depend on the
///       number of threads.
/// \cite MacCracken & Joy 1996, sections 4 to 6
ESPALIER_API Embedding embedPoints(const far::CellComplex& complex,
                                   std::span<const Point3> positions,
                                   std::span<const Point3> points,
                                   const EmbeddingOptions& options = {},
                                   const std::function<void(Offset)>& progress = {});

/// Returns W: row i contains the weights of point i over the vertices of the refined lattice, 8
/// entries in a hexahedron, 2n + 2 in a type-n cell. Rows sum to 1; the row of a point without a
/// place is empty.
/// \throws Error if the embedding is in a lattice with another number of vertices
ESPALIER_API stencils::StencilTable<double> buildEmbeddingTable(const far::CellComplex& complex,
                                                                const Embedding& embedding);

/// Returns the derivatives of W by the coordinates of the places: rows 3i to 3i + 2 are the
/// directions in which point i moves with u, v and w. Rows sum to 0; they are empty for a point
/// without a place. The offset of a place has no effect.
/// \throws Error if the embedding is in a lattice with another number of vertices
ESPALIER_API stencils::StencilTable<double> buildDirectionTable(const far::CellComplex& complex,
                                                                const Embedding& embedding);

/// Returns the order in which to multiply the rows of W by S_level: grouped by base cell, since the
/// points in a base cell depend on the vertices around it.
/// \param baseCells for each cell of the level, the number of its base cell
ESPALIER_API stencils::RowOrder orderByBaseCell(const Embedding& embedding,
                                                std::span<const Index> baseCells, Index groupCount);

/// Returns D = W · S_level: row i contains the weights of point i over the base vertices, so that
/// x' = D · p'. D is also the Jacobian of the points by the lattice vertices. Rows sum to 1, or are
/// empty. A row whose weights would sum to more than kMaxRowSum in absolute value is empty. Only
/// the rows of S_level that W needs are computed.
///
/// \param embedding in level `level` of `refiner`
/// \cost O(products of entries), in parallel
ESPALIER_API stencils::StencilTable<double> buildDeformationTable(
    const far::TopologyRefiner& refiner, int level, const Embedding& embedding);

/// The same for an embedding in the finest level of `levels`.
ESPALIER_API stencils::StencilTable<double> buildDeformationTable(const stencils::Levels& levels,
                                                                  const Embedding& embedding);

/// Returns W and the rows of S_level that it needs, in the order of the vertices of the level. A
/// row of W is empty where the row of D is.
///
/// \param embedding in level `level` of `refiner`
/// \cost O(products of entries of S_level), in parallel
ESPALIER_API stencils::FactoredTable<double> buildFactoredTable(const far::TopologyRefiner& refiner,
                                                                int level,
                                                                const Embedding& embedding);

/// The same for an embedding in the finest level of `levels`.
ESPALIER_API stencils::FactoredTable<double> buildFactoredTable(const stencils::Levels& levels,
                                                                const Embedding& embedding);

}  // namespace espalier::embed
