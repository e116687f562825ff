// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
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

/// Which cells are sought for a point.
enum class Sought {
    Containing,  ///< those in whose box it is
    Nearest      ///< the nearest one; and those in whose box it is
};

/// The cells sought for each point: those of point i are cells[offsets[i]] to … [i + 1], ascending.
struct CellsOfPoints {
    std::vector<Offset> offsets;
    std::vector<Index> cells;

    std::span<const Index> of(Index point) const {
        return {cells.data() + offsets[point], cells.data() + offsets[point + 1]};
    }
};

/// Pairs of cells of a level and points that are sought there, cell by cell.
struct Candidates {
    std::vector<Index> cells;                      ///< those with a point, ascending
    std::vector<std::optional<CellBound>> bounds;  ///< one a cell
    std::vector<Offset> offsets = {0};
    std::vector<Index> points;  ///< points[offsets[i]] to points[offsets[i + 1] − 1] of cells[i]:
                                ///< as they were given, counted from 0; ascending in a cell

    std::span<const Index> pointsOf(std::size_t i) const {
        return std::span(points).subspan(offsets[i], offsets[i + 1] - offsets[i]);
    }

    /// Ends the cell whose points were appended last; without any it is left out.
    void endCell(Index cell, const std::optional<CellBound>& bound) {
        if (static_cast<Offset>(points.size()) == offsets.back()) return;
        cells.push_back(cell);
        bounds.push_back(bound);
        offsets.push_back(static_cast<Offset>(points.size()));
    }

    /// Leaves the pairs of which keep(i, point) is true, with i the position of the cell.
    template <class Keep>
    void filter(Keep keep) {
        Candidates kept;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            for (const Index point : pointsOf(i))
                if (keep(i, point)) kept.points.push_back(point);
            kept.endCell(cells[i], bounds[i]);
        }
        *this = std::move(kept);
    }

    /// The same pairs point by point, as far as isSought(cell, point) is true.
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

/// Where a cell is taken to lie.
enum class Bounding {
    Future,  ///< with all that it may become
    Likely,  ///< near the cell as it is: quick, and right but at strongly bent features
    Itself   ///< between its corners
};

/// Levels of a lattice as far as they have been refined for some points, and the cells of the
/// finest that may hold them, or become one that does.
struct Descent {
    stencils::Levels levels;
    Candidates candidates;  ///< in the finest level
    double margin;          ///< how far from the box of a cell a point still counts as in it
};

/// Refines a lattice no further than points ask for: level by level, only around the cells that can
/// still become one that is sought. Any number of threads may ask.
class PointDescent {
public:
    /// \param lattice its base and positions must outlive this
    PointDescent(const RestLattice& lattice, CellSolver::Scale scale);

    /// Level 0: nothing has been refined. The margin is the tolerance, and the rounding.
    Descent begin(std::span<const Point3> points, Sought sought) const;

    /// The least margin: the rounding of boxes.
    double rounding() const { return rounding_; }

    /// Goes on to the next level, around the candidates; those that are left then are their
    /// children. There must be some.
    /// \param extent Cells ends the descent
    /// \throws TopologyError as far::TopologyRefiner::refineAround()
    void refine(Descent& descent, std::span<const Point3> points, Sought sought,
                far::TopologyRefiner::Extent extent, Bounding bounding) const;

    /// Leaves the cells that may become the nearest one of a point, or one that it is in.
    /// \param nearest one a point: how near one is known to be; infinity where none is. Goes down
    ///        to what the candidates tell
    void keepNearest(Descent& descent, std::span<const Point3> points,
                     std::span<double> nearest) const;

    /// All of that to a level, which is the last one: its candidates are those in whose own box a
    /// point is, or all that may be nearest.
    /// \param level 1 or above
    /// \param extent how much of the level is made around the cells that were sought
    /// \return nothing if no cell of a level above is left, and so nothing to refine
    /// \throws TopologyError as refine()
    /// \cost O(points × (level + log base cells)), once the lattice is fine enough to tell the
    ///       points apart
    std::optional<Descent> descend(std::span<const Point3> points, int level, Sought sought,
                                   far::TopologyRefiner::Extent extent) const;

private:
    Candidates baseCandidates(std::span<const Point3> points, Sought sought) const;

    RestLattice lattice_;
    double rounding_;
    double margin_;                                 ///< that, and the tolerance
    std::vector<std::optional<CellBound>> bounds_;  ///< of the base cells
    std::vector<Index> bounded_, unbounded_;        ///< those that have one, and the others
    BoxTree tree_;                                  ///< over these
};

}  // namespace espalier::embed
