// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/cell_solver.h>
#include <espalier/embed/point_descent.h>
#include <espalier/limit/limit_binding.h>

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "layered_edge.h"
#include "limit_place.h"

namespace espalier::limit {

/// The place of a point in the limit volume of a lattice. The residual is the rounding of the
/// solve, as for a level.
using LocatedInLimit = embed::Located<LimitPlace>;

/// The places of points, and the levels that contain the places.
struct FoundPoints {
    embed::Descent descent;
    std::vector<LocatedInLimit> points;
};

/// Finds points in the limit volume, level by level. In a regular cell it solves for the place in
/// the tricubic polynomial. On irregular edges it halves the edge. At other irregular features it
/// searches small cells in the way a level is searched, with the vertices at their limits. Any
/// number of threads may use one search at once.
/// All lengths are in units of the lattice (LengthUnit).
class LimitSearch {
public:
    /// \param lattice its base and positions must outlive this
    LimitSearch(const embed::RestLattice& lattice, const LimitOptions& options);

    const embed::PointDescent& descent() const { return descent_; }

    /// Finds the points that are inside a cell. A point in several cells, as on a face between two,
    /// belongs to the cell of the lowest level, and among these to the cell of the lowest number.
    /// A point within the tolerance of a layered edge belongs to the edge.
    /// May miss points in strongly bent cells, which reach far beyond their corners.
    /// \param unsettled gets the points that were not found and may be found by findBeside()
    /// \param deep gets the points that need many more levels, as beside irregular edges, if there
    ///        are more than kMaxDeepPoints. They are to be sought again, in groups of this size:
    ///        their levels have no cells in common, and take 15 MB for each point
    FoundPoints findInside(std::span<const Point3> points, std::vector<Index>& unsettled,
                           std::vector<Index>& deep) const;

    static constexpr std::size_t kMaxDeepPoints = 4;

    /// Finds the points that are in strongly bent cells, in gaps between cells, or within rounding
    /// of the boundary, by their nearest places. All other points are Outside.
    /// \param outside gets the points that are Outside
    FoundPoints findBeside(std::span<const Point3> points, std::vector<Index>& outside) const;

    /// Gives points outside their nearest place, continued along the tangent up to the point. The
    /// cell of the place may be flat; then the point has no place.
    ///
    /// Searches at most kMaxNearest cells of a level for each point. Where more cells are equally
    /// near, as in a lattice that is folded flat, the result is a near place instead of the nearest
    /// one.
    FoundPoints carry(std::span<const Point3> points) const;

private:
    class Cells;
    void limitCandidates(embed::Descent& descent, std::span<const Point3> points,
                         std::size_t maxCells) const;
    /// Distance from a cell at which a point still counts as inside.
    double gap() const { return std::max(scale_.tolerance, tolerance_ * scale_.size); }
    template <class Settle>
    FoundPoints search(std::span<const Point3> points, embed::SoughtCells sought, int maxLevel,
                       Settle settle) const;
    FoundPoints findNearest(std::span<const Point3> points, double reach) const;

    /// A place with the offset that leads to a point along the tangent.
    struct ContinuedPlace {
        LimitPlace place;
        double residual;  ///< distance of the position from the point
        bool isSettled;   ///< false if no such offset leads to the point; the offset is then 0
        Point3 away;      ///< from the position without offset to the point
    };
    ContinuedPlace continued(LimitPlace place, const stencils::Levels& levels,
                             const Eigen::Vector3d& point, double maxOffset) const;

    double tolerance_;  ///< LimitOptions::tolerance
    embed::CellSolver::Scale scale_;
    Point3 vertex_;  ///< any vertex of the lattice
    embed::PointDescent descent_;
    EdgeRefinements refinements_;
};

}  // namespace espalier::limit
