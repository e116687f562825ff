// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>

#include <cstddef>
#include <span>

#include "level_match.h"

// Checks of the memory limit before each step of a comparison. OpenSubdiv does not check a
// MemoryLimit while it works, nor do the relations of a large level while they grow. Each function
// computes a lower bound of the step's peak, and throws MemoryError, naming the step, if the bound
// is beyond the limit.
namespace espalier::compare {

/// For OpenSubdiv's topology of levels 1 to `maxLevel`.
/// \param cornerCount corners of all faces of the surface at level 0
void requireForLevels(std::size_t cornerCount, int maxLevel);

/// For the match of a level, the compared part of it, and the relations that both read.
/// \param level the finest of `refiner`: of those before it, refinement has derived the relations
void requireForMatch(const far::TopologyRefiner& refiner, int level);

/// For OpenSubdiv's stencils of levels 1 to the finest one.
/// \param regions the compared part of each level
/// \cost that of our own stencils of two levels, from which the entries of later ones are estimated
void requireForTable(const far::TopologyRefiner& refiner, std::span<const Surface> regions);

/// For the tables of one level that are compared.
/// \param entryCount of our own table of that level
void requireForComparison(int level, Offset entryCount);

}  // namespace espalier::compare
