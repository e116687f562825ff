// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>

#include <cstddef>
#include <span>

#include "surface.h"

// Memory that the steps of a comparison take, asked for before each step: neither OpenSubdiv nor
// the relations of a large level look at a MemoryLimit while they grow. Each function counts
// what its step holds at its peak, at least, and throws MemoryError, naming the step, if that
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
