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

    /// Returns the result for a point that cannot be located: one that is not finite, or one so far
    /// away (1e8 sizes of the lattice) that rounding makes all cells equally near. Returns nothing
    /// for all other points.
    ///
    /// \param point in units of the lattice (LengthUnit)
    static std::optional<LocatedPoint> resultIfUnreachable(const Eigen::Vector3d& point,
                                                           bool seekNearest);

    /// Returns a box that contains the points in a cell, the points within the tolerance of it, and
    /// the points in the gaps beside it.
    Eigen::AlignedBox3d boxOf(CellId cell) const;

    /// Finds the place of a point in the first of some cells that contains it. If a cell is so
    /// twisted that Newton's method from its centre misses the point, the point is found there only
    /// if no other cell contains it.
    /// \param cells ascending, so that the first cell is the one of lowest number
    std::optional<LocatedPoint> locateIn(const Eigen::Vector3d& point,
                                         std::span<const Index> cells) const;

    /// Returns the distance of a point from a cell. The point must not be inside.
    double distance(const Eigen::Vector3d& point, CellId cell) const {
        return (positionOf(nearestPlace(cell, point)) - point).norm();
    }

    /// Locates a point that is in no cell, by continuing the map of the nearest cell along its
    /// tangent. The point may be in a gap between cells, within the tolerance of the lattice, or
    /// outside.
    /// \param nearest the cell of the least distance()
    /// \param seekNearest whether to find a place for a point outside
    LocatedPoint locateOutsideCells(const Eigen::Vector3d& point, CellId nearest,
                                    bool seekNearest) const;

private:
    /// A tetrahedron of a type-n cell: its apex, and the edges from the apex.
    struct Tetrahedron {
        Eigen::Vector3d apex;
        Eigen::Matrix3d edges;
    };

    std::optional<LocatedPoint> findIn(CellId cell, const Eigen::Vector3d& point,
                                       bool thoroughly) const;
    CellPlace nearestPlace(CellId cell, const Eigen::Vector3d& point) const;
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
    Array<std::optional<std::array<Index, 8>>> corners_;  ///< of the cells that are hexahedra
    Scale scale_;
};

}  // namespace espalier::embed
