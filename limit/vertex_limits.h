// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <span>

// Builds the limits of vertices of curves, meshes and lattices.
namespace espalier::limit {

/// Throws unless limits can be computed under these rules.
/// \throws Error under Rules::Rats
ESPALIER_API void checkLimitRules(far::Rules rules);

/// Builds L: row i holds the weights of the limit of vertices[i] over the vertices of the same
/// level. Only vertices that share an entity with it have weights, at most 27 in a regular lattice.
/// Rows sum to 1. A vertex on the open boundary has no limit, since it does not persist under
/// refinement: its row is empty.
///
/// \param level 0 to refiner.maxLevel(), of a curve, a mesh or a lattice. It must have all entities
///        that contain the vertices
/// \param vertices vertices of the level
/// \throws Error under Rules::Rats, whose rules use points outside the ring; if the level does not
///         exist, or does not have one of the vertices
/// \cost O(entries) where the lattice is regular; elsewhere the cost of ringOf() and limitMask(),
///       once for each distinct shape of ring. In parallel
/// \cite Halstead, Kass, DeRose 1993 (surfaces). Regular vertices: (1, 4, 1)/6, the values of the
///       uniform cubic B-spline at its knots
ESPALIER_API stencils::StencilTable<double> buildLimitMasks(const far::TopologyRefiner& refiner,
                                                            int level,
                                                            std::span<const Index> vertices);

/// Builds L · S_level: the limits of the given vertices of a level, or of all its vertices, over
/// the base vertices.
/// \throws Error under Rules::Rats; if the level does not exist, or lacks one of the vertices
/// \cost buildStencils() and buildLimitMasks()
ESPALIER_API stencils::StencilTable<double> buildVertexLimits(const far::TopologyRefiner& refiner,
                                                              int level,
                                                              std::span<const Index> vertices);
ESPALIER_API stencils::StencilTable<double> buildVertexLimits(const far::TopologyRefiner& refiner,
                                                              int level);

}  // namespace espalier::limit
