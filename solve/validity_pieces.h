// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/base/vector3.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/volume_mesh.h>
#include <espalier/limit/limit_parts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "bernstein.h"

namespace espalier::solve {

/// Two units of rounding.
inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// Returns the length of a derivative, below 1e91. Unlike length() it need not avoid overflow,
/// which takes four times as long.
inline double sizeOf(const Point3& derivative) {
    return std::sqrt(dot(derivative, derivative));
}

inline double largestCoordinate(const Point3& point) {
    return std::max({std::abs(point[0]), std::abs(point[1]), std::abs(point[2])});
}

/// The sizes of derivatives, and their uncertainty.
struct PieceSize {
    /// The longest derivative along each axis. In a tetrahedron the size of the cell instead, since
    /// the apex is a mean over the cell. The rounding of derivatives is proportional to this.
    std::array<double, 3> lengths = {};

    /// Upper bound of the rounding error of each coordinate at the ends of the differences that
    /// derivatives are. Positions are sums of products of up to 27 numbers, level by level: 16
    /// units of the largest coordinate cover this. Another 32 cover the conversion to Bézier
    /// points, which is 3 times a sum of |weights| of 2.4 and of 6 terms along each axis. For
    /// cubics the total is multiplied by 3, since their derivatives are 3 times differences.
    double uncertainty = 0;

    /// Upper bounds of the lengths: both ends may be off along all three axes.
    std::array<double, 3> longest() const {
        const double longer = 2 * std::numbers::sqrt3 * uncertainty;
        return {lengths[0] + longer, lengths[1] + longer, lengths[2] + longer};
    }
};

/// A map from the unit cube. Degree 0: a tetrahedron. Degree 1: a hexahedron. Degree 3: a patch of
/// the limit.
template <std::size_t Degree>
struct Piece {
    Derivatives<Degree> derivatives;
    PieceSize size = {};
};

Piece<3> pieceOf(const limit::BezierPatch& patch);

/// Splits a cell of a refined lattice into pieces, in the same way as embedding: a type-3 cell is
/// one trilinear map, a type-n cell 4n tetrahedra around its cell point. In a lattice with the
/// usual orientation that is not folded, all determinants are positive.
///
/// \cite MacCracken & Joy 1996, section 6
class CellPieces {
public:
    /// \param complex a lattice of quadrilaterals; must outlive this
    CellPieces(const far::CellComplex& complex, Index cell);

    /// Calls visit(piece…) for each piece, with the piece once for each of `positions`.
    /// \param positions one for each vertex of the complex
    /// \cost O(vertices of the cell) for each piece
    template <class Visit, class... Positions>
    void forEach(Visit visit, const Positions&... positions) const {
        if (corners_) {
            visit(hexahedron(positions)...);
            return;
        }
        for (Index i = 0; i < tetrahedronCount(); ++i) visit(tetrahedron(i, positions)...);
    }

    /// Returns the only piece of a type-3 cell.
    Piece<1> hexahedron(std::span<const Point3> positions) const;

private:
    Index tetrahedronCount() const;
    Piece<0> tetrahedron(Index number, std::span<const Point3> positions) const;
    double uncertainty(std::span<const Point3> positions) const;

    const far::CellComplex& complex_;
    CellId cell_;
    std::optional<std::array<Index, 8>> corners_;  ///< nothing unless the cell is a hexahedron
};

/// Splits the cells of a volume mesh into pieces whose determinants are positive exactly where the
/// map of the cell does not fold. In a right-handed mesh that is not folded, all are positive.
///
/// - A tetrahedron is one piece, and a hexahedron is one trilinear map.
/// - A pyramid is the trilinear map whose top shrinks to the apex, at height w = 1. Its determinant
///   is (1 − w)² times a bilinear function of the base, which is smallest at a corner of the base:
///   four tetrahedra.
/// - A wedge is linear over the triangle and linear along the other axis. Its determinant is linear
///   over the triangle, and so smallest on one of the three edges along the axis: three pieces,
///   whose determinants are quadratic along the axis. (They are no maps of their own: only the
///   derivatives are given.)
/// - A polyhedron is split into tetrahedra as OpenFOAM does (FACE_CENTRE_TRIS): they join
///   the centre of the cell, the centre of a face, and an edge of the face. The centres are
///   OpenFOAM's at rest, written as weighted means of the points of the cell. The weights stay in
///   all poses.
class MeshPieces {
public:
    /// \param rest positions of the points at rest, which determine the weights of the centres
    MeshPieces(const far::VolumeMesh& mesh, std::span<const Point3> rest);

    const far::VolumeMesh& mesh() const { return mesh_; }

    /// Returns positions of the points, and after them of the centres.
    std::vector<Point3> withCentres(std::span<const Point3> positions) const;

    /// Calls visit(piece…) for each piece of a cell, with the piece once for each of `positions`,
    /// which withCentres() returned.
    template <class Visit, class... Positions>
    void forEach(Index cell, Visit visit, const Positions&... positions) const {
        const auto kind = mesh_.kind(cell);
        if (kind == far::StandardCell::Hexahedron) {
            visit(hexahedron(cell, positions)...);
        } else if (kind == far::StandardCell::Wedge) {
            for (std::size_t edge = 0; edge < 3; ++edge) visit(wedge(cell, edge, positions)...);
        } else if (kind == far::StandardCell::Pyramid) {
            for (std::size_t corner = 0; corner < 4; ++corner)
                visit(pyramid(cell, corner, positions)...);
        } else if (kind == far::StandardCell::Tetrahedron) {
            visit(tetrahedron(cell, positions)...);
        } else {
            for (const Index face : mesh_.faces(cell)) {
                std::tuple fans(Fan(*this, cell, face, positions)...);
                for (std::size_t edge = 0; edge < mesh_.face(face).size(); ++edge)
                    std::apply([&](auto&... fan) { visit(fan.next()...); }, fans);
            }
        }
    }

private:
    using Positions = std::span<const Point3>;
    Piece<0> tetrahedron(Index cell, Positions positions) const;
    Piece<0> pyramid(Index cell, std::size_t corner, Positions positions) const;
    Piece<1> wedge(Index cell, std::size_t edge, Positions positions) const;
    Piece<1> hexahedron(Index cell, Positions positions) const;

    /// The tetrahedra of a face of a polyhedron, which join the centres of the cell and the face to
    /// the edges of the face. Neighbouring tetrahedra share edges, so each edge is measured once.
    /// Inline, because a million cells have tens of millions of tetrahedra.
    class Fan {
    public:
        Fan(const MeshPieces& pieces, Index cell, Index face, Positions positions)
            : positions_(positions),
              loop_(pieces.mesh_.face(face)),
              isOwner_(pieces.mesh_.owner(face) == cell),
              // The centres are sums over the points of a face and the faces of a cell.
              rounding_((static_cast<double>(loop_.size() + pieces.mesh_.faces(cell).size()) + 8) *
                        kEpsilon),
              apex_(positions[pieces.centreOfCell_[cell]]),
              toFace_(spokeTo(pieces.centreOfFace_[face])),
              toFirst_(spokeTo(loop_[0])),
              toPoint_(toFirst_),
              largest_(std::max(largestCoordinate(apex_), toFace_.largest)) {}

        /// Returns the tetrahedron of the next edge of the face; there must be one.
        Piece<0> next() {
            const Spoke before = toPoint_;
            toPoint_ = nextPoint_ == loop_.size() ? toFirst_ : spokeTo(loop_[nextPoint_]);
            ++nextPoint_;
            const Spoke& from = isOwner_ ? before : toPoint_;
            const Spoke& to = isOwner_ ? toPoint_ : before;
            Piece<0> piece;
            piece.derivatives[0][0] = toFace_.edge;
            piece.derivatives[1][0] = from.edge;
            piece.derivatives[2][0] = to.edge;
            piece.size.lengths = {toFace_.length, from.length, to.length};
            piece.size.uncertainty = 2 * kEpsilon * std::max({largest_, from.largest, to.largest}) +
                                     rounding_ * std::ranges::max(piece.size.lengths);
            return piece;
        }

    private:
        /// An edge of a tetrahedron that starts in the cell's centre.
        struct Spoke {
            Point3 edge;
            double length;
            double largest;  ///< coordinate of the edge's end
        };
        Spoke spokeTo(Index point) const {
            const Point3& end = positions_[point];
            const Point3 edge = difference(end, apex_);
            return {edge, sizeOf(edge), largestCoordinate(end)};
        }

        Positions positions_;
        std::span<const Index> loop_;
        bool isOwner_;
        double rounding_;  ///< the rounding of the centres, relative to the longest edge
        Point3 apex_;
        Spoke toFace_, toFirst_, toPoint_;
        double largest_;  ///< coordinate of the two centres
        std::size_t nextPoint_ = 1;
    };

    /// A centre is the sum of weights times positions.
    struct Weight {
        Index position;
        double weight;
    };

    far::VolumeMesh mesh_;
    far::Rows<Weight> centres_;        ///< the centres of faces of polyhedra, then of polyhedra
    std::vector<Index> centreOfFace_;  ///< number in withCentres(), for faces of polyhedra
    std::vector<Index> centreOfCell_;  ///< the same for polyhedra; both are empty without them
};

/// 512 units of rounding; a unit is half of epsilon.
inline constexpr double kRounding = 256 * kEpsilon;

/// Returns the rounding error of a coefficient.
/// \param exact, longer volumes of the box of the lengths, and of their upper bounds
inline double floorOf(double exact, double longer, double rounding) {
    // Below the smallest normal number, products lose digits.
    return longer - exact + rounding * longer + std::numeric_limits<double>::min();
}

/// Returns the value that a determinant must exceed to count as positive: its change when edges
/// become longer by their uncertainty, plus 6e-14 of the product of the lengths, which is 512 units
/// of rounding. This covers all rounding of the coefficients: 3 units for the edges, 12 for the
/// determinants of edges, 24 for their sums, 60 for halvings; and 2n + 2 for each edge of the
/// tetrahedra of a type-n cell, for n up to about 50. For a patch: 12 for determinants, 84 for sums
/// of up to 36 and 48 of them, and 240 for halvings, 8 for each.
///
/// \param roundings how many times this rounding is allowed for
inline double determinantFloor(const PieceSize& size, double roundings = 1) {
    const auto volume = [](const std::array<double, 3>& lengths) {
        return lengths[0] * lengths[1] * lengths[2];
    };
    return floorOf(volume(size.lengths), volume(size.longest()), roundings * kRounding);
}

/// Returns the same bound while a piece changes linearly from `first` to `last`: Bernstein
/// coefficients of degree 3 in time, as for determinant(). It allows for twice the rounding, since
/// sums have twice as many terms and time is halved up to 60 times, by 3 units each.
std::array<double, 4> determinantFloor(const PieceSize& first, const PieceSize& last);

/// Returns an upper bound of these four coefficients, which takes a tenth of their time.
inline double largestFloor(const PieceSize& first, const PieceSize& last) {
    PieceSize larger = first;
    for (std::size_t axis = 0; axis < 3; ++axis)
        larger.lengths[axis] = std::max(larger.lengths[axis], last.lengths[axis]);
    larger.uncertainty = std::max(first.uncertainty, last.uncertainty);
    // Two roundings are those of the coefficients, and two more cover the rounding of this bound.
    return determinantFloor(larger, 4);
}

/// The volume that is checked: the cells of a level, the limit of the base cells, or the cells of a
/// volume mesh. A cell consists of parts, and a part of one or more pieces.
class CheckedVolume {
public:
    /// The volume of a level. Each cell is its own single part.
    /// \throws Error unless the level is a lattice of quadrilaterals
    explicit CheckedVolume(const far::CellComplex& level);
    explicit CheckedVolume(const limit::LimitParts& limit);
    /// The volume of a mesh. Each cell is its own single part.
    /// \param rest positions of its points, finite
    CheckedVolume(const far::VolumeMesh& mesh, std::span<const Point3> rest);

    Index cellCount() const { return mesh_ ? mesh_->mesh().cellCount() : cells_.count(3); }
    Index vertexCount() const { return mesh_ ? mesh_->mesh().pointCount() : cells_.count(0); }
    Index partCount() const;

    /// Number of parts that one thread takes at a time. A patch takes a hundred times as long as a
    /// cell.
    Offset grain() const { return limit_ ? 8 : 1024; }

    Index cellOf(Index part) const;

    /// Returns the group of each cell, as numbers from 0. Most cells of a group are taken to be
    /// oriented as they should be. The groups of a lattice are its connected
    /// components, joined by faces; those of a mesh are the kinds of cells, since programs disagree
    /// on the order of the points of a wedge.
    std::vector<Index> orientationGroups() const;

    /// \param positions positions of the vertices. For a level or a mesh, the result has them as
    ///        `limits` and no `levels`; the centres of a mesh follow
    limit::LimitPositions place(std::span<const Point3> positions) const;

    /// Calls visit(piece…) for each piece of a part. The piece is passed once for each of
    /// `positions`: all are Piece<0>, all Piece<1>, or all Piece<3>.
    template <class Visit, class... Positions>
    void forEachPiece(Index part, Visit visit, const Positions&... positions) const {
        const std::size_t number = part;
        if (mesh_) {
            mesh_->forEach(part, visit, std::span<const Point3>(positions.limits)...);
            return;
        }
        if (limit_ && number < limit_->patchCount()) {
            visit(pieceOf(limit_->bezierPatch(number, positions))...);
            return;
        }
        const Index cell = limit_ ? limit_->parts()[number].cell : part;
        CellPieces(limit_ ? limit_->lastLevel() : cells_, cell)
            .forEach(visit, std::span<const Point3>(positions.limits)...);
    }

private:
    far::CellComplex cells_;  ///< the cells of a level, or the base cells
    std::optional<limit::LimitParts> limit_;
    std::shared_ptr<const MeshPieces> mesh_;
};

}  // namespace espalier::solve
