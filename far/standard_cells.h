// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace espalier::far {

/// The standard cells, with VTK's vertex orders.
enum class StandardCell {
    Tetrahedron,  ///< 4 vertices: a triangle, anticlockwise seen from the apex, then the apex
    Pyramid,      ///< 5 vertices: a quadrilateral, anticlockwise seen from the apex, then the apex
    Wedge,        ///< 6 vertices: a triangle, clockwise seen from the opposite one; then the
                  ///< opposite one in the same order
    Hexahedron    ///< 8 vertices: a quadrilateral, anticlockwise seen from the opposite one; then
                  ///< the opposite one in the same order
};

/// The three neighbours of each vertex of a hexahedron in VTK's order. In a cell of positive
/// volume, the edges to them are a right-handed frame.
inline constexpr std::array<std::array<std::size_t, 3>, 8> kHexahedronNeighbours = {
    {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7}, {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}}};

/// Returns the number of vertices of a standard cell.
ESPALIER_API Index vertexCount(StandardCell cell);

/// Returns the faces of a standard cell as loops of positions in its vertex list, each
/// anticlockwise seen from outside.
ESPALIER_API const std::vector<std::vector<Index>>& faceLoops(StandardCell cell);

/// Returns the faces of a cell of a lattice as loops of vertices, each anticlockwise seen from
/// outside.
ESPALIER_API std::vector<std::vector<Index>> outwardLoops(const CellComplex& complex, CellId cell);

/// The kind and vertices of a lattice's cell that is one of the standard cells.
struct StandardCellVertices {
    StandardCell kind = StandardCell::Hexahedron;
    std::vector<Index> vertices;  ///< VTK's order: faceLoops(kind) are the faces of the cell
};

/// Recognises a tetrahedron, pyramid, wedge or hexahedron by its faces alone, regardless of vertex
/// positions. In a lattice with the usual orientation, the cell has a positive volume. Returns
/// nothing for any other cell.
ESPALIER_API std::optional<StandardCellVertices> asStandardCell(const CellComplex& complex,
                                                                CellId cell);

/// Returns the 8 vertices of a hexahedron (every type-3 cell is one) in VTK's order: the first face
/// of the cell, anticlockwise seen from the opposite face, then the opposite face in the same
/// order. So (0→1, 0→3, 0→4) is a right-handed frame in an oriented lattice. Returns nothing for
/// any other cell. This is faster than asStandardCell(): point location calls it for every cell.
ESPALIER_API std::optional<std::array<Index, 8>> hexahedronVertices(const CellComplex& complex,
                                                                    CellId cell);

}  // namespace espalier::far
