// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/embed/cell_place.h>
#include <espalier/embed/located_point.h>

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

namespace espalier::embed {

/// Finds points in given cells of a refined lattice. The caller selects the cells: those whose
/// boxOf() contains the point.
///
/// Any number of threads may use it at once; results depend on the point and the cells only.
/// Coordinates are squared, so positions and points of a lattice whose size is far from 1 must be
/// given in units of its size (LengthUnit), as PointLocator and bindPoints() do.
///
/// \cite MacCracken & Joy 1996, sections 4 to 6
class ESPALIER_API CellSolver {
public:
    /// The lengths that a lattice is measured by.
    struct Scale {
        double size = 0;       ///< diagonal of the lattice's bounding box
        double tolerance = 0;  ///< distance within which a point outside still counts as inside
    };

    /// \param tolerance as a fraction of the diagonal of the bounding box of `positions`
    /// \throws Error if the tolerance is negative or not finite
    static Scale scaleOf(std::span<const Point3> positions, double tolerance);

    /// \param complex a lattice of level 1 or above; kept (a cheap copy)
    /// \param positions one per vertex; copied
    /// \throws Error if `complex` is not a lattice of quadrilaterals, or `positions` do not fit it
    ///         or are not finite
    /// \cost O(cells), in parallel: 0.08 s for 500,000 on one thread
    CellSolver(const far::CellComplex& complex, std::span<const Point3> positions, Scale scale);

    /// Returns the result for a point that needs no search: it is not finite, or so far away that
    /// its weights would exceed kMaxRowSum by far. Returns nothing for all other points.
    ///
    /// \param vertex any vertex of the lattice
    /// \param size of the lattice
    static std::optional<LocatedPoint> resultIfUnreachable(const Eigen::Vector3d& point,
                                                           const Point3& vertex, double size);

    /// Returns a box that contains the points in a cell, the points within the tolerance of it, and
    /// the points in the gaps beside it.
    Eigen::AlignedBox3d boxOf(CellId cell) const;

    /// Finds the place of a point in the first of some cells that contains it. If a cell is so
    /// twisted that Newton's method from its centre misses the point, the point is found there only
    /// if no other cell contains it.
    /// \param cells ascending, so that the first cell is the one of lowest number
    std::optional<LocatedPoint> locateIn(const Eigen::Vector3d& point,
                                         std::span<const Index> cells) const;

    /// The place of a cell that is nearest to a point outside the cell.
    struct NearestPlace {
        CellPlace place;
        double distance = 0;
    };
    NearestPlace nearestIn(CellId cell, const Eigen::Vector3d& point) const;

    /// Returns the distance of a point from a cell. The point must not be inside.
    double distance(const Eigen::Vector3d& point, CellId cell) const {
        return nearestIn(cell, point).distance;
    }

    /// Locates a point that is in no cell, but in the box of one. The point is Inside if it is
    /// within the tolerance of the lattice, or in a gap between cells, and Outside otherwise.
    /// \param nearest the cell of the least distance()
    LocatedPoint locateInGap(const Eigen::Vector3d& point, CellId nearest) const;

    /// Continues the map of the nearest cell along its tangent to a point beside the cell. The
    /// point is Inside if the way is at most a cell long (kMaxGap). Otherwise a point within the
    /// tolerance gets the nearest place itself, and any other point is Outside.
    LocatedPoint settle(const Eigen::Vector3d& point, const NearestPlace& nearest,
                        double tolerance) const;

    /// Gives a point outside the lattice a place, by continuing the map of the nearest cell along
    /// its tangent, however long the way is. The point has no place if the cell is flat.
    LocatedPoint carry(const Eigen::Vector3d& point, CellId nearest) const;

    /// Longest way along the tangent to a point that counts as inside, in each coordinate of the
    /// cell: a gap is never larger than the cells beside it. Weights over the vertices of the level
    /// then sum to at most 7 in absolute value: 1 for the place, and 2 for each axis.
    static constexpr double kMaxGap = 1;

private:
    /// A tetrahedron of a type-n cell: its apex, and the edges from the apex.
    struct Tetrahedron {
        Eigen::Vector3d apex;
        Eigen::Matrix3d edges;
    };

    std::optional<LocatedPoint> findIn(CellId cell, const Eigen::Vector3d& point,
                                       bool thoroughly) const;
    CellPlace nearestPlace(CellId cell, const Eigen::Vector3d& point) const;
    std::optional<LocatedPoint> continued(const Eigen::Vector3d& point,
                                          const NearestPlace& nearest) const;
    Eigen::Matrix3d jacobianAt(const CellPlace& place) const;
    std::vector<Index> supportOf(const CellPlace& place) const;
    bool isOnBoundary(const CellPlace& place) const;

    const std::optional<std::array<Index, 8>>& cornersOf(CellId cell) const {
        return corners_[cell.value];
    }
    Eigen::Vector3d positionOf(Index vertex) const {
        return Eigen::Vector3d(positions_[vertex].data());
    }
    Eigen::Vector3d positionOf(const CellPlace& place) const;
    Eigen::Vector3d centreOf(CellId cell) const;
    Tetrahedron tetrahedron(CellId cell, Index number, const Eigen::Vector3d& centre) const;

    far::CellComplex complex_;
    std::vector<Point3> positions_;
    Array<std::optional<std::array<Index, 8>>> corners_;  ///< corners of each hexahedron
    Scale scale_;
};

}  // namespace espalier::embed
