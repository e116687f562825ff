// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>

// The two steps of validate(): a fast check, and a slow check that names the offender.
namespace espalier::far {

/// Returns true for a lattice that requireValid() accepts; false for curves, meshes and all else.
/// Derives no relation of the complex.
/// \cost O(entries) on average, in parallel
bool isValidLattice(const CellComplex& complex);

/// Does what validate() does, but also checks a valid lattice slowly.
void requireValid(const CellComplex& complex);

}  // namespace espalier::far
