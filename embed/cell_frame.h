// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/refinement.h>

#include <array>
#include <cstddef>
#include <optional>

// The axes of a hexahedron, and how they continue into its neighbours and its children.
namespace espalier::embed {

/// A hexahedron with its axes u, v and w: corner u + 2v + 4w is the one at (u, v, w), each 0 or 1.
struct CellFrame {
    Index cell = 0;
    std::array<Index, 8> corners = {};
};

/// Returns the coordinate, 0 or 1, of a corner along an axis.
inline std::size_t bitOf(std::size_t corner, std::size_t axis) {
    return corner >> axis & 1;
}

/// Returns the axes that far::hexahedronVertices() gives: right-handed in an oriented lattice.
/// Returns nothing if the cell is not a hexahedron.
std::optional<CellFrame> frameOf(const far::CellComplex& complex, Index cell);

/// Returns the hexahedron on the other side of a face, with the same axes.
/// \param side 0 for the face where the coordinate is 0, 1 for the face where it is 1
/// \return nothing if there is no cell, or the cell is not a hexahedron
std::optional<CellFrame> neighbourOf(const far::CellComplex& complex, const CellFrame& frame,
                                     std::size_t axis, std::size_t side);

/// Returns the child [v, c] of a hexahedron c at a corner v, with the same axes: it covers the half
/// of each axis that starts at v.
/// \param parent the complex that the frame belongs to
/// \return nothing if the refinement left this child out
std::optional<CellFrame> childOf(const far::CellComplex& parent, const far::Refinement& refinement,
                                 const CellFrame& frame, std::size_t corner);

}  // namespace espalier::embed
