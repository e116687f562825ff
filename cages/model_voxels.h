// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <cstddef>
#include <span>
#include <vector>

#include "model_surface.h"
#include "point_groups.h"
#include "ranked_bits.h"
#include "symmetry.h"

namespace espalier::cages {

/// The voxels of a model: the cubes of a fine grid that meet its surface or lie in its solid.
///
/// The solid of closed pieces is where their winding numbers do not sum to 0. A piece that the
/// model winds inwards counts −1 in another piece, so that it is a cavity there, and 1 elsewhere.
/// The solid of open pieces is the space that cannot be reached from outside through gaps wider
/// than `gap`.
struct VoxelOptions {
    double size = 1;  ///< edge of a voxel

    /// True: the model is its surface only, without a solid.
    bool isShell = false;

    /// Voxels within this distance of the model are used, too.
    double around = 0;

    double gap = 0;

    /// Planes in the frame of the points. The grid is symmetric about them, and each voxel that is
    /// the mirror image of a used one is used, too.
    MirrorPlanes mirrors = {};
};

class ModelVoxels {
public:
    /// \param points of the surface, in any frame
    ModelVoxels(const ModelSurface& surface, std::span<const Point3> points,
                const VoxelOptions& options);

    const CubeGrid& grid() const { return grid_; }

    /// The cubes of the grid that belong to the model or its surroundings, with their ranks.
    const RankedBits& used() const { return used_; }

    /// Returns true if a point is in the solid, two voxels or more away from its boundary.
    bool isInner(const Point3& point) const;

    /// For each closed piece of the surface: 1, or −1 if it is a cavity.
    const std::vector<int>& signs() const { return signs_; }

private:
    void markClosed(const ModelSurface& surface, std::span<const Point3> points);
    void markEnclosed(const ModelSurface& surface, std::span<const Point3> points, double gap);
    void addMirrored(RankedBits& voxels, int axis) const;

    CubeGrid grid_;
    RankedBits used_;
    RankedBits solid_;  ///< empty for a shell
    std::vector<int> signs_;
};

}  // namespace espalier::cages
