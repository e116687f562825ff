// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/topology_refiner.h>

#include <span>
#include <vector>

namespace espalier::far {

/// The neighbourhood of some vertices of a level, as a level of its own.
struct Star {
    Level level;
    ByEntity<Index> entities;  ///< numbers in the original level of the entities of the star,
                               ///< ascending
};

/// Extracts the star of some vertices from a level: the entities that contain one of the vertices,
/// and all entities that these contain. The order, loops, directions, strata and sharpness are
/// kept. With two rings, the star also has the entities that contain any vertex of the first ring,
/// and their parts.
///
/// Refining the star (TopologyRefiner) gives the same result around the vertices as refining the
/// level itself: on every level, the new points of the entities that contain one of the vertices
/// have the same rows. (With Creasing::Chaikin and semi-sharp edges, this needs two rings: see
/// ringsAround().) Farther out, neighbours are missing.
///
/// \param level of any origin; holes are not copied
/// \param vertices of `level`, in any order
/// \param rings 1 or 2
/// \throws Error if there is no such vertex
/// \cost O(n log n) in the entries of the star
ESPALIER_API Star starOf(const Level& level, std::span<const Index> vertices, int rings = 1);

/// Returns the number of rings of a star that refinement around its vertices depends on: 2 with
/// Creasing::Chaikin and semi-sharp edges, because the fading of an edge depends on the edges at
/// both of its ends; 1 otherwise.
ESPALIER_API int ringsAround(const Level& level, Creasing creasing);

}  // namespace espalier::far
