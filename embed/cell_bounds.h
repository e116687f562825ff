// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/embed/affine_hull.h>
#include <espalier/embed/cell_frame.h>
#include <espalier/far/topology_refiner.h>

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

namespace espalier::embed {

/// A bound on where refinement can take a cell: it contains all vertices of the cell's descendants
/// on all levels.
struct CellBound {
    Eigen::AlignedBox<double, 3> box;

    /// Largest distance, for each coordinate, of a descendant's vertex from the trilinear map of
    /// the cell's corners. It falls to a quarter with each level. Only for cells with regular
    /// surroundings.
    std::optional<Eigen::Vector3d> drift;
};

/// Computes bounds of the cells of one level of a lattice.
///
/// Around a regular cell, refinement is a uniform tricubic B-spline. Along one axis, a vertex moves
/// by an eighth of the second difference there, an edge point does not move, and second differences
/// fall to a quarter with each level. So all levels together move a vertex along each axis by at
/// most a sixth of the largest second difference. This also holds at regular boundaries: there,
/// refinement is a B-spline with a phantom layer 2P₀ − P₁, whose second difference is 0. The bound
/// is the box of the corners, widened by these amounts; it is little larger than the cell.
///
/// Elsewhere new points are averages, and the bound is the box of all cells around the cell
/// (convex-hull property). If a mask has negative weights there, or may get some on a later level,
/// no bound is known.
///
/// The same bounds hold for MLCA: its rules are equal to Catmull-Clark's in regular places, and its
/// weights are positive everywhere. Where Catmull-Clark has a negative weight MLCA could have a
/// bound, but none is computed: such places are rare, and a missing bound only costs time.
///
/// \cite MacCracken & Joy 1996, section 2.2; CSE-96-1, section 4 (the rules as products of curves')
class CellBounds {
public:
    /// \param level a lattice; must outlive this object, as must `positions`
    CellBounds(const far::Level& level, std::span<const Point3> positions, far::Creasing creasing);

    /// \param cell all its neighbours must be present
    /// \param inherited the drift of the cell's parent, if it has one
    /// \return nothing if no bound is known
    std::optional<CellBound> boundOf(Index cell, const std::optional<Eigen::Vector3d>& inherited);

    /// Returns a bound of the cell itself, without its descendants: the box of its corners.
    /// \param widening margin on each side, as a fraction of the box's diagonal; also the drift of
    ///        the result
    CellBound ownBox(Index cell, double widening = 0) const;

    /// Returns a bound of the cell itself in the directions of its edges: far smaller than a box
    /// for a thin cell that is oblique to the coordinate axes. The hull of a flat cell contains
    /// every point.
    /// \param widening margin on each side, as a fraction of the edges
    AffineHull ownHull(Index cell, double widening) const;

private:
    Eigen::Matrix3d axesOf(Index cell) const;
    using Box = Eigen::AlignedBox<double, 3>;
    const Box& boxOf(Index cell);
    const Box& boxAround(Index vertex);
    bool staysInHull(Index cell);
    bool isConvexAround(Index vertex) const;
    bool isRegular(Index cell);
    Eigen::Vector3d largestSecondDifference(Index cell);
    const Eigen::Vector3d& secondDifferenceAround(Index vertex);
    const Eigen::Vector3d& secondDifferenceAcross(Index face);
    static Index beyond(const CellFrame& frame, std::span<const Index> face, Index corner);
    /// Returns the frame of a cell; nothing if the cell is not a hexahedron.
    const std::optional<CellFrame>& hexahedron(Index cell);

    Eigen::Vector3d positionOf(Index vertex) const {
        return Eigen::Vector3d(positions_[vertex].data());
    }

    const far::Level& level_;
    std::span<const Point3> positions_;
    bool mayExtrapolate_;  ///< Chaikin's rule for semi-sharp edges

    // Each entry is computed when it is first needed. Every cell of a vertex needs the vertex, and
    // every vertex of a cell needs the cell: without these caches, a cell with 40,000 vertices
    // takes 10 s. A face in a grid is in the surroundings of 18 cells.
    std::vector<std::optional<bool>> isRegular_;
    std::vector<std::optional<CellFrame>> hexahedra_;
    std::vector<std::optional<Eigen::Vector3d>> secondDifferenceAcross_;  ///< one per face
    std::vector<std::optional<Eigen::Vector3d>> secondDifferenceAround_;  ///< one per vertex
    std::vector<std::optional<Box>> ofCell_;                              ///< corners of each cell
    std::vector<std::optional<Box>> aroundVertex_;  ///< corners of all cells of each vertex
    std::vector<std::optional<bool>> staysInHull_;
};

}  // namespace espalier::embed
