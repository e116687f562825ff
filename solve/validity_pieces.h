// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/point.h>
#include <espalier/solve/bernstein.h>

#include <array>
#include <optional>
#include <span>

namespace espalier::solve {

using far::Index;

/// The map of a hexahedron, or of one of the tetrahedra of a type-n cell.
struct Piece {
    Derivatives derivatives;  ///< of a tetrahedron the same everywhere

    /// Along each axis the longest edge; in a tetrahedron the size of the cell instead, as its apex
    /// is a mean over it. The rounding of derivatives is in proportion.
    std::array<double, 3> lengths;

    /// How far positions may be off by rounding, each coordinate. They are sums of the products of
    /// up to 27 numbers, level by level: 16 units of the largest coordinate of the cell is more
    /// than that amounts to.
    double uncertainty;
};

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
    Piece piece(Index number, std::span<const Point3> positions) const;

private:
    Piece hexahedron(std::span<const Point3> positions) const;
    Piece tetrahedron(Index number, std::span<const Point3> positions) const;

    const far::CellComplex& complex_;
    far::CellId cell_;
    std::optional<std::array<Index, 8>> corners_;  ///< of a hexahedron
};

/// What a determinant must be above to count as positive: as much as it changes when edges are
/// longer by their uncertainty, and 6e-14 of the product of the lengths, 512 units of rounding.
/// That holds all that its coefficients were rounded by: 3 units for the edges, 12 for the
/// determinants of edges, 24 for their sums, 60 for halvings; and 2n + 2 for each edge of the
/// tetrahedra of a type-n cell, for n up to 50 or so.
double determinantFloor(const Piece& piece);

/// The same while a piece goes over from one to another linearly: Bernstein coefficients of degree
/// 3 in time, as determinant() has them.
std::array<double, 4> determinantFloor(const Piece& first, const Piece& last);

}  // namespace espalier::solve
