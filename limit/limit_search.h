// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/cell_solver.h>
#include <espalier/embed/point_descent.h>
#include <espalier/limit/limit_binding.h>

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "limit_place.h"

namespace espalier::limit {

/// Where points lie in the limit volume of a lattice. The residual is the rounding of the solve, as
/// in a level.
using LocatedInLimit = embed::Located<LimitPlace>;

/// The places of some points, and the levels that they are in.
struct FoundPoints {
    embed::Descent descent;
    std::vector<LocatedInLimit> points;
};

/// Finds points in the limit volume, level by level: in regular cells by solving for their
/// polynomial, in what is left at irregular features as in a level whose vertices have gone to
/// their limits. Any number of threads may ask. All in units of the lattice (LengthUnit).
class LimitSearch {
public:
    /// \param lattice its base and positions must outlive this
    LimitSearch(const embed::RestLattice& lattice, const LimitOptions& options);

    /// The points that are in a cell. A point in several, as on a face between two, belongs to the
    /// one of the lowest level, and of these to that of the lowest number. Finds all but those in
    /// strongly bent cells, which reach far beyond their corners.
    /// \param unsettled gets the points that findNearest() may find
    FoundPoints findInside(std::span<const Point3> points, std::vector<Index>& unsettled) const;

    /// Points by the nearest place: in strongly bent cells, in gaps between cells, and beside the
    /// lattice, if points there are to be carried.
    ///
    /// A point is sought in kMaxNearest cells of a level at most. Where more are as near, as in a
    /// lattice that is folded flat, its place is a near one, or it is NotConverged.
    FoundPoints findNearest(std::span<const Point3> points) const;

private:
    class Cells;
    void keepFew(embed::Descent& descent, std::span<const Point3> points, std::size_t most) const;
    bool isFineEnough(int level) const { return level >= finestLevel_; }
    /// How far from a cell a point still counts as inside.
    double gap() const { return std::max(scale_.tolerance, tolerance_ * scale_.size); }
    template <class Settle>
    FoundPoints search(std::span<const Point3> points, embed::Sought sought, Settle settle) const;
    LocatedInLimit continued(const LocatedInLimit& nearest, const stencils::Levels& levels,
                             const Eigen::Vector3d& point) const;

    double tolerance_;  ///< LimitOptions::tolerance
    bool seekNearest_;
    embed::CellSolver::Scale scale_;
    int finestLevel_;  ///< from here on, cells may be small enough to blend
    embed::PointDescent descent_;
};

}  // namespace espalier::limit
