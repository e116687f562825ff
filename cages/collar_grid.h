// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/box_grid.h>
#include <espalier/shapes/lattice.h>

#include <optional>

#include "collar_cells.h"

namespace espalier::cages {

/// Returns the boundary faces of the open sides of a box lattice. The plane of a side is across its
/// mean normal.
/// \throws ArgumentError if no side faces an open direction, or two sides do; Error if all sides
/// are
///         open
OpenFaces openFacesOfBox(const Lattice& lattice, const far::BoxGrid& grid,
                         const CollarOptions& options);

/// Returns the cells that make a box lattice a larger box.
///
/// Vertex (i, j, k) of the larger box is over the vertex of the lattice with the nearest (i', j',
/// k'), and is moved from there along one direction for each axis on which the two differ. With
/// CollarOptions::reach, the direction of a side is its mean normal, perpendicular to the open
/// sides. So each layer of a side is a translate of the side, and cells at the edges and corners
/// are spanned by translations. With CollarOptions::until, the direction is a coordinate axis, and
/// ends in the box.
///
/// \return nothing if a side has no direction to grow in, since it has no area or is nearly
/// parallel
///         to an open side
/// \throws as openFacesOfBox(); ArgumentError for `until` around sides that do not face the axes,
/// or
///         beyond the box; Error for `until` around a side without area
std::optional<CollarCells> gridCollar(const Lattice& lattice, const far::BoxGrid& grid,
                                      const CollarOptions& options);

}  // namespace espalier::cages
