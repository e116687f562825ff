// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/topology_refiner.h>

#include <vector>

namespace espalier::far {

/// The neighbourhood of a vertex of a level, as a level of its own.
struct Star {
    Level level;
    Index vertex = 0;          ///< the vertex, in that level
    ByEntity<Index> entities;  ///< for each entity of the star, its number in the original level;
                               ///< ascending
};

/// Extracts the star of a vertex from a level: the entities that contain the vertex, and all
/// entities that these contain. The order, loops, directions, strata and sharpness are kept. With
/// two rings, the star also has the entities that contain any vertex of the first ring, and their
/// parts.
///
/// Refining the star (TopologyRefiner) gives the same result around the vertex as refining the
/// level itself: on every level, the new points of the entities that contain the vertex have the
/// same rows. (With Creasing::Chaikin and semi-sharp edges, this needs two rings: how an edge fades
/// depends on the edges at both of its ends.) Farther out, neighbours are missing.
///
/// \param level of any origin; holes are not copied
/// \param vertex of `level`
/// \param rings 1 or 2
/// \throws Error if there is no such vertex
/// \cost O(n log n) in the entries of the star
ESPALIER_API Star starOf(const Level& level, Index vertex, int rings = 1);

}  // namespace espalier::far
