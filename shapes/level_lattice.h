// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/shapes/lattice.h>

#include <span>
#include <vector>

namespace espalier {

/// A level as a lattice of its own, to write to a file, or to refine further.
///
/// It has the marks that keep its strata: refined by refinerOptions(), its level k has the strata
/// of level `level` + k of the refiner. A mesh or a curve has tags as well, which keep how it is
/// refined; a lattice of three dimensions is to be refined under the same boundary mode where that
/// is far::Boundary::Open, and under any other else. Attributes and integers are not
/// carried over: stencils::refineValues() refines attributes, and levelIntegers() carries integers.
///
/// \param level one that the refiner has
/// \param positions one a vertex of the level
/// \throws Error if the refiner does not have the level, or there are not as many positions
/// \cost O(entities of the level)
ESPALIER_API Lattice levelLattice(const far::TopologyRefiner& refiner, int level,
                                  std::vector<Point3> positions);

/// The integers of a base lattice on a level that the refiner has whole: unchanged at the vertices
/// that are vertex points of vertices of the base, and noInteger() at all others.
///
/// \param integers `components` a vertex of level 0
/// \throws Error if the refiner does not have the level, or the integers do not fit level 0
/// \cost O(vertices of the level), for each list
ESPALIER_API std::vector<VertexIntegers> levelIntegers(const far::TopologyRefiner& refiner,
                                                       int level,
                                                       std::span<const VertexIntegers> integers);

}  // namespace espalier
