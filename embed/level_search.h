// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/function_ref.h>
#include <espalier/embed/cell_solver.h>
#include <espalier/embed/embedding.h>
#include <espalier/embed/point_descent.h>
#include <espalier/embed/point_location.h>
#include <espalier/stencils/levels.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace espalier::embed {

/// A whole level of a lattice, with the data needed to make rows for points in it.
struct WholeLevel {
    /// \cost O(cells of the level)
    WholeLevel(const RestLattice& lattice, int level, double tolerance);

    Embedding locate(std::span<const Point3> points, bool seekNearest) const;

    far::CellComplex complex;
    std::unique_ptr<const PointLocator> locator;
    stencils::StencilTable<double> stencilTable;  ///< S of the level
    std::vector<Index> baseCells;                 ///< for each cell, the number of its base cell
    Index baseCellCount = 0;
};

/// The same as for stencils::Levels: see embedding.h.
stencils::StencilTable<double> buildDeformationTable(const WholeLevel& level,
                                                     const Embedding& embedding);
stencils::FactoredTable<double> buildFactoredTable(const WholeLevel& level,
                                                   const Embedding& embedding);

/// Some points of a group, and their places in a level.
struct LocatedPart {
    std::vector<Index> points;  ///< their indices in the group
    Embedding embedding;        ///< of these points

    /// The embedding is in the finest of these levels, which were refined for the points. Nothing
    /// if the search uses the whole level, or if no cell can contain a point.
    std::optional<stencils::Levels> levels;

    /// For each vertex of level 0 of `levels`, its number in the base.
    std::vector<Index> baseVertices;
};

/// Locates neighbouring points in a level: either in the whole level, which all groups share, or in
/// a part of the level that is refined for them. Both give the same places. Any number of threads
/// may use it at once.
class LevelSearch {
public:
    enum class Scope { Parts, Whole };

    /// \param lattice in units (LengthUnit); must outlive this object
    LevelSearch(const RestLattice& lattice, int level, const EmbeddingOptions& options,
                Scope scope);

    /// The level, if the search uses the whole level.
    const std::optional<WholeLevel>& whole() const { return whole_; }

    /// \param extent how much of the level is refined around the cells that contain points
    /// \param use called for each part in turn. Together the parts contain all the points. If a
    ///        later part contains a point again, the later one counts, and the earlier part has no
    ///        place for the point
    void locate(std::span<const Point3> points, Extent extent,
                FunctionRef<void(LocatedPart)> use) const;

private:
    LocatedPart locateInside(std::span<const Point3> points, Extent extent,
                             std::vector<Index>& unsettled) const;
    LocatedPart locateOutsideCells(std::span<const Point3> points) const;

    int level_;
    bool seekNearest_;
    CellSolver::Scale scale_;
    std::optional<WholeLevel> whole_;
    std::optional<PointDescent> descent_;  ///< unless the search uses the whole level
};

}  // namespace espalier::embed
