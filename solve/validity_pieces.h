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

/// How large derivatives are, and what they are known to.
struct PieceSize {
    /// The longest derivative along each axis; in a tetrahedron the size of the cell instead, as
    /// its apex is a mean over it. The rounding of derivatives is in proportion.
    std::array<double, 3> lengths = {};

    /// How far the ends of what derivatives are differences of may be off by rounding, each
    /// coordinate. Positions are sums of the products of up to 27 numbers, level by level: 16 units
    /// of the largest coordinate is more than that amounts to. Another 32 are more than what makes
    /// Bézier points of them, 3 times a sum of |weights| of 2.4 and of 6 terms along each axis; and
    /// derivatives of a cubic are 3 times differences.
    double uncertainty = 0;
};

/// A map from the cube: of degree 1 that of a hexahedron, or of one of the tetrahedra of a type-n
/// cell (whose derivatives are the same everywhere), of degree 3 a patch of the limit.
template <std::size_t Degree>
struct Piece {
    Derivatives<Degree> derivatives;
    PieceSize size = {};
};

Piece<3> pieceOf(const limit::BezierPatch& patch);

/// What a cell of a refined lattice is taken apart into, as for embedding: a type-3 cell into its
/// trilinear map, a type-n cell into 4n tetrahedra around its cell point. In a lattice that is
/// oriented as usual, and not folded, all determinants are positive.
///
/// \cite MacCracken & Joy 1996, section 6
class CellPieces {
public:
    /// \param complex a lattice of quadrilaterals; must outlive this
    CellPieces(const far::CellComplex& complex, Index cell);

    Index count() const;

    /// \param positions one a vertex of the complex
    /// \cost O(vertices of the cell)
    Piece<1> piece(Index number, std::span<const Point3> positions) const;

private:
    Piece<1> hexahedron(std::span<const Point3> positions) const;
    Piece<1> tetrahedron(Index number, std::span<const Point3> positions) const;

    const far::CellComplex& complex_;
    CellId cell_;
    std::optional<std::array<Index, 8>> corners_;  ///< of a hexahedron
};

/// What a determinant must be above to count as positive: as much as it changes when edges are
/// longer by their uncertainty, and 6e-14 of the product of the lengths, 512 units of rounding.
/// That holds all that its coefficients were rounded by: 3 units for the edges, 12 for the
/// determinants of edges, 24 for their sums, 60 for halvings; and 2n + 2 for each edge of the
/// tetrahedra of a type-n cell, for n up to 50 or so. For a patch, 12 for determinants, 84 for sums
/// of up to 36 and 48 of them, and 240 for halvings, 8 for each.
double determinantFloor(const PieceSize& size);

/// The same while a piece goes over from one to another linearly: Bernstein coefficients of degree
/// 3 in time, as determinant() has them. Twice as much is held then: sums have twice as many terms,
/// and time is halved 60 times at most, by 3 units each.
std::array<double, 4> determinantFloor(const PieceSize& first, const PieceSize& last);

/// The volume of a lattice as it is checked: either that of the cells of a level, or the limit of
/// the cells of the base. Cells are made of parts, each of one or more pieces.
class CheckedVolume {
public:
    /// Each cell is the only part of itself.
    /// \throws Error if it is not a lattice of quadrilaterals
    explicit CheckedVolume(const far::CellComplex& level);
    explicit CheckedVolume(const limit::LimitParts& limit);

    /// Those that are found good or bad.
    const far::CellComplex& cells() const { return cells_; }

    Index partCount() const;

    /// Parts that one thread is to take at a time: a patch takes a hundred times as long as a cell.
    Offset grain() const { return limit_ ? 8 : 1024; }

    Index cellOf(Index part) const;

    /// \param positions of the vertices of cells(); of a level they are those `limits`, and all
    limit::LimitPositions place(std::span<const Point3> positions) const;

    /// Calls visit(piece…) for each piece of a part, which is there once for each of some
    /// positions: all Piece<1>, or all Piece<3>.
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
