// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/lattice.h>

#include <optional>
#include <span>
#include <vector>

#include "collar_cells.h"

namespace espalier::cages {

/// Proves that a lattice with a collar has no folds at level 1 and in the limit, and that no
/// boundary vertex of level 1 is in a cell that it is not a corner of. Cells of the lattice that
/// folded without the collar are left out, and so are overlaps that the lattice had.
class CollarProof {
public:
    /// \param before the lattice without the collar; must outlive this object
    explicit CollarProof(const Lattice& before);

    /// Tells for each cell of the lattice whether it folded without the collar.
    std::span<const char> wasBad() const { return wasBad_; }

    enum class FailureKind { Fold, FoldInLimit, Overlap, TooThick };

    /// Cells that cannot be proved.
    struct Failure {
        FailureKind kind = FailureKind::Fold;
        std::vector<Index> cells = {};  ///< of the lattice with the collar; none if TooThick

        /// Vertices of the lattice near the cells, cell by cell; at least one, with repetitions.
        std::vector<Index> vertices = {};

        /// Returns the vertex that most of the cells have; the first one of them.
        Index mostFrequent() const;

        /// Returns the end of the sentence "cells would ...".
        const char* text() const;
    };

    /// Returns nothing if all cells can be proved.
    /// \param lattice with the collar
    std::optional<Failure> failure(const Lattice& lattice, const CollarCells& cells) const;

private:
    const Lattice& before_;
    std::vector<char> wasBad_;  ///< per cell of the lattice
};

}  // namespace espalier::cages
