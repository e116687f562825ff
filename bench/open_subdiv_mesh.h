// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

#include "workloads.h"

namespace espalier::bench {

/// OpenSubdiv's refiner of a mesh, at level 0. New vertices are numbered as here: those of the
/// vertices, then those of the faces and edges.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> openSubdivRefiner(const Mesh& mesh);

}  // namespace espalier::bench
