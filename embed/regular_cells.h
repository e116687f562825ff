// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/topology_refiner.h>

// Where refinement is that of a uniform tricubic B-spline, and where it comes to nothing.
namespace espalier::embed {

/// Whether the cells around a vertex are a part of a grid of hexahedra, and keep to the rules of
/// one: inside (8 cells), at a flat boundary (4), at a sharp edge (2) or at a corner (1), with no
/// other features and none that are semi-sharp.
ESPALIER_API bool isRegularVertex(const far::Level& level, Index vertex);

/// Whether all vertices of a cell are regular. The volume in it is then one tricubic polynomial,
/// now and on all levels to come; at a boundary that of a spline with a phantom layer 2P₀ − P₁.
ESPALIER_API bool isRegularCell(const far::Level& level, Index cell);

/// Whether a cell becomes anything in the limit: under Boundary::Open, one shrinks away of which
/// all vertices are on the boundary.
ESPALIER_API bool isLasting(const far::Level& level, Index cell);

}  // namespace espalier::embed
