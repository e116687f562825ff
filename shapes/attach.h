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
/// Builds a lattice cell by cell, face to face (MacCracken & Joy 1996, section 5).
///
/// Each function returns the lattice with one more cell, which is the last. Old vertices and cells
/// keep their numbers, positions, attributes and marks; new vertices follow them. Edges and faces
/// are numbered in the order of first appearance, as in ComplexBuilder: a lattice that
/// ComplexBuilder built from outward loops keeps these numbers too.
///
/// New vertices are never welded to old ones, even in the same place; merge() of the single lattice
/// welds them. Each call costs O(n log n) in the size of the lattice.
namespace espalier::shapes {

/// Attaches a prism to a face. Its new vertices are copies of the face's vertices, moved by an
/// offset, in the order of the face's loop, with the same attributes and integers. The faces of the
/// new cell are: the given face, the opposite face, then one face per edge, in loop order.
///
/// \param face a boundary face
/// \param offset vector to the outside of the lattice
/// \throws Error if the face does not exist, is between two cells, or the offset points inwards or
///         along the face
ESPALIER_API Lattice attachPrism(const Lattice& lattice, FaceId face, const Point3& offset);

/// Attaches a pyramid to a face; on a triangle, a tetrahedron. The apex gets the mean of the
/// attributes of the face's vertices, and no integers (noInteger()). The faces of the new cell are:
/// the given face, then one face per edge.
///
/// \param apex a new vertex, outside the lattice
/// \throws Error as attachPrism does
ESPALIER_API Lattice attachPyramid(const Lattice& lattice, FaceId face, const Point3& apex);

/// A new vertex of a new cell.
struct NewVertex {
    Point3 position = {0, 0, 0};
    /// The new vertex gets the mean attributes of these vertices; if there are none, 0. From a
    /// single vertex it also gets the integers; otherwise its integers are noInteger().
    std::vector<Index> attributesFrom = {};
};

/// Adds any polyhedron, face to face with the lattice or apart from it.
///
/// \param loops faces of the polyhedron, anticlockwise from outside; the numbers of new vertices
///        follow the old ones
/// \throws Error for an attribute source that does not exist; far::TopologyError for a cell that
///         does not fit: if a face would have three cells, or a new vertex is not used
ESPALIER_API Lattice attachCell(const Lattice& lattice, std::span<const std::vector<Index>> loops,
                                std::span<const NewVertex> newVertices);

/// The same for a tetrahedron, pyramid, wedge or hexahedron.
ESPALIER_API Lattice attachCell(const Lattice& lattice, far::StandardCell cell,
                                std::span<const Index> vertices,
                                std::span<const NewVertex> newVertices);

}  // namespace espalier::shapes
