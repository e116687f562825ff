// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/box_tree.h>
#include <espalier/stencils/cell_place.h>

#include <cstdint>
#include <optional>
#include <span>

namespace espalier::stencils {

enum class PointStatus : std::uint8_t {
    Inside,       ///< in a cell, in the gap between two, or within the tolerance of the region
    Outside,      ///< of the region that the cells fill
    NotConverged  ///< no place gives it back: a degenerate cell, or a coordinate not finite
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
/// 1e-12 of the size of the lattice or of the point's distance from the origin. Where the nearest
/// cell is too flat to solve for, a point within the tolerance has the place that is nearest to it,
/// and its distance from that.
using LocatedPoint = Located<CellPlace>;

/// Finds the cells of a refined lattice that hold given points.
///
/// A point belongs to the cell of lowest number that contains it. (In a cell so twisted that
/// Newton's method from its centre misses the point, only if no other cell has it.) Faces that are
/// not flat leave small gaps (a hexahedron has a bilinear face, its type-n neighbour a folded one);
/// a point in a gap belongs to the nearest cell, by continuing that cell's map along its tangent.
/// Any number of threads may ask; answers depend on nothing but the point.
///
/// \cite MacCracken & Joy 1996, sections 4 to 6
class PointLocator {
public:
    /// \param complex a lattice of level 1 or above; kept (a cheap copy)
    /// \param positions one a vertex; copied
    /// \param tolerance how far outside a point still counts as inside, as a fraction of the
    ///        diagonal of the lattice's bounding box, 0 or more
    /// \throws Error if `complex` is not a lattice of quadrilaterals, `positions` do not fit it or
    /// are
    ///         not finite, or `tolerance` is out of range
    /// \cost O(cells log cells)
    PointLocator(const far::CellComplex& complex, std::span<const Point3> positions,
                 double tolerance);

    /// \param seekNearest whether to find the place that stands for a point outside
    LocatedPoint locate(const Point3& point, bool seekNearest) const;

private:
    std::optional<CellPlace> findInside(far::CellId cell, const Eigen::Vector3d& point,
                                        bool thoroughly) const;
    CellPlace nearestPlace(far::CellId cell, const Eigen::Vector3d& point) const;
    bool continueTo(const Eigen::Vector3d& point, CellPlace& place) const;
    bool settle(const Eigen::Vector3d& point, const CellPlace& place, LocatedPoint& result) const;
    std::vector<far::Index> supportOf(const CellPlace& place) const;
    bool isOnBoundary(const CellPlace& place) const;

    const std::optional<std::array<far::Index, 8>>& cornersOf(far::CellId cell) const {
        return corners_[static_cast<std::size_t>(cell.value)];
    }
    Eigen::Vector3d positionOf(far::Index vertex) const {
        return Eigen::Vector3d(positions_[static_cast<std::size_t>(vertex)].data());
    }
    Eigen::Vector3d positionOf(const CellPlace& place) const;
    Eigen::Vector3d centreOf(far::CellId cell) const;

    far::CellComplex complex_;
    std::vector<Point3> positions_;
    std::vector<std::optional<std::array<far::Index, 8>>> corners_;  ///< of the hexahedra
    double size_;       ///< diagonal of the bounding box
    double tolerance_;  ///< as a length
    BoxTree tree_;
};

}  // namespace espalier::stencils
