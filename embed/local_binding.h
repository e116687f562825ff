// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/function_ref.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/gradients.h>
#include <espalier/stencils/factored_table.h>

#include <functional>
#include <optional>
#include <span>
#include <vector>

// embed/: binds points to a lattice, as rows of a sparse matrix.
//
// In: a lattice at rest, points, a level n. Out: BoundRows, which hold the deformation matrix D and
// the status of each point.
//
// Types: RestLattice; TricubicPatch, the map of a regular cell; RegularSearch, which finds points
// in regular cells by formula; CellPlace, a place in a refined cell; CellSolver, which finds the
// place; LevelSearch, which locates groups of points in a level; PointDescent, which refines only
// the cells that may contain a point; BoundRows. nested_lattices.h binds a lattice to a lattice,
// continuity.h finds the vertices to freeze, tensor_product.h binds to Bézier and B-spline
// lattices.
//
// Read this header, regular_search.h, tricubic_patch.h, cell_place.h, cell_solver.h,
// level_search.h, then point_descent.h.
//
// Notation: W is points over level n; D = W · S_n is points over the base; x' = D · p' for a pose
// p'.
namespace espalier::embed {

/// The rows of points in a lattice. With p' the base vertices of a pose, the deformed points are
/// x' = D · p'; points whose rows are empty stay where they were. bind::Binding adds what is needed
/// to deform a model.
///
/// Table is StencilTable<double> or FactoredTable<double>.
///
/// \cite MacCracken & Joy 1996, section 5
template <class Table = stencils::StencilTable<double>>
struct BoundRows {
    Table table;                              ///< D: points × base vertices
    std::vector<PointStatus> statuses;        ///< one per point
    double largestResidual = 0;               ///< see PointPlaces::largestResidual()
    std::optional<Gradients> gradients = {};  ///< made on request
    std::vector<CarriedPoint> carried = {};   ///< the points outside that have a place

    Index count(PointStatus status) const {
        return static_cast<Index>(std::count(statuses.begin(), statuses.end(), status));
    }

    friend bool operator==(const BoundRows&, const BoundRows&) = default;
};

struct BindingOptions {
    int level = 3;  ///< the level whose cells hold the points, 1 to kMaxLevelOfPoints
    EmbeddingOptions embedding = {};
    bool gradients = false;  ///< makes BoundRows::gradients; has no effect on bindFactored()

    /// Called now and then with the number of points done, from any thread; may be empty.
    std::function<void(Offset)> progress = {};
};

/// Binds points to a level of a lattice.
///
/// In the regular cells of the base (isRegularCell()) the level is a product of splines: Newton's
/// method finds the place of a point, its row follows from a formula, and nothing is refined. See
/// RegularSearch.
///
/// For all other points the function refines only the cells that can still contain a point, and the
/// cells around them that their rules need. It processes points in groups of neighbours, and keeps
/// only the rows of D of each group. So at any level it needs memory for D, for the base, and for
/// one group per thread: it can bind a million points at level 8 of a thousand cells, although that
/// level has 16 billion cells. If the level has at most as many cells as there are such points, and
/// few columns in each row, the function refines the whole level, and needs memory for it, for W
/// and for D.
///
/// Statuses are the same as of embedPoints() in the whole level, except that a point inside whose
/// weights exceed kMaxRowSum is NotConverged. Weights are the same as of
/// buildDeformationTable(), to the last bit for points outside regular cells, and up to rounding in
/// regular cells: coordinates are rounded by about 1e-15 of the lattice, and weights by as much in
/// units of a base cell. In a lattice that is folded over itself, a point in several cells belongs
/// to a regular one.
///
/// The tolerance is a fraction of the diagonal of the base lattice's bounding box.
///
/// \throws Error under OutsidePolicy::Error if a point is not inside (names the first one); if the
///         base is not a lattice or has been refined, or the positions do not fit it or are not
///         finite; ArgumentError if the level or the tolerance is out of range; TopologyError if a
///         level has too many entities or, under Boundary::Open, no cells; MemoryError if D exceeds
///         a MemoryLimit. If cells have hundreds of vertices, and so rows of D thousands of
///         weights, it is thrown within seconds
/// \cost In regular cells O(points · log base cells) at any level: 0.6 µs for each point. Elsewhere
///       O(points · (level + log base cells + entries of D per point)), once the cells are smaller
///       than the distances between points. In parallel; the result does not depend on the number
///       of threads
/// \cite MacCracken & Joy 1996, sections 2.2 and 4 to 6
ESPALIER_API BoundRows<> bindPoints(const RestLattice& lattice, std::span<const Point3> points,
                                    const BindingOptions& options = {});

/// Gets the rows of some points, and the numbers of these points in the model, in the same order.
/// It may be called from several threads at once.
using RowSink = FunctionRef<void(std::span<const Index> points, BoundRows<> rows)>;

/// Binds points to a level, as bindPoints() does, but makes no D: gives the rows of each group of
/// neighbouring points to `sink`, which uses them while they are in the cache. The rows have the
/// same bits as those of D. The gradients of a group are those of the group alone.
///
/// Each point is in one group. OutsidePolicy::Error has no effect: the statuses tell which points
/// are not inside.
///
/// \throws Error, ArgumentError, TopologyError as bindPoints()
/// \cost as bindPoints(), without the memory of D: it needs memory for the base, for 4 bytes for
///       each point, and for one group per thread, which has up to 16,000 points or, where cells
///       are not regular and a level has few, 260,000
ESPALIER_API void bindInGroups(const RestLattice& lattice, std::span<const Point3> points,
                               const BindingOptions& options, RowSink sink);

/// Binds points to a level, by refinement, and leaves D in its factors. Their product is the D of
/// bindPoints(), up to rounding. The table may contain a vertex of the level several times, for
/// points of different groups, unless the level has at most as many cells as there are points.
///
/// \cost the cost of bindPoints() outside regular cells, without the product
ESPALIER_API BoundRows<stencils::FactoredTable<double>> bindFactored(
    const RestLattice& lattice, std::span<const Point3> points, const BindingOptions& options = {});

}  // namespace espalier::embed
