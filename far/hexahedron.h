// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>

#include <array>
#include <optional>

namespace espalier::far {

/// The 8 vertices of a cell that is a hexahedron (every type-3 cell is), in VTK's order: the first
/// face of the cell, anticlockwise seen from the opposite one; that one likewise. So (0→1, 0→3,
/// 0→4) is a right-handed frame in an oriented lattice. Nothing for any other cell.
std::optional<std::array<Index, 8>> hexahedronVertices(const CellComplex& complex, CellId cell);

}  // namespace espalier::far
