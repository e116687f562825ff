// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/point.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/box_tree.h>
#include <espalier/stencils/cell_solver.h>
#include <espalier/stencils/masks.h>
#include <espalier/stencils/stencil_table.h>

#include <optional>
#include <span>
#include <vector>

#include "cell_bounds.h"

namespace espalier::stencils {

/// Which cells are sought for a point.
enum class Sought {
    Containing,  ///< those in whose box it is
    Nearest      ///< the nearest one; and those in whose box it is
};

/// A part of a level of a lattice, with the cells that were sought.
struct FoundCells {
    far::TopologyRefiner refiner;              ///< to that level
    std::vector<StencilTable<double>> tables;  ///< R_1 to that of the level
    std::vector<Point3> positions;             ///< of the vertices there
    std::vector<Index> cells;     ///< those sought for one of the points at least, ascending
    std::vector<Offset> offsets;  ///< points[offsets[i]] to points[offsets[i + 1] − 1] of cells[i]
    std::vector<Index> points;    ///< as they were given, counted from 0; ascending in a cell
};

/// Refines a lattice no further than points ask for: level by level, only around the cells that can
/// still become one that is sought. Any number of threads may ask.
class PointDescent {
public:
    /// \param base a lattice at level 0; must outlive this, as the positions of its vertices
    PointDescent(const far::TopologyRefiner& base, std::span<const Point3> positions, Rules rules,
                 CellSolver::Scale scale);

    /// \param level 1 or above
    /// \param extent how much of the level is made around the cells that were sought
    /// \return nothing if no cell of a level above is left, and so nothing to refine
    /// \throws TopologyError as far::TopologyRefiner::refineAround()
    /// \cost O(points × (level + log base cells)), once the lattice is fine enough to tell the
    ///       points apart
    std::optional<FoundCells> descend(std::span<const Point3> points, int level, Sought sought,
                                      far::TopologyRefiner::Extent extent) const;

private:
    struct Candidates;
    Candidates baseCandidates(std::span<const Point3> points, Sought sought) const;

    const far::TopologyRefiner& base_;
    std::span<const Point3> positions_;
    Rules rules_;
    double margin_;  ///< how far from the box of a cell a point still counts as in it
    std::vector<std::optional<CellBound>> bounds_;  ///< of the base cells
    std::vector<Index> bounded_, unbounded_;        ///< those that have one, and the others
    BoxTree tree_;                                  ///< over these
};

}  // namespace espalier::stencils
