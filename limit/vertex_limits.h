// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <span>

namespace espalier::limit {

/// Checks that limits are known under some rules.
/// \throws Error under Rules::Rats
ESPALIER_API void checkLimitRules(far::Rules rules);

/// L: row i holds the weights of the limit of vertices[i] over the vertices of the same level,
/// those of the entities that contain it: 27 at most in a regular lattice. Rows sum to 1. A vertex
/// on the open boundary does not stay, and has no limit: its row is empty.
///
/// \param level 0 to refiner.maxLevel(); all that contains the vertices must be there. A curve, a
///        mesh or a lattice
/// \param vertices of the level
/// \throws Error as ringOf(), and checkVertices()
/// \cost O(entries) where the lattice is regular; elsewhere that of ringOf() and limitMask(), once
///       for each shape of ring. In parallel
/// \cite Halstead, Kass, DeRose 1993 (surfaces); regular: the values (1, 4, 1)/6 of the uniform
///       cubic B-spline at its knots
ESPALIER_API stencils::StencilTable<double> buildLimitMasks(const far::TopologyRefiner& refiner,
                                                            int level,
                                                            std::span<const Index> vertices);

/// L · S_level: the limits of the vertices of a level, or of some of them, over the base vertices.
/// \throws Error as above
/// \cost as buildStencils(), and as above
ESPALIER_API stencils::StencilTable<double> buildVertexLimits(const far::TopologyRefiner& refiner,
                                                              int level,
                                                              std::span<const Index> vertices);
ESPALIER_API stencils::StencilTable<double> buildVertexLimits(const far::TopologyRefiner& refiner,
                                                              int level);

}  // namespace espalier::limit
