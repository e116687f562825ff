// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>

#include <array>
#include <vector>

#include "model_voxels.h"
#include "point_groups.h"

// Finds the connected parts of a model in the cubes of a grid, and their contacts.
namespace espalier::cages {

inline constexpr Index kDirections = 6;  ///< of a cube: axis · 2 + 1 for the higher side

/// Cubes of several voxels, around all voxels of a grid and one more layer of cubes on each side.
struct Cubes {
    using Cube = std::array<Index, 3>;

    /// \param perEdge voxels along the edge of a cube
    /// \param offset number of voxels before the grid along each axis, without the layer of cubes
    Cubes(const CubeGrid& grid, Index perEdge, const Cube& offset);

    /// Returns the number of a cube. Numbers ascend by layers.
    Index numberOf(const Cube& cube) const {
        return (cube[2] * counts[1] + cube[1]) * counts[0] + cube[0];
    }

    Index perEdge;
    Cube offset;  ///< number of voxels before the grid, along each axis
    Cube counts;  ///< number of cubes along each axis
};

/// A part of a model in a cube.
struct CubePart {
    struct Contact {
        Index to = 0;
        Index direction = 0;
        Index count = 0;  ///< number of pairs of voxels
    };
    Cubes::Cube cube = {};
    std::vector<Index> voxels;
    std::vector<Contact> contacts;
    bool isUsed = true;
    bool isAdded = false;  ///< it holds no voxels of the model
    int joins = 0;
};

struct FoundParts {
    std::vector<CubePart> parts;  ///< in the order of the numbers of their cubes
    std::vector<Index> partOf;    ///< the part of each voxel of the model, by its rank
};

/// Finds the connected parts of a model in each cube. Two parts have a contact where the model
/// passes through the face between their cubes.
/// \param joinDistance parts in one cube, or in two neighbours, that are at most this far apart are
///        one part, or in contact; in voxels
FoundParts findParts(const ModelVoxels& voxels, const Cubes& cubes, double joinDistance);

}  // namespace espalier::cages
