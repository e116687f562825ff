// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <array>
#include <cstddef>
#include <vector>

#include "grid_cells.h"
#include "model_surface.h"
#include "model_voxels.h"
#include "point_groups.h"
#include "work.h"

namespace espalier::cages {

struct SampleOptions {
    double spacing = 1;  ///< largest distance between neighbours on a face

    /// True: the model is its surface only, so that faces have no outer side.
    bool isShell = false;

    /// Axes of the frame of the voxels.
    std::array<Point3, 3> axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

    /// If there would be more samples, those that are near others are left out: of the samples in
    /// one part of a voxel whose faces look in about one direction, one remains. A part is a
    /// quarter of a voxel wide; half a voxel or a whole one if there would still be too many; and a
    /// whole one inside the solid (ModelVoxels::isInner()), where no sample is near the boundary.
    /// The points of the model all remain.
    std::size_t most = 0;
};

/// Returns points of the faces of a model: all of its points, the middles of sides and faces, and
/// more where faces are large. Each has the cell that it belongs to.
/// \param voxels, cells of the model
/// \throws Error if even one sample for each voxel and direction is more than `most` samples and
///         all points of the model
std::vector<FitPoint> sampleModel(const ModelSurface& surface, const ModelVoxels& voxels,
                                  const GridCells& cells, const SampleOptions& options, Work& work);

}  // namespace espalier::cages
