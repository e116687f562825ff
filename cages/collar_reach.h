// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/lattice.h>

#include <vector>

#include "collar_cells.h"

namespace espalier::cages {

/// Returns the distance of each outer vertex of a collar from the faces of the lattice that the
/// collar covers, in the order of CollarCells::vertices; 0 for the vertices of inner layers.
/// \param layers of the collar
/// \cost O(n log n) for n covered faces
std::vector<double> distancesFromLattice(const Lattice& lattice, const CollarCells& cells,
                                         int layers);

}  // namespace espalier::cages
