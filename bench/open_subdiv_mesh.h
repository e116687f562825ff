// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

#include "workloads.h"

namespace espalier::bench {

/// Returns OpenSubdiv's refiner of a mesh at level 0. New vertices that come from vertices have the
/// lowest numbers, as in ours; then come those from faces and edges.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> openSubdivRefiner(const Mesh& mesh);

}  // namespace espalier::bench
