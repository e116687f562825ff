// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/limit/limit_parts.h>

#include <array>
#include <optional>
#include <span>

#include "bernstein.h"

namespace espalier::solve {

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
};

/// A map from the unit cube. Degree 1: a hexahedron, or one of the tetrahedra of a type-n cell,
/// whose derivatives are constant. Degree 3: a patch of the limit.
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

    Index count() const;

    /// \param positions one for each vertex of the complex
    /// \cost O(vertices of the cell)
    Piece<1> piece(Index number, std::span<const Point3> positions) const;

private:
    Piece<1> hexahedron(std::span<const Point3> positions) const;
    Piece<1> tetrahedron(Index number, std::span<const Point3> positions) const;

    const far::CellComplex& complex_;
    CellId cell_;
    std::optional<std::array<Index, 8>> corners_;  ///< of the hexahedron; empty for other cells
};

/// Returns the value that a determinant must exceed to count as positive: its change when edges
/// become longer by their uncertainty, plus 6e-14 of the product of the lengths, which is 512 units
/// of rounding. This covers all rounding of the coefficients: 3 units for the edges, 12 for the
/// determinants of edges, 24 for their sums, 60 for halvings; and 2n + 2 for each edge of the
/// tetrahedra of a type-n cell, for n up to about 50. For a patch: 12 for determinants, 84 for sums
/// of up to 36 and 48 of them, and 240 for halvings, 8 for each.
double determinantFloor(const PieceSize& size);

/// Returns the same bound while a piece changes linearly from `first` to `last`: Bernstein
/// coefficients of degree 3 in time, as for determinant(). It allows for twice the rounding, since
/// sums have twice as many terms and time is halved up to 60 times, by 3 units each.
std::array<double, 4> determinantFloor(const PieceSize& first, const PieceSize& last);

/// The volume of a lattice that is checked: either the cells of a level, or the limit of the base
/// cells. A cell consists of parts, and a part of one or more pieces.
class CheckedVolume {
public:
    /// The volume of a level. Each cell is its own single part.
    /// \throws Error unless the level is a lattice of quadrilaterals
    explicit CheckedVolume(const far::CellComplex& level);
    explicit CheckedVolume(const limit::LimitParts& limit);

    /// The cells that results are about.
    const far::CellComplex& cells() const { return cells_; }

    Index partCount() const;

    /// Number of parts that one thread takes at a time. A patch takes a hundred times as long as a
    /// cell.
    Offset grain() const { return limit_ ? 8 : 1024; }

    Index cellOf(Index part) const;

    /// \param positions positions of the vertices of cells(). For a level, the result has them as
    ///        `limits` and no `levels`
    limit::LimitPositions place(std::span<const Point3> positions) const;

    /// Calls visit(piece…) for each piece of a part. The piece is passed once for each of
    /// `positions`: all are Piece<1>, or all Piece<3>.
    template <class Visit, class... Positions>
    void forEachPiece(Index part, Visit visit, const Positions&... positions) const {
        const std::size_t number = part;
        if (limit_ && number < limit_->patchCount()) {
            visit(pieceOf(limit_->bezierPatch(number, positions))...);
            return;
        }
        const Index cell = limit_ ? limit_->parts()[number].cell : part;
        const CellPieces pieces(limit_ ? limit_->lastLevel() : cells_, cell);
        for (Index i = 0; i < pieces.count(); ++i) visit(pieces.piece(i, positions.limits)...);
    }

private:
    far::CellComplex cells_;
    std::optional<limit::LimitParts> limit_;
};

}  // namespace espalier::solve
