// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/limit/limit_parts.h>

#include <optional>
#include <span>

#include "validity_pieces.h"

namespace espalier::solve {

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
        const auto number = static_cast<std::size_t>(part);
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
