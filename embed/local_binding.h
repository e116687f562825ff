// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/binding.h>
#include <espalier/stencils/factored_table.h>

#include <functional>
#include <span>
#include <vector>

// embed/: points to rows.
//
// In: a lattice at rest, points, a level n. Out: a Binding, which holds the deformation matrix D.
//
// Types: RestLattice; CellPlace, a place in a cell; CellSolver, which finds it; LevelSearch, which
// locates groups of points in a level; PointDescent, which refines only the cells that can hold a
// point; Binding. nested_lattices.h binds a lattice to a lattice, continuity.h tells which vertices
// to freeze, tensor_product.h binds to Bézier and B-spline lattices.
//
// Read binding.h, this header, cell_place.h, cell_solver.h, level_search.h, then point_descent.h.
//
// Notation: W is points over level n; D = W · S_n is points over the base; x' = D · p' for a pose
// p'.
namespace espalier::embed {

/// A model bound to a lattice, and how that went for each point.
template <class Table>
struct BindingResultOf {
    BindingOf<Table> binding;
    std::vector<PointStatus> statuses;  ///< one a point
    double largestResidual = 0;         ///< see PlacedPoints::largestResidual()

    Index count(PointStatus status) const {
        return static_cast<Index>(std::count(statuses.begin(), statuses.end(), status));
    }
};

using BindingResult = BindingResultOf<stencils::StencilTable<double>>;

struct BindingOptions {
    int level = 3;  ///< of the lattice, 1 to kMaxLevelOfPoints
    EmbeddingOptions embedding = {};

    /// Called now and then with the number of points done, from any thread; or empty.
    std::function<void(Offset)> progress = {};
};

/// Binds points to a level of a lattice that is refined no further than they ask for.
///
/// The result is, to the last bit, what refining the whole lattice, embedPoints() and
/// buildDeformationTable() give. But only cells that can still hold a point are refined, with what
/// their rules need around them; points are taken in groups that lie together, and of each group
/// only its rows of D are kept. So memory is that of D, of the base, and of what a group needs, at
/// any level: binding a million points at level 8 of a thousand cells is possible, which has 16
/// milliards of cells.
///
/// The tolerance is a fraction of the diagonal of the base lattice's bounding box.
///
/// \throws Error as embedPoints(), and for a base of other levels; TopologyError as
///         far::TopologyRefiner::refineUniform(); MemoryError if D is beyond a
///         MemoryLimit: within seconds where cells have hundreds of vertices, and so rows of D
///         thousands of weights
/// \cost O(points · (level + log base cells + entries of D a point)), once the cells are smaller
///       than the distances between points. In parallel; the result does not depend on the number
///       of threads
/// \cite MacCracken & Joy 1996, sections 4 to 6
ESPALIER_API BindingResult bindPoints(const RestLattice& lattice, std::span<const Point3> points,
                                      const BindingOptions& options = {});

/// Binds points to a box lattice with Bézier or B-spline weights: embedPoints() and makeBinding().
/// \throws Error as embedPoints()
ESPALIER_API BindingResult bindPoints(const TensorLattice& lattice, std::span<const Point3> points,
                                      const EmbeddingOptions& options = {},
                                      const std::function<void(Offset)>& progress = {});

/// The same as binding to a level, with D left in its factors. Their product is the D of
/// bindPoints(), but for rounding. A vertex of the level may be there more than once, for points of
/// different groups.
///
/// \cost less, by the product
ESPALIER_API BindingResultOf<stencils::FactoredTable<double>> bindFactored(
    const RestLattice& lattice, std::span<const Point3> points, const BindingOptions& options = {});

}  // namespace espalier::embed
