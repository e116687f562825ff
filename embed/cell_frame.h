// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/refinement.h>

#include <array>
#include <cstddef>
#include <optional>

// The axes of a hexahedron, and how they go on into its neighbours and its children.
namespace espalier::embed {

/// A hexahedron with its axes u, v and w: corner u + 2v + 4w is the one at (u, v, w), each 0 or 1.
struct CellFrame {
    Index cell = 0;
    std::array<Index, 8> corners = {};
};

/// The bit of a corner's number that says where it lies along an axis.
inline std::size_t bitOf(std::size_t corner, std::size_t axis) {
    return corner >> axis & 1;
}

/// The axes that far::hexahedronVertices() gives: right-handed in an oriented lattice. Nothing for
/// any other cell.
std::optional<CellFrame> frameOf(const far::CellComplex& complex, Index cell);

/// The hexahedron on the other side of a face, with the same axes.
/// \param side 0 the face where the coordinate is 0, 1 that where it is 1
/// \return nothing if there is none, or no hexahedron
std::optional<CellFrame> neighbourOf(const far::CellComplex& complex, const CellFrame& frame,
                                     std::size_t axis, std::size_t side);

/// The child [v, c] at a corner v, with the same axes: it holds the half of each that begins there.
/// \param parent the complex that the frame is of
/// \return nothing if it was not kept
std::optional<CellFrame> childOf(const far::CellComplex& parent, const far::Refinement& refinement,
                                 const CellFrame& frame, std::size_t corner);

}  // namespace espalier::embed
