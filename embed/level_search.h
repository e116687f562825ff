// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/function_ref.h>
#include <espalier/embed/cell_solver.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/point_descent.h>
#include <espalier/stencils/levels.h>

#include <optional>
#include <span>
#include <vector>

namespace espalier::embed {

/// Some points of a group, and their places in a level.
struct LocatedPart {
    std::vector<Index> points;  ///< their indices in the group
    Embedding embedding;        ///< the embedding of these points

    /// The embedding is in the finest of these levels, which were refined for the points. Nothing
    /// if no cell can contain a point.
    std::optional<stencils::Levels> levels;

    /// For each vertex of level 0 of `levels`, its number in the base.
    std::vector<Index> baseVertices;
};

/// Locates neighbouring points in the part of a level that is refined for them. The places are the
/// same as in the whole level. Any number of threads may use it at once.
class LevelSearch {
public:
    /// \param lattice in units (LengthUnit); must outlive this object
    LevelSearch(const RestLattice& lattice, int level, const EmbeddingOptions& options);

    const PointDescent& descent() const { return descent_; }

    /// \param extent how much of the level is refined around the cells that contain points
    /// \param use called for each part in turn. Together the parts contain all the points. If a
    ///        later part contains a point again, the later one counts, and the earlier part has no
    ///        place for the point
    void locate(std::span<const Point3> points, Extent extent,
                FunctionRef<void(LocatedPart)> use) const;

private:
    LocatedPart locateInside(std::span<const Point3> points, std::optional<Descent>& found,
                             std::vector<Index>& unsettled) const;
    LocatedPart locateOutsideCells(std::span<const Point3> points, Descent& found) const;

    int level_;
    bool seekNearest_;
    CellSolver::Scale scale_;
    Point3 vertex_;  ///< any vertex of the lattice
    PointDescent descent_;
};

}  // namespace espalier::embed
