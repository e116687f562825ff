// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/word.h>
#include <espalier/embed/point_location.h>
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

/// What becomes of a point outside the region of the lattice.
enum class OutsidePolicy {
    Keep,     ///< it stays in place: its row of D is empty
    Nearest,  ///< the nearest cell carries it, along the tangent of its map
    Error     ///< binding is refused
};
inline constexpr Word<OutsidePolicy> kOutsidePolicyWords[] = {{"keep", OutsidePolicy::Keep},
                                                              {"nearest", OutsidePolicy::Nearest},
                                                              {"error", OutsidePolicy::Error}};

/// The finest level that points are bound to. Its cells are a millionth of a base cell across, as
/// fine as the tolerance below: on levels above it a point would be in ever more cells at once.
inline constexpr int kMaxLevelOfPoints = 20;

/// A lattice at rest, to which points are bound.
struct RestLattice {
    const far::TopologyRefiner& base;   ///< a lattice at level 0
    std::span<const Point3> positions;  ///< of its vertices
};

struct EmbeddingOptions {
    OutsidePolicy outside = OutsidePolicy::Keep;

    /// How far outside a point still counts as inside, as a fraction of the diagonal of the
    /// lattice's bounding box. Models in single precision are rounded to 6e-8 of their coordinates,
    /// so a point that was meant to lie on the boundary may lie so far outside, and a little more.
    double tolerance = 1e-6;
};

/// Where each point of a model lies in a lattice.
template <class Place>
struct PlacedPoints {
    std::vector<Located<Place>> points;  ///< one a point, in their order
    Index vertexCount = 0;               ///< vertices of the lattice that the places are in

    Index count(PointStatus status) const {
        return static_cast<Index>(
            std::count_if(points.begin(), points.end(),
                          [&](const auto& point) { return point.status == status; }));
    }

    /// The largest distance of a point from the position of its place; 0 without places.
    double largestResidual() const {
        double largest = 0;
        for (const Located<Place>& point : points)
            if (point.place) largest = std::max(largest, point.residual);
        return largest;
    }
};

/// Places in the cells of a level of a lattice, 1 or above.
using Embedding = PlacedPoints<CellPlace>;

/// Finds each point in a refined lattice.
///
/// \param complex a lattice of level 1 or above
/// \param positions of its vertices, at rest
/// \param progress called now and then with the number of points done, from any thread, or empty
/// \throws Error under OutsidePolicy::Error if a point is not inside, naming the first; and what
///         PointLocator throws
/// \cost O(cells log cells + points log cells), in parallel. The result does not depend on the
///       number of threads.
/// \cite MacCracken & Joy 1996, sections 4 to 6
ESPALIER_API Embedding embedPoints(const far::CellComplex& complex,
                                   std::span<const Point3> positions,
                                   std::span<const Point3> points,
                                   const EmbeddingOptions& options = {},
                                   const std::function<void(Offset)>& progress = {});

/// W: row i holds the weights of point i over the vertices of the refined lattice; 8 entries in a
/// hexahedron, 2n + 2 in a type-n cell. Rows sum to 1; the row of a point without a place is empty.
/// \throws Error if the embedding is in a lattice with another number of vertices
ESPALIER_API stencils::StencilTable<double> buildEmbeddingTable(const far::CellComplex& complex,
                                                                const Embedding& embedding);

/// The order of the rows of W for the product with S_level: the points in a base cell lead to the
/// vertices around it.
/// \param baseCells for each cell of the level a number of the base cell that it lies in
ESPALIER_API stencils::RowOrder orderByBaseCell(const Embedding& embedding,
                                                std::span<const Index> baseCells, Index groupCount);

/// D = W · S_level: row i holds the weights of point i over the base vertices, so that x' = D · p'.
/// It is also the Jacobian of the points by the lattice vertices. Rows sum to 1, or are empty. Only
/// the rows of S_level that W asks for are made.
///
/// \param embedding in level `level` of `refiner`
/// \cost O(products of entries), in parallel
ESPALIER_API stencils::StencilTable<double> buildDeformationTable(
    const far::TopologyRefiner& refiner, int level, const Embedding& embedding);

/// The same in the finest of some levels.
ESPALIER_API stencils::StencilTable<double> buildDeformationTable(const stencils::Levels& levels,
                                                                  const Embedding& embedding);

/// W and the rows of S_level that it asks for, in the order of the vertices of the level.
///
/// \param embedding in level `level` of `refiner`
/// \cost O(products of entries of S_level), in parallel
ESPALIER_API stencils::FactoredTable<double> buildFactoredTable(const far::TopologyRefiner& refiner,
                                                                int level,
                                                                const Embedding& embedding);

/// The same in the finest of some levels.
ESPALIER_API stencils::FactoredTable<double> buildFactoredTable(const stencils::Levels& levels,
                                                                const Embedding& embedding);

}  // namespace espalier::embed
