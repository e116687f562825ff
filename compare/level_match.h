// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>

#include <opensubdiv/far/topologyRefiner.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace espalier::compare {

/// The surface of a complex: all of a mesh, or the boundary of a lattice.
struct Surface {
    std::vector<Index> vertices;  ///< those in one of the faces, ascending
    std::vector<Index> edges;     ///< likewise
    std::vector<Index> faces;     ///< ascending
};

/// \throws Error if the complex is a curve
Surface surfaceOf(const far::CellComplex& complex);

/// Whether the loop of a face on the boundary of a lattice runs clockwise, seen from outside. Never
/// on a mesh.
bool isWoundInward(const far::CellComplex& complex, Index face);

/// The vertices of a face of the surface in order: as a mesh winds it, or anticlockwise from
/// outside of a lattice.
std::vector<Index> surfaceLoop(const far::CellComplex& complex, Index face);

/// Which entity of OpenSubdiv's level stands for which of ours: for each of our entities of
/// dimension 0, 1 and 2 its number there, if it has one. Entities inside a lattice have none.
struct LevelMatch {
    std::array<std::vector<std::optional<Index>>, 3> theirs;

    std::optional<Index> of(Entity entity) const { return theirs[entity.dimension][entity.index]; }
};

/// The match of level 0, where the vertices and faces of OpenSubdiv are those of `surface` in
/// order.
LevelMatch matchBase(const far::CellComplex& complex, const Surface& surface,
                     const OpenSubdiv::Far::TopologyLevel& theirs);

/// The match of the next level, through the parent and child maps of both sides: the child at a
/// corner or a side of an edge or face is matched with the child at the same corner or side of its
/// match.
LevelMatch matchChildren(const far::CellComplex& parent, const LevelMatch& match,
                         const far::Refinement& refinement,
                         const OpenSubdiv::Far::TopologyLevel& theirParent);

/// The part of a level that is compared: all of the surface; or, where OpenSubdiv leaves out the
/// faces that shrink away without boundary control, the faces that it keeps and what is in them.
/// Numbers are ours, ascending.
Surface comparedRegion(const far::TopologyRefiner& refiner, int level, const LevelMatch& match,
                       const OpenSubdiv::Far::TopologyLevel& theirs);

/// How many vertices, edges and faces OpenSubdiv has in that region.
std::array<Index, 3> countTheirs(far::Boundary boundary,
                                 const OpenSubdiv::Far::TopologyLevel& theirs);

/// The first difference between the region and its match, in words: an entity without a match or
/// with the match of another; edges and faces that do not have the same vertices, in the same
/// order; sharpness (but for its rounding), rules of vertices, and holes. Empty if there is none.
std::string describeDifference(const far::TopologyRefiner& refiner, int level,
                               const Surface& region, const LevelMatch& match,
                               const OpenSubdiv::Far::TopologyLevel& theirs);

}  // namespace espalier::compare
