// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/function_ref.h>
#include <espalier/base/index.h>
#include <espalier/far/topology_refiner.h>

// Finds where refinement is a uniform tricubic B-spline, and which cells vanish in the limit.
namespace espalier::embed {

/// Returns true if the cells around a vertex are part of a grid of hexahedra and follow its rules:
/// inside (8 cells), at a flat boundary (4), at a sharp edge (2) or at a corner (1), with no other
/// features and no semi-sharp ones.
ESPALIER_API bool isRegularVertex(const far::Level& level, Index vertex);

/// Does the same for a caller that knows which cells are hexahedra.
/// \param isHexahedron called with a cell; returns whether far::hexahedronVertices() has a result
ESPALIER_API bool isRegularVertex(const far::Level& level, Index vertex,
                                  FunctionRef<bool(Index)> isHexahedron);

/// Returns true if all vertices of a cell are regular. The map of the cell is then one tricubic
/// polynomial on this level and all further ones; at a boundary, it belongs to a spline with a
/// phantom layer 2P₀ − P₁.
ESPALIER_API bool isRegularCell(const far::Level& level, Index cell);

/// Returns true if a cell has a volume in the limit. Under Boundary::Open, a cell with all vertices
/// on the boundary shrinks away.
ESPALIER_API bool remainsInLimit(const far::Level& level, Index cell);

}  // namespace espalier::embed
