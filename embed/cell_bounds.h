// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/embed/affine_hull.h>
#include <espalier/far/topology_refiner.h>

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

namespace espalier::embed {

/// Where what is refined from a cell can lie: all vertices of the cells that it becomes, whatever
/// the level.
struct CellBound {
    Eigen::AlignedBox<double, 3> box;

    /// Of a cell around which all is regular: by how much, at most, a refined vertex may be off the
    /// trilinear map of the cell's corners, coordinate by coordinate. It falls to a quarter with
    /// each level. Nothing for other cells.
    std::optional<Eigen::Vector3d> drift;
};

/// Bounds of the cells of one level of a lattice.
///
/// Around a cell where nothing is irregular, refinement is that of a uniform tricubic B-spline:
/// along one axis a vertex moves by an eighth of the second difference there, an edge point not at
/// all, and the second differences fall to a quarter with each level. So all levels together move a
/// vertex by no more than a sixth of the largest second difference along each axis. At regular
/// boundaries that is true too: they are a B-spline with a phantom layer 2P₀ − P₁, whose second
/// difference is 0. The box of the corners, widened by that, is little more than the cell itself.
///
/// Anywhere else new points are averages, and the box of all cells around the cell holds them
/// (the convex-hull property). Except where a mask has negative weights, or may get one: there, no
/// bound is known.
///
/// All that is true of MLCA: where all is regular its rules are the same, and its weights are
/// positive. Where Catmull-Clark's are not it could do with a bound, and has none: such places are
/// rare, and only time is lost.
///
/// \cite MacCracken & Joy 1996, section 2.2; CSE-96-1, section 4 (the rules as products of curves')
class CellBounds {
public:
    /// \param level a lattice; must outlive this, as the positions of its vertices
    CellBounds(const far::Level& level, std::span<const Point3> positions, far::Creasing creasing);

    /// \param cell with all its neighbours present
    /// \param inherited the drift of the cell that this one is a child of, if it has one
    /// \return nothing if the cell may become anything
    std::optional<CellBound> boundOf(Index cell, const std::optional<Eigen::Vector3d>& inherited);

    /// Where the cell itself lies, without what it may become: the box of its corners, widened on
    /// each side by a part of its diagonal, which is the drift.
    CellBound ownBox(Index cell, double widening = 0) const;

    /// The same in directions of the cell's own, widened by a part of its edges: far less of a thin
    /// cell that lies aslant. Of a flat cell it holds everything.
    AffineHull ownHull(Index cell, double widening) const;

private:
    Eigen::Matrix3d axesOf(Index cell) const;
    using Box = Eigen::AlignedBox<double, 3>;
    const Box& boxOf(Index cell);
    const Box& boxAround(Index vertex);
    bool staysInHull(Index cell);
    bool isConvexAround(Index vertex) const;
    Eigen::Vector3d largestSecondDifference(const std::vector<Index>& ring) const;
    std::vector<Index> ringOf(Index cell) const;

    Eigen::Vector3d positionOf(Index vertex) const {
        return Eigen::Vector3d(positions_[vertex].data());
    }

    const far::Level& level_;
    std::span<const Point3> positions_;
    bool mayExtrapolate_;  ///< Chaikin's rule for semi-sharp edges

    // Each is found when it is first asked for. Every cell of a vertex asks for the vertex, and
    // every vertex of a cell for the cell: without these, a cell of 40,000 vertices takes 10 s.
    std::vector<std::optional<Box>> ofCell_;        ///< corners of each cell
    std::vector<std::optional<Box>> aroundVertex_;  ///< corners of all cells of each vertex
    std::vector<std::optional<bool>> staysInHull_;
};

}  // namespace espalier::embed
