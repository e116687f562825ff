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

/// A level of a lattice as a whole, with what makes rows for points in it.
struct WholeLevel {
    /// \cost O(cells of the level)
    WholeLevel(const RestLattice& lattice, int level, double tolerance);

    Embedding locate(std::span<const Point3> points, bool seekNearest) const;

    far::CellComplex complex;
    std::unique_ptr<const PointLocator> locator;
    stencils::StencilTable<double> stencilTable;  ///< S of the level
    std::vector<Index> baseCells;                 ///< for each cell the number of its base cell
    Index baseCellCount = 0;
};

/// As for the finest of some levels: see embedding.h.
stencils::StencilTable<double> buildDeformationTable(const WholeLevel& level,
                                                     const Embedding& embedding);
stencils::FactoredTable<double> buildFactoredTable(const WholeLevel& level,
                                                   const Embedding& embedding);

/// Some points of a group, and their places in a level.
struct LocatedPart {
    std::vector<Index> points;  ///< their numbers in the group
    Embedding embedding;        ///< of these points

    /// The embedding is in the finest of these levels, which were refined for the points. Nothing
    /// where the search has the whole level, and where no cell can hold a point.
    std::optional<stencils::Levels> levels;
};

/// Locates points of a level that lie together: in the whole level, which serves all groups, or in
/// a part of it that is refined for them. Both give the same places. Any number of threads may ask.
class LevelSearch {
public:
    enum class Scope { Parts, Whole };

    /// \param lattice in units (LengthUnit); must outlive this
    LevelSearch(const RestLattice& lattice, int level, const EmbeddingOptions& options,
                Scope scope);

    /// The level, if the search has the whole of it.
    const std::optional<WholeLevel>& whole() const { return whole_; }

    /// \param extent how much is made of a part of the level around the cells that hold points
    /// \param use is called for each part in turn. Together they have all of the points; where a
    ///        later part has some of them again, that counts, and the earlier one has no place for
    ///        these
    void locate(std::span<const Point3> points, far::TopologyRefiner::Extent extent,
                FunctionRef<void(LocatedPart)> use) const;

private:
    LocatedPart locateInside(std::span<const Point3> points, far::TopologyRefiner::Extent extent,
                             std::vector<Index>& unsettled) const;
    LocatedPart locateBeside(std::span<const Point3> points) const;

    int level_;
    bool seekNearest_;
    CellSolver::Scale scale_;
    std::optional<WholeLevel> whole_;
    std::optional<PointDescent> descent_;  ///< without the whole level
};

}  // namespace espalier::embed
