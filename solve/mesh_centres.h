// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/volume_mesh.h>

#include <span>
#include <vector>

// Centres, areas and volumes of the faces and cells of a volume mesh, by OpenFOAM's formulas
// (primitiveMesh, version 1912).

namespace espalier::solve {

struct FaceCentre {
    Point3 centre;
    Point3 area;  ///< area vector: it points away from the owner
};

/// Computes the centre of a face: the mean of the centroids of the triangles that join the mean of
/// its points to its edges, weighted by their areas. The area vector is the sum over the triangles.
///
/// \param weights receives, if it is not null, one weight per point: the centre is the sum of
///        weights times points, and the weights sum to 1
FaceCentre faceCentre(std::span<const Index> loop, std::span<const Point3> positions,
                      std::vector<double>* weights = nullptr);

struct CellCentre {
    Point3 centre;
    double volume = 0;
};

/// Computes the centre of a cell: the mean of the centroids of the pyramids that join the mean of
/// its face centres to its faces, weighted by their signed volumes; the mean of the face centres if
/// the volume is 0. The volume is the sum over the pyramids.
///
/// \param centres, areas one for each face of the mesh; only faces of the cell are used
/// \param weights receives, if it is not null, one weight per face of the cell: the centre is the
///        sum of weights times centres, and the weights sum to 1
CellCentre cellCentre(const far::VolumeMesh& mesh, Index cell, std::span<const Point3> centres,
                      std::span<const Point3> areas, std::vector<double>* weights = nullptr);

}  // namespace espalier::solve
