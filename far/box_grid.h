// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/topology_error.h>

#include <array>
#include <vector>

namespace espalier::far {

/// A lattice seen as a box of hexahedra: which vertex is at each point of the grid.
struct BoxGrid {
    std::array<Index, 3> cells = {};  ///< how many along each axis, 1 or more

    /// The vertex at each grid point, axis 0 fastest: (cells[0] + 1)(cells[1] + 1)(cells[2] + 1).
    std::vector<Index> vertices = {};

    /// Where a grid point is in `vertices`.
    /// \param point 0 to cells[a] along axis a
    std::size_t indexOf(const std::array<Index, 3>& point) const {
        const Offset row = Offset{point[2]} * (cells[1] + 1) + point[1];
        return row * (cells[0] + 1) + point[0];
    }

    Index vertexAt(const std::array<Index, 3>& point) const { return vertices[indexOf(point)]; }
};

/// Recognises a box of hexahedra by its topology alone: the order of its vertices, edges, faces and
/// cells does not count.
///
/// Grid point (0, 0, 0) is the lowest of the vertices that are in one cell only. Its three
/// neighbours are the first points of the axes, in ascending order; so the axes of a grid that is
/// numbered as BoxGrid::vertices come in their order, and others may form a left-handed frame.
///
/// \throws TopologyError (WrongDimension) if `complex` is not a lattice; (NotABox) naming the first
///         cell that is not a hexahedron, or where the cells first fail to fill a box
/// \cost O(cells)
ESPALIER_API BoxGrid asBoxGrid(const CellComplex& complex);

}  // namespace espalier::far
