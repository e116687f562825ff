// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/far/complex_builder.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>

#include <span>
#include <vector>

/// \file
/// Building a lattice cell by cell, face to face (MacCracken & Joy 1996, section 5).
///
/// Each function returns the lattice with one more cell, which is the last. Vertices and cells that
/// were there keep their numbers, positions, attributes and marks; new vertices follow them. Edges
/// and faces are numbered in the order of first appearance, as ComplexBuilder does: a lattice that
/// was built by it, outward loops first, keeps those numbers too.
///
/// New vertices coincide with no old one, even in the same place; merge() of the one lattice welds
/// them. Each call costs O(n log n) in the size of the lattice.
namespace espalier::shapes {

/// Puts a prism on a face: its vertices, and as many new ones moved by an offset, in the order of
/// the face's loop. Their attributes and integers are those of the vertices they come from. The
/// faces of the new cell are: the one it stands on, the one opposite, then one an edge, in loop
/// order.
///
/// \param face a boundary face
/// \param offset to the outside of the lattice
/// \throws Error if the face does not exist, is between two cells, or the offset points inwards or
///         along the face
ESPALIER_API Lattice attachPrism(const Lattice& lattice, FaceId face, const Point3& offset);

/// Puts a pyramid on a face: a tetrahedron on a triangle. The attributes of the apex are the mean
/// of those of the face; it has no integers (noInteger()). The faces of the new cell are: the one
/// it stands on, then one an edge.
///
/// \param apex a new vertex, outside the lattice
/// \throws Error as attachPrism does
ESPALIER_API Lattice attachPyramid(const Lattice& lattice, FaceId face, const Point3& apex);

/// A vertex that comes with a new cell.
struct NewVertex {
    Point3 position = {0, 0, 0};
    /// Vertices whose mean attributes it takes; with none, its attributes are 0. It takes the
    /// integers of one vertex; with none, or more than one, it has noInteger().
    std::vector<Index> attributesFrom = {};
};

/// Adds any polyhedron, face to face with the lattice or apart from it.
///
/// \param loops of its faces, anticlockwise from outside; the new vertices are numbered on from the
///              old ones
/// \throws Error for an attribute source that does not exist; far::TopologyError for a cell that
///         does not fit: a face that then has three cells, a new vertex that is not used
ESPALIER_API Lattice attachCell(const Lattice& lattice, std::span<const std::vector<Index>> loops,
                                std::span<const NewVertex> newVertices);

/// The same with a tetrahedron, pyramid, wedge or hexahedron.
ESPALIER_API Lattice attachCell(const Lattice& lattice, far::StandardCell cell,
                                std::span<const Index> vertices,
                                std::span<const NewVertex> newVertices);

}  // namespace espalier::shapes
