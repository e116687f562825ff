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
    std::vector<Index> vertices;  ///< vertices of the faces, ascending
    std::vector<Index> edges;     ///< edges of the faces, ascending
    std::vector<Index> faces;     ///< ascending
};

/// Returns the surface of a complex.
/// \throws Error if the complex is a curve
Surface surfaceOf(const far::CellComplex& complex);

/// True if the loop of a face on the boundary of a lattice is clockwise, seen from outside. False
/// on a mesh.
bool isWoundInward(const far::CellComplex& complex, Index face);

/// Returns the vertices of a face of the surface in order: in the order of the mesh, or
/// anticlockwise seen from outside of a lattice.
std::vector<Index> surfaceLoop(const far::CellComplex& complex, Index face);

/// The match of a level with OpenSubdiv's level: for each of our entities of dimension 0, 1 and 2,
/// the number of its counterpart in OpenSubdiv, if there is one. Entities inside a lattice have
/// none.
struct LevelMatch {
    std::array<std::vector<std::optional<Index>>, 3> numbers;

    std::optional<Index> of(Entity entity) const { return numbers[entity.dimension][entity.index]; }
};

/// Matches level 0, where OpenSubdiv's vertex i is surface.vertices[i], and its face i is
/// surface.faces[i].
LevelMatch matchBase(const far::CellComplex& complex, const Surface& surface,
                     const OpenSubdiv::Far::TopologyLevel& openSubdiv);

/// Matches the next level, through the parent and child maps of both sides. The child at a corner
/// or side of an edge or face is matched with the child at the same corner or side of its
/// counterpart.
LevelMatch matchChildren(const far::CellComplex& parent, const LevelMatch& match,
                         const far::Refinement& refinement,
                         const OpenSubdiv::Far::TopologyLevel& openSubdivParent);

/// Returns the part of a level that is compared. This is the whole surface under boundary control.
/// Under Boundary::Open, OpenSubdiv omits faces that shrink away, and the part has the faces that
/// OpenSubdiv keeps, with their vertices and edges. The numbers are our numbers, ascending.
Surface comparedRegion(const far::TopologyRefiner& refiner, int level, const LevelMatch& match,
                       const OpenSubdiv::Far::TopologyLevel& openSubdiv);

/// Returns the numbers of vertices, edges and faces of OpenSubdiv in the compared part.
std::array<Index, 3> countOpenSubdiv(far::Boundary boundary,
                                     const OpenSubdiv::Far::TopologyLevel& openSubdiv);

/// Describes the first difference between the region and its match: an entity without a match, or
/// with the match of another entity; an edge or a face with other vertices, or with its vertices in
/// another order; or a difference in sharpness (beyond rounding), in the rule of a vertex, or in a
/// hole. Returns an empty text if there is no difference.
std::string describeDifference(const far::TopologyRefiner& refiner, int level,
                               const Surface& region, const LevelMatch& match,
                               const OpenSubdiv::Far::TopologyLevel& openSubdiv);

}  // namespace espalier::compare
