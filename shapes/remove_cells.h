// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/shapes/lattice.h>

#include <span>

namespace espalier::shapes {

/// Returns the lattice without some of its cells, and without the vertices that no other cell has.
///
/// The other cells and vertices keep their order. Attributes, integers and marks stay with their
/// vertices and edges. The rest may be in several pieces.
///
/// \param cells in any order; repeated numbers count once
/// \throws Error if a cell does not exist, or if all cells are named
/// \cost O(n log n) in the size of the lattice
ESPALIER_API Lattice removeCells(const Lattice& lattice, std::span<const Index> cells);

}  // namespace espalier::shapes
