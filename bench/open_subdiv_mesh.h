// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

#include "workloads.h"

namespace espalier::bench {

/// Returns OpenSubdiv's refiner of a mesh at level 0. New vertices are numbered as ours: first
/// those from vertices, then those from faces and edges.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> openSubdivRefiner(const Mesh& mesh);

}  // namespace espalier::bench
