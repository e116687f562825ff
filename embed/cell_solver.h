// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/cell_place.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace espalier::embed {

enum class PointStatus : std::uint8_t {
    Inside,       ///< in a cell, in the gap between two, or within the tolerance of the region
    Outside,      ///< of the region that the cells fill
    NotConverged  ///< no place gives it back: a degenerate cell, or a coordinate not finite; or it
                  ///< is to go with the nearest cell, and lies 1e8 sizes of the lattice away
};

/// Where a point lies in a lattice, whatever a place in it is.
template <class Place>
struct Located {
    PointStatus status = PointStatus::NotConverged;

    /// The place that stands for the point; nothing if it was not sought (Outside) or not found
    /// (NotConverged).
    std::optional<Place> place;

    /// Distance from the region of the lattice, 0 in it. Not computed for a point outside of which
    /// no place was sought.
    double distance = 0;

    /// Distance of the point from the position of the place; 0 without a place.
    double residual = 0;
};

/// Where a point lies in a refined lattice. The residual is the rounding of the solve, at most
/// 1e-12 of the size of the lattice or of the point's distance from the origin; of a point that is
/// more than some thousand cells away, the rounding of its weights, 1e-15 of their size. Where the
/// nearest cell is too flat to solve for, a point within the tolerance has the place that is
/// nearest to it, and its distance from that.
using LocatedPoint = Located<CellPlace>;

/// Finds points in given cells of a refined lattice. Which cells may hold a point is for others to
/// say: those whose boxOf() contains it.
///
/// Any number of threads may ask; answers depend on nothing but the point and the cells. Positions
/// and points are squared: of a lattice whose size is not near 1, they must come in units of it
/// (LengthUnit), as PointLocator and bindPoints() see to.
///
/// \cite MacCracken & Joy 1996, sections 4 to 6
class ESPALIER_API CellSolver {
public:
    /// What lengths are measured by.
    struct Scale {
        double size = 0;       ///< diagonal of the lattice's bounding box
        double tolerance = 0;  ///< how far outside a point still counts as inside
    };

    /// \param tolerance as a fraction of the diagonal of the bounding box of `positions`
    /// \throws Error if the tolerance is negative or not finite
    static Scale scaleOf(std::span<const Point3> positions, double tolerance);

    /// \param complex a lattice of level 1 or above; kept (a cheap copy)
    /// \param positions one a vertex; copied
    /// \throws Error if `complex` is not a lattice of quadrilaterals, or `positions` do not fit it
    ///         or are not finite
    /// \cost O(cells), in parallel: 0.08 s for 500,000 on one thread
    CellSolver(const far::CellComplex& complex, std::span<const Point3> positions, Scale scale);

    /// What there is to say of a point that cannot be asked for: it is not finite, or so far off
    /// that no cell is nearer than another, 1e8 sizes of the lattice. Nothing for all others.
    ///
    /// \param point in units of the lattice (LengthUnit)
    static std::optional<LocatedPoint> beyondReach(const Eigen::Vector3d& point, bool seekNearest);

    /// Holds the points in a cell and, of those within the tolerance of it or in a gap beside it,
    /// all that are taken for inside.
    Eigen::AlignedBox3d boxOf(CellId cell) const;

    /// The place of a point in the first of some cells that contains it. A cell so twisted that
    /// Newton's method from its centre misses the point has it only if no other cell does.
    /// \param cells ascending, so that it is the lowest
    std::optional<LocatedPoint> locateIn(const Eigen::Vector3d& point,
                                         std::span<const Index> cells) const;

    /// Distance of a point from a cell; not meant for points inside.
    double distance(const Eigen::Vector3d& point, CellId cell) const {
        return (positionOf(nearestPlace(cell, point)) - point).norm();
    }

    /// Where a point lies that is in no cell, by continuing the map of the nearest one along its
    /// tangent: in a gap between cells, within the tolerance of the lattice, or outside.
    /// \param nearest the cell of the least distance()
    /// \param seekNearest whether to find the place that stands for a point outside
    LocatedPoint locateBeside(const Eigen::Vector3d& point, CellId nearest, bool seekNearest) const;

private:
    /// A tetrahedron of a type-n cell: its apex, and the edges from there.
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
    std::vector<std::optional<std::array<Index, 8>>> corners_;  ///< of the hexahedra
    Scale scale_;
};

}  // namespace espalier::embed
