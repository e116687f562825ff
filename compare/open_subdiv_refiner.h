// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/face_varying.h>
#include <espalier/far/topology_refiner.h>

#include <opensubdiv/far/topologyRefiner.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "level_match.h"

// The functions requireFor… check a MemoryLimit before each step of a comparison, because
// OpenSubdiv does not check the limit while it works, and neither do the relations of a large level
// while they grow. Each function computes a lower bound of the step's peak memory, and throws a
// MemoryError that names the step if the bound exceeds the limit.

namespace espalier::compare {

/// OpenSubdiv's refiner of a surface, and the number of vertices that were corrected for it.
struct OpenSubdivRefiner {
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
    /// Number of vertices that this release of OpenSubdiv would treat as a non-manifold crease.
    /// They were marked as corners, as release 3.6.1 treats them (pull request 1338).
    Index correctedCorners = 0;
};

/// The face-varying values of a mesh, as far::refineFaceVarying() takes them.
struct FaceVaryingValues {
    std::span<const Index> cornerValues;
    far::FaceVaryingLinear linear;
};

/// Refines the surface of a refiner's level 0 with OpenSubdiv, to the same level. OpenSubdiv's
/// vertex i is surface.vertices[i], its face i is surface.faces[i].
///
/// For a mesh, OpenSubdiv gets the boundary mode and the marks. For a lattice, whose cells
/// OpenSubdiv does not have, it gets the sharpness of edges and vertices that marks or rules set,
/// and finds any other sharp features itself.
///
/// \param faceVarying null, or the values of OpenSubdiv's face-varying channel 0; for a mesh only
/// \throws Error if OpenSubdiv cannot represent the surface
OpenSubdivRefiner makeOpenSubdivRefiner(const far::TopologyRefiner& refiner, const Surface& surface,
                                        const FaceVaryingValues* faceVarying = nullptr);

/// Checks the memory for OpenSubdiv's topology of levels 1 to `maxLevel`.
/// \param cornerCount number of corners of all faces of the surface at level 0
void requireForLevels(std::size_t cornerCount, int maxLevel);

/// Checks the memory for the match of a level, its compared part, and the relations that both read.
/// \param level the finest level of `refiner`; refinement has derived the relations of the levels
///        before
void requireForMatch(const far::TopologyRefiner& refiner, int level);

/// Checks the memory for OpenSubdiv's stencils of all levels from 1 on.
/// \param regions the compared part of each level
/// \cost the cost of our own stencils of two levels, from which the number of entries is estimated
void requireForTable(const far::TopologyRefiner& refiner, std::span<const Surface> regions);

/// Checks the memory for comparing the tables of one level.
/// \param entryCount number of entries of our own table of this level
void requireForComparison(int level, Offset entryCount);

}  // namespace espalier::compare
