// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/function_ref.h>
#include <espalier/base/point.h>
#include <espalier/base/progress.h>
#include <espalier/embed/box_tree.h>
#include <espalier/embed/cell_bounds.h>
#include <espalier/embed/cell_solver.h>
#include <espalier/embed/embedding.h>
#include <espalier/stencils/levels.h>

#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace espalier::embed {

using Extent = far::TopologyRefiner::Extent;

/// Which cells to seek for a point.
enum class SoughtCells {
    Containing,  ///< those whose box contains the point
    Nearest      ///< the nearest one, and those whose box contains the point
};

/// The cells sought for each point: cells[offsets[i]] to cells[offsets[i + 1] − 1] for point i,
/// ascending.
struct CellsOfPoints {
    std::vector<Offset> offsets;
    std::vector<Index> cells;

    std::span<const Index> of(Index point) const {
        return {cells.data() + offsets[point], cells.data() + offsets[point + 1]};
    }
};

/// Pairs of a cell of a level and a point that is sought in it, sorted by cell.
struct Candidates {
    std::vector<Index> cells;                      ///< those with a point, ascending
    std::vector<std::optional<CellBound>> bounds;  ///< one per cell
    std::vector<Offset> offsets = {0};
    std::vector<Index> points;  ///< points[offsets[i]] to points[offsets[i + 1] − 1] belong to
                                ///< cells[i]: indices of the given points, ascending in each cell

    std::span<const Index> pointsOf(std::size_t i) const {
        return std::span(points).subspan(offsets[i], offsets[i + 1] - offsets[i]);
    }

    /// Ends the cell whose points were appended last; a cell without points is left out.
    void endCell(Index cell, const std::optional<CellBound>& bound) {
        if (static_cast<Offset>(points.size()) == offsets.back()) return;
        cells.push_back(cell);
        bounds.push_back(bound);
        offsets.push_back(static_cast<Offset>(points.size()));
    }

    /// Keeps only the pairs for which keep(i, point) is true; i is the position of the cell in
    /// `cells`.
    template <class Keep>
    void filter(Keep keep) {
        Candidates kept;
        std::size_t pairs = 0;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            for (const Index point : pointsOf(i)) {
                checkCancelledEvery(pairs++, 6);  // The place of a point may take milliseconds.
                if (keep(i, point)) kept.points.push_back(point);
            }
            kept.endCell(cells[i], bounds[i]);
        }
        *this = std::move(kept);
    }

    /// Returns the pairs for which isSought(cell, point) is true, sorted by point.
    template <class IsSought>
    CellsOfPoints cellsOfPoints(std::size_t pointCount, IsSought isSought) const {
        CellsOfPoints result;
        result.offsets.assign(pointCount + 1, 0);
        std::vector<std::pair<Index, Index>> pairs;
        for (std::size_t i = 0; i < cells.size(); ++i)
            for (const Index point : pointsOf(i)) {
                if (!isSought(cells[i], point)) continue;
                pairs.emplace_back(point, cells[i]);
                ++result.offsets[point + 1];
            }
        std::partial_sum(result.offsets.begin(), result.offsets.end(), result.offsets.begin());
        std::vector<Offset> next(result.offsets.begin(), result.offsets.end() - 1);
        result.cells.resize(pairs.size());
        for (const auto& [point, cell] : pairs) result.cells[next[point]++] = cell;
        return result;
    }
};

/// Which bound of a cell to use when testing whether it can contain a point.
enum class Bounding {
    AllLevels,  ///< contains the cell's descendants on all levels
    Estimate,   ///< the cell, slightly widened: quick, and correct except at strongly bent features
    Corners     ///< contains the cell's own corners only
};

/// The levels of a part of a lattice, refined as far as some points need, and the cells of the
/// finest level that may contain the points or have descendants that do.
struct Descent {
    stencils::Levels levels;          ///< level 0 has only the base cells around candidates
    std::vector<Index> baseVertices;  ///< numbers in the base of the vertices of level 0, ascending
    Candidates candidates;            ///< candidates in the finest level
    double margin;  ///< distance within which a point outside a cell's box still counts as in it
};

/// Refines a lattice only where given points need it: level by level, around the cells that can
/// still have a descendant that is sought. Any number of threads may use it at once.
class PointDescent {
public:
    /// \param lattice its base and positions must outlive this object
    PointDescent(const RestLattice& lattice, CellSolver::Scale scale);

    /// Returns level 0 around the cells that may contain the points, before any refinement. The
    /// margin is the tolerance plus the rounding error.
    /// \cost O(points × log base cells)
    Descent begin(std::span<const Point3> points, SoughtCells sought) const;

    /// The bounds of the base cells. Regular cells have one with a drift: isRegularCell().
    std::span<const std::optional<CellBound>> baseBounds() const { return bounds_; }

    /// The smallest margin: the rounding error of boxes.
    double rounding() const { return rounding_; }

    /// Refines one level around the candidates, of which there must be at least one. The new
    /// candidates are their children.
    /// \param extent Extent::Cells ends the descent: the new level cannot be refined further
    /// \throws TopologyError if the level would have too many entities or, under Boundary::Open,
    ///         none
    void refine(Descent& descent, std::span<const Point3> points, SoughtCells sought, Extent extent,
                Bounding bounding) const;

    /// Keeps the candidates that contain a point, or that may have the nearest cell of a point as a
    /// descendant.
    /// \param nearest one per point: an upper bound of the distance to the nearest cell, or
    ///        infinity if none is known. Lowered to the bound that the candidates give
    void keepNearest(Descent& descent, std::span<const Point3> points,
                     std::span<double> nearest) const;

    /// Receives the descent of some of the points: those from number `first` on, which are
    /// `points`. The descent may be moved from. There is none if no candidate was left on a coarser
    /// level, so that there was nothing to refine.
    using Use = FunctionRef<void(Offset first, std::span<const Point3> points,
                                 std::optional<Descent>& found)>;

    /// Refines down to a level. If cells are sought that contain a point, the candidates are those
    /// whose own box contains the point; otherwise, all those that may be nearest.
    ///
    /// If the levels would have too many cells, the points are divided into parts, one after the
    /// other, so that the memory does not grow with the number of points: neighbouring points that
    /// share no cells need about 64 cells each on each level.
    ///
    /// \param points each near the one before
    /// \param level 1 or above
    /// \param extent how much of the last level is refined around the candidates
    /// \param use called for one part after another
    /// \throws TopologyError if a level would have too many entities or, under Boundary::Open, none
    /// \cost O(points × (level + log base cells)), once the lattice is fine enough to tell the
    ///       points apart
    void descend(std::span<const Point3> points, int level, SoughtCells sought, Extent extent,
                 Use use) const;

private:
    Candidates baseCandidates(std::span<const Point3> points, SoughtCells sought) const;
    std::optional<Descent> descendAtOnce(std::span<const Point3> points, int level,
                                         SoughtCells sought, Extent extent,
                                         Offset* partCount) const;

    RestLattice lattice_;
    double rounding_;
    double margin_;                                 ///< rounding error plus tolerance
    std::vector<std::optional<CellBound>> bounds_;  ///< the bounds of the base cells
    /// Base cells with a bound, and without; cells that shrink away are in neither.
    std::vector<Index> bounded_, unbounded_;
    BoxTree tree_;  ///< the tree of the bounded cells
};

}  // namespace espalier::embed
