// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/bounding_box.h>
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
/// change the forces where a lattice is not proved. renew() computes the pulls
/// and the pushes.
class BoundaryForces {
public:
    /// \param surface, groups are kept by reference
    /// \param edge mean edge of the cells of the start
    /// \param margin least distance of the boundary from the points
    BoundaryForces(const CageSurface& surface, const PointGroups& groups, const Lattice& start,
                   double edge, double margin);

    /// Resets all forces to their first values.
    /// \param pull factor of all pulls
    void reset(double pull);

    /// Matches faces and points.
    /// \param positions of the vertices of the lattice
    void match(std::span<const Point3> positions);

    /// Computes the forces between the faces and the points that were last matched.
    void renew();

    /// Adds the energy of the forces, and its gradient.
    void addEnergy(std::span<const Point3> positions, double& energy,
                   std::span<Point3> gradient) const;

    /// Return the steps of match(), without its searches for pulls, and of addEnergy(), as Work
    /// counts them.
    double workOfMatch() const;
    double workOfEnergy() const;

    /// Returns the steps of the searches for pulls of the last match(). They are known afterwards
    /// only: a face may be far from the points that it may be fitted to.
    double workOfPulls() const;

    /// Makes room around points without proof, pushes them more, and pulls less there.
    /// \param uncovered groups at the positions that were last matched
    void strengthen(std::span<const Uncovered> uncovered);

    /// Returns the number of groups that stick out of the faces that they push by more than a
    /// distance.
    Index countOutside(double distance) const;

    /// Returns the cell whose face a group pushes outwards; none if it pushes no face.
    std::optional<Index> pushedCell(Index group) const;

    /// Multiplies the pulls on the faces of some cells.
    /// \param isChosen per cell
    void weakenPulls(std::span<const char> isChosen, double factor);

private:
    bool belongs(std::optional<Index> cellOfPoints, Index cell) const;
    bool faces(Index group, const Point3& normal) const;
    /// A face of the boundary.
    struct Face {
        Point3 centre = {0, 0, 0};
        Point3 normal = {0, 0, 0};  ///< a unit vector, or zero for a face without area
        double depth = 0;           ///< how far the hulls of the face reach inwards of its centre
    };

    void measureFaces(std::span<const Point3> positions);
    void matchPulls();
    void matchPushes();
    double pushedDistance(std::size_t group) const;
    PlaneTerm pullOn(Index coarseFace) const;
    void renewPushes();

    const CageSurface& surface_;
    const PointGroups& groups_;
    double edge_, margin_;
    std::vector<std::vector<Index>> apart_;  ///< the cells that are apart from each cell, ascending
    std::vector<BoundingBox> groupsOf_;      ///< the box around the groups of each cell
    std::vector<Face> fineFaces_, coarseFaces_;  ///< the faces of level 3 and of level 2
    std::vector<std::optional<Index>> pulling_;  ///< group nearest to each face of level 2
    Offset visits_ = 0;                          ///< number of visits of the searches for pulling_

    // The next seven arrays have one entry for each group of points.
    std::vector<double> clearance_;            ///< least distance of the hulls of the boundary
    std::vector<double> distanceToOthers_;     ///< least distance from faces of other parts
    std::vector<std::optional<Index>> own_;    ///< the face of level 3 that it pushes outwards
    std::vector<std::optional<Index>> other_;  ///< the face of another part that it pushes away
    std::vector<double> pushFactor_;
    std::vector<int> failures_;   ///< rounds in which it had no proof
    std::vector<char> isRaised_;  ///< whether it had no proof, or is near such a group

    std::vector<double> pullFactor_;  ///< the factor of the pull on each face of level 2
    std::vector<PlaneTerm> pulls_, pushes_;
};

}  // namespace espalier::cages
