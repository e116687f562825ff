// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>

#include <optional>
#include <span>
#include <vector>

#include "cage_energy.h"
#include "cage_surface.h"
#include "point_groups.h"

namespace espalier::cages {

/// The forces between the boundary of a lattice and the points of a model.
///
/// - A *pull* on each face of level 2 goes to the nearest points.
/// - A *push* on a face of level 3 goes outwards, if points stick out of it or are nearer to it
///   than their clearance. Another push goes inwards, away from the points of another part of the
///   model.
///
/// match() finds the faces and the points that belong to each other. strengthen() and weakenPulls()
/// change the forces where a lattice is not proved.
class BoundaryForces {
public:
    /// \param surface, groups are kept by reference
    /// \param edge mean edge of the cells of the start
    /// \param margin least distance of the boundary from the points
    BoundaryForces(const CageSurface& surface, const PointGroups& groups, const Lattice& start,
                   double edge, double margin);

    /// Makes all forces as they are at first.
    /// \param pull factor of all pulls
    void reset(double pull);

    /// Matches faces and points.
    /// \param positions of the vertices of the lattice
    void match(std::span<const Point3> positions);

    /// Adds the energy of the forces, and its gradient.
    void addEnergy(std::span<const Point3> positions, double& energy,
                   std::span<Point3> gradient) const;

    /// Makes room around points without proof, and pushes them more.
    void strengthen(std::span<const Uncovered> uncovered);

    /// Multiplies the pulls on the faces of some cells.
    /// \param isChosen per cell
    void weakenPulls(std::span<const char> isChosen, double factor);

private:
    bool belongs(Index group, Index cell) const;
    bool suits(Index group, Index cell, const Point3& normal) const;
    template <class Accept>
    std::optional<Index> nearestFace(const Point3& point, Index rings,
                                     const std::vector<Point3>& centres, Accept accept) const;
    void measureDepths(std::span<const Point3> fine, const std::vector<Point3>& centres,
                       const std::vector<Point3>& normals);
    void matchPulls(const std::vector<Point3>& centres, const std::vector<Point3>& normals);
    void matchPushes(const std::vector<Point3>& centres, const std::vector<Point3>& normals);

    const CageSurface& surface_;
    const PointGroups& groups_;
    double edge_, margin_;
    std::vector<std::vector<Index>> apart_;        ///< of each cell, ascending
    std::vector<Index> firstOfCube_, nextOfFace_;  ///< lists of the faces of level 3 in each cube
    /// How far the hulls of each face of level 3 reach inwards of its centre.
    std::vector<double> depths_;

    // The next six arrays have one entry for each group of points.
    std::vector<double> clearance_;         ///< least distance of the hulls of the boundary
    std::vector<double> distanceToOthers_;  ///< least distance of faces it does not belong to
    std::vector<double> distance_;          ///< from its plane, when it was last matched
    std::vector<double> pushFactor_;
    std::vector<int> failures_;   ///< rounds in which it had no proof
    std::vector<char> isRaised_;  ///< whether it had no proof, or is near such a group

    std::vector<double> pullFactor_;  ///< of each face of level 2
    std::vector<PlaneTerm> pulls_, pushes_;
};

}  // namespace espalier::cages
