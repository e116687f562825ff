// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <memory>
#include <string>

#include "level_match.h"

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

}  // namespace espalier::compare
