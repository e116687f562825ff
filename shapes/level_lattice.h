// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/shapes/lattice.h>

#include <span>
#include <vector>

namespace espalier {

/// Returns a level as a new lattice, to be written to a file or refined further.
///
/// Its marks preserve the strata: refined with refinerOptions(), level k of the new lattice has the
/// strata of level `level` + k of the refiner. A mesh or a curve also gets tags with the options of
/// the refiner. A lattice of dimension 3 has no tags: refine it with far::Boundary::Open if the
/// refiner had this mode, and with any other mode otherwise. Attributes and integers are not
/// copied: stencils::refineValues() refines attributes, and levelIntegers() copies integers.
///
/// \param level a level that the refiner has
/// \param positions one per vertex of the level
/// \throws Error if the refiner does not have the level, or the number of positions is wrong
/// \cost O(entities of the level)
ESPALIER_API Lattice levelLattice(const far::TopologyRefiner& refiner, int level,
                                  std::vector<Point3> positions);

/// Returns the integers of a base lattice on a level that the refiner has as a whole. Vertex points
/// of base vertices have the integers of the base vertex; all other vertices have noInteger().
///
/// \param integers `components` values per vertex of level 0
/// \throws Error if the refiner does not have the level, or the integers do not fit level 0
/// \cost O(vertices of the level), for each list
ESPALIER_API std::vector<VertexIntegers> levelIntegers(const far::TopologyRefiner& refiner,
                                                       int level,
                                                       std::span<const VertexIntegers> integers);

}  // namespace espalier
