// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/topology_refiner.h>

#include <vector>

namespace espalier::far {

/// What is around a vertex of a level, as a level of its own.
struct Star {
    Level level;
    Index vertex = 0;          ///< the vertex, in that level
    ByEntity<Index> entities;  ///< of each entity there, which one it is in the level it was taken
                               ///< from; ascending
};

/// Takes the star of a vertex out of a level: what contains the vertex, and all that this contains.
/// Their order, loops, directions, strata and sharpness stay. With two rings, what contains a
/// vertex of that as well.
///
/// A chain of levels that goes on from there (TopologyRefiner) is, around the vertex, that of the
/// level itself: the same rows for the new points of what contains the vertex, level after level.
/// (With Creasing::Chaikin and semi-sharp edges, from two rings: how an edge fades depends on the
/// edges at both its ends.) Further out neighbours are missing.
///
/// \param level of any origin; holes are left out
/// \param vertex of it
/// \param rings 1 or 2
/// \throws Error if there is no such vertex
/// \cost O(n log n) in the entries of the star
ESPALIER_API Star starOf(const Level& level, Index vertex, int rings = 1);

}  // namespace espalier::far
