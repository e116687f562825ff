// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>

#include <array>
#include <optional>
#include <vector>

namespace espalier::far {

/// The standard cells, with VTK's vertex orders.
enum class StandardCell {
    Tetrahedron,  ///< 4 vertices: a triangle, anticlockwise seen from the apex; the apex
    Pyramid,      ///< 5 vertices: a quadrilateral, anticlockwise seen from the apex; the apex
    Wedge,        ///< 6 vertices: a triangle, clockwise seen from the other one; that one likewise
    Hexahedron    ///< 8 vertices: a quadrilateral, anticlockwise seen from the other one; that one
};

/// Number of vertices of a standard cell.
ESPALIER_API Index vertexCount(StandardCell cell);

/// The faces of a standard cell, as loops of positions in its vertex list, each anticlockwise from
/// outside.
ESPALIER_API const std::vector<std::vector<Index>>& faceLoops(StandardCell cell);

/// The faces of a cell of a lattice, as loops of vertices, each anticlockwise from outside.
ESPALIER_API std::vector<std::vector<Index>> outwardLoops(const CellComplex& complex, CellId cell);

/// A cell of a lattice that is one of the standard ones.
struct StandardCellVertices {
    StandardCell kind = StandardCell::Hexahedron;
    std::vector<Index> vertices;  ///< in VTK's order: faceLoops(kind) are its faces
};

/// Recognises a tetrahedron, pyramid, wedge or hexahedron by its faces alone; where its vertices
/// lie does not count. In a lattice that is oriented as usual, the cell has a positive volume.
ESPALIER_API std::optional<StandardCellVertices> asStandardCell(const CellComplex& complex,
                                                                CellId cell);

/// The 8 vertices of a cell that is a hexahedron (every type-3 cell is), in VTK's order: the first
/// face of the cell, anticlockwise seen from the opposite one; that one likewise. So (0→1, 0→3,
/// 0→4) is a right-handed frame in an oriented lattice. Nothing for any other cell. The quick way
/// to what asStandardCell() knows of hexahedra: point location asks it for cell after cell.
ESPALIER_API std::optional<std::array<Index, 8>> hexahedronVertices(const CellComplex& complex,
                                                                    CellId cell);

}  // namespace espalier::far
