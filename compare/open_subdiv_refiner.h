// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>

#include <opensubdiv/far/topologyRefiner.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "level_match.h"

// Checks of the memory limit before each step of a comparison. OpenSubdiv does not check a
// MemoryLimit while it works, nor do the relations of a large level while they grow. Each function
// computes a lower bound of the step's peak, and throws MemoryError, naming the step, if the bound
// is beyond the limit.

namespace espalier::compare {

/// OpenSubdiv's refiner of a surface.
struct OpenSubdivRefiner {
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
    /// Vertices that this release of OpenSubdiv would take for a non-manifold crease, and that were
    /// marked as corners for it, as its release 3.6.1 has them (pull request 1338).
    Index correctedCorners = 0;
};

/// Gives the surface of level 0 of a refiner to OpenSubdiv, and refines it to the same level.
/// Vertex i there is surface.vertices[i] here, face i is surface.faces[i].
///
/// Of a mesh, OpenSubdiv gets the boundary mode and the marks as they are. Of a lattice, whose
/// cells it cannot know, it gets the sharpness that edges and vertices have by hand or by rule. It
/// finds out by itself what else is sharp.
///
/// \throws Error if OpenSubdiv cannot hold the surface
OpenSubdivRefiner makeOpenSubdivRefiner(const far::TopologyRefiner& refiner,
                                        const Surface& surface);

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
