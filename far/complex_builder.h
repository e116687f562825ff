// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/standard_cells.h>
#include <espalier/far/topology_error.h>

#include <initializer_list>
#include <vector>

namespace espalier::far {

/// Builds a CellComplex from vertices, cell by cell.
///
/// Cells that name the same vertices in a face share that face, whatever the start and direction of
/// the loop; faces share edges in the same way. This is how a new cell is attached to existing
/// ones. Cells are oriented coherently: in each connected piece, the direction in which the
/// majority of the given loops run counts as anticlockwise seen from outside.
///
/// Entities are numbered in the order of their first appearance. Add cells to a builder of
/// dimension 3, faces to dimension 2, and edges to dimension 1.
class ESPALIER_API ComplexBuilder {
public:
    /// \param dimension of the complex: 1, 2 or 3
    /// \param vertexCount vertices 0 to vertexCount − 1 exist from the start
    explicit ComplexBuilder(int dimension, Index vertexCount = 0);

    /// Allocates memory for loops that will be added; optional.
    /// \param cornerCount number of vertices of all loops
    void reserve(std::size_t cornerCount) { corners_.reserve(cornerCount); }

    /// Adds one vertex and returns its number.
    Index addVertex() { return vertexCount_++; }

    /// Adds a polyhedron bounded by the given loops of vertices. Returns its number.
    /// \throws TopologyError if a loop has fewer than three vertices, names a vertex twice, or
    ///         names a vertex that does not exist, or if dimension is not 3; the builder is then
    ///         unchanged
    Index addCell(std::span<const std::vector<Index>> loops);

    /// Adds a tetrahedron, pyramid, wedge or hexahedron. Returns its number.
    /// \throws TopologyError (TooFewVertices) if the number of `vertices` is not vertexCount(cell)
    Index addCell(StandardCell kind, std::span<const Index> vertices);
    Index addCell(StandardCell kind, std::initializer_list<Index> vertices) {
        return addCell(kind, std::span(vertices.begin(), vertices.size()));
    }

    /// Adds a face of a mesh and keeps its direction. Returns its number. Throws as addCell(), but
    /// a loop may name a vertex more than once, as degenerate faces in files do. A step from a
    /// vertex to itself, or between two vertices that the loop has joined before, then becomes a
    /// separate edge (as in OpenSubdiv).
    Index addFace(std::span<const Index> loop);
    Index addFace(std::initializer_list<Index> loop) {
        return addFace(std::span(loop.begin(), loop.size()));
    }

    /// Adds an edge of a curve. Returns its number. Throws as addCell().
    Index addEdge(Index tail, Index head);

    /// Removes the vertices that no cell, face or edge names, and renumbers the others in their
    /// order. Returns the old numbers of the removed vertices, ascending.
    /// \cost O(n) in the number of entries
    std::vector<Index> dropUnusedVertices();

    /// Returns the complex, validated.
    /// \throws TopologyError that names the first offender
    /// \cost O(n) on average in the number of entries
    CellComplex build() const;

private:
    void checkDimension(int dimension) const;
    void checkLoop(std::span<const Index> loop, std::size_t least, Entity entity) const;
    void appendLoop(std::span<const Index> loop);

    int dimension_;
    Index vertexCount_;
    // All loops as given, one after the other; an edge is a loop of two vertices.
    Array<Index> corners_;  ///< the vertices of all loops
    RowStarts loops_;       ///< the vertices of each loop
    RowStarts cells_;       ///< the loops of each cell
};

/// Builds a curve through vertices 0 to vertexCount − 1 in order.
/// \param closed whether an edge joins the last vertex to the first
ESPALIER_API CellComplex buildCurve(Index vertexCount, bool closed);

/// Builds a mesh of faces given by loops of vertices.
ESPALIER_API CellComplex buildMesh(Index vertexCount, std::span<const std::vector<Index>> loops);

}  // namespace espalier::far
