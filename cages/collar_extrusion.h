// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/lattice.h>

#include <array>
#include <span>

#include "collar_cells.h"

namespace espalier::cages {

/// Returns the boundary faces whose vertices all are at an end of a lattice that is open, within
/// 1 % of the extent. Their planes are across the axes.
/// \throws Error if there is no such face at an open end
OpenFaces openFacesAtEnds(const Lattice& lattice, const std::array<bool, 6>& open);

/// Returns a prism per layer over each boundary face of a lattice, except the open ones.
///
/// From layer to layer, a vertex moves along the direction that makes the smallest largest angle
/// with the normals of the faces around it; at open sides, in their planes. It moves
/// farther where the faces around it meet at an angle, so that planes stay planes. The reach of a
/// vertex is at most 0.4 of the diameter of the largest ball on it that contains no vertex whose
/// normal points the other way. The cells may fold; see untangle.h.
///
/// \param parts of the reach that the vertices get, per vertex of the lattice, 0 to 1
/// \param options with a reach; `open` is not read
/// \throws Error if all faces are open, and if the boundary is not a manifold
CollarCells extrudedCollar(const Lattice& lattice, const CollarOptions& options,
                           const OpenFaces& open, std::span<const double> parts);

}  // namespace espalier::cages
