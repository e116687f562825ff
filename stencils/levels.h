// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <span>
#include <vector>

namespace espalier::stencils {

/// Holds the levels of a curve, a mesh or a lattice, with R_1 to R_k and the positions of the
/// vertices of each level. Levels are added one at a time, around some cells.
class ESPALIER_API Levels {
public:
    /// \param refiner must have level 0 only
    /// \param positions of the vertices of level 0; without positions, no level has them
    explicit Levels(far::TopologyRefiner refiner, std::vector<Point3> positions = {});

    const far::TopologyRefiner& refiner() const { return refiner_; }

    int finest() const { return refiner_.maxLevel(); }
    const far::Level& finestLevel() const { return refiner_.level(finest()); }

    /// The level tables R_1 to R_k of all levels.
    std::span<const StencilTable<double>> tables() const { return tables_; }

    std::span<const Point3> positions(int level) const { return positions_[level]; }
    std::span<const Point3> finestPositions() const { return positions_.back(); }

    /// Adds a level around some cells of the finest one.
    /// \throws as far::TopologyRefiner::refineAround() and buildLevelTable()
    void refineAround(std::span<const Index> cells,
                      far::TopologyRefiner::Extent extent = far::TopologyRefiner::Extent::Ring);

    /// Returns the rows of S for some vertices of the finest level, 1 or above: see
    /// composeStencils().
    StencilTable<double> stencils(std::span<const Index> vertices) const;

private:
    far::TopologyRefiner refiner_;
    std::vector<StencilTable<double>> tables_;
    std::vector<std::vector<Point3>> positions_;  ///< one set per level
};

}  // namespace espalier::stencils
