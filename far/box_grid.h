// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/topology_error.h>

#include <array>
#include <vector>

namespace espalier::far {

/// A lattice as a box of hexahedra: tells which vertex is at each point of the grid.
struct BoxGrid {
    std::array<Index, 3> cells = {};  ///< number of cells along each axis, 1 or more

    /// The vertex at each grid point, axis 0 fastest: (cells[0] + 1)(cells[1] + 1)(cells[2] + 1).
    std::vector<Index> vertices = {};

    /// Returns the position of a grid point in `vertices`.
    /// \param point 0 to cells[a] along axis a
    std::size_t indexOf(const std::array<Index, 3>& point) const {
        const Offset row = Offset{point[2]} * (cells[1] + 1) + point[1];
        return row * (cells[0] + 1) + point[0];
    }

    Index vertexAt(const std::array<Index, 3>& point) const { return vertices[indexOf(point)]; }
};

/// Recognises a box of hexahedra by its topology alone; the order of its vertices, edges, faces and
/// cells does not matter.
///
/// Grid point (0, 0, 0) is the lowest vertex that is in one cell only. Its three neighbours, in
/// ascending order, define the directions of the axes. So the axes of a grid that is numbered as
/// BoxGrid::vertices keep their order; with other numberings, the axes may form a left-handed
/// frame.
///
/// \throws TopologyError (WrongDimension) if `complex` is not a lattice; (NotABox) if the cells do
///         not form a box: names the first cell that is not a hexahedron, or the first place where
///         the cells do not fit
/// \cost O(cells)
ESPALIER_API BoxGrid asBoxGrid(const CellComplex& complex);

}  // namespace espalier::far
