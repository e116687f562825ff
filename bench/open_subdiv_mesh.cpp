// SPDX-License-Identifier: Apache-2.0
#include "open_subdiv_mesh.h"

#include <opensubdiv/far/topologyDescriptor.h>

namespace espalier::bench {

namespace Far = OpenSubdiv::Far;

std::unique_ptr<Far::TopologyRefiner> openSubdivRefiner(const Mesh& mesh) {
    std::vector<int> sizes, corners;
    for (const auto& loop : mesh.loops) {
        sizes.push_back(static_cast<int>(loop.size()));
        corners.insert(corners.end(), loop.begin(), loop.end());
    }
    Far::TopologyDescriptor description;
    description.numVertices = mesh.vertexCount;
    description.numFaces = static_cast<int>(sizes.size());
    description.numVertsPerFace = sizes.data();
    description.vertIndicesPerFace = corners.data();
    OpenSubdiv::Sdc::Options options;
    options.SetVtxBoundaryInterpolation(options.VTX_BOUNDARY_EDGE_AND_CORNER);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    return std::unique_ptr<Far::TopologyRefiner>(
        Factory::Create(description, Factory::Options(OpenSubdiv::Sdc::SCHEME_CATMARK, options)));
}

}  // namespace espalier::bench
