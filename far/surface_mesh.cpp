// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/far/surface_mesh.h>
#include <espalier/far/topology_error.h>

namespace espalier::far {

void SurfaceMesh::addFace(std::span<const Index> points) {
    const Index face = faceCount();
    checkCancelledEvery(face, 12);
    switch (points.size()) {
        case 3:
        case 4:
        case 6:
        case 8:
        case 9:
            break;
        default:
            throw TopologyError(
                TopologyCause::TooFewVertices, {2, face},
                concat("face ", face, " has ", points.size(), " points; expected 3, 4, 6, 8 or 9"));
    }
    for (const Index point : points)
        if (point < 0 || point >= pointCount_)
            throw TopologyError(
                TopologyCause::VertexOutOfRange, {2, face},
                concat("face ", face, " names point ", point, "; there are ", pointCount_));
    faces_.push(points);
}

}  // namespace espalier::far
