// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/standard_cells.h>
#include <espalier/far/topology_error.h>

#include <initializer_list>
#include <vector>

namespace espalier::far {

/// Makes a CellComplex from vertices, cell by cell.
///
/// Cells that name the same vertices in a face share that face, wherever they start the loop and
/// whichever way they wind it, and faces share edges likewise; this is how a new cell is attached
/// to those that are there. Cells are oriented coherently: in each connected piece the way the
/// larger number of the given loops winds counts as anticlockwise from outside.
///
/// Entities are numbered in the order of their first appearance. Dimension 3 takes cells, 2 faces
/// and 1 edges.
class ESPALIER_API ComplexBuilder {
public:
    /// \param dimension 1, 2 or 3: what is being built
    /// \param vertexCount vertices 0 to vertexCount − 1 exist from the start
    explicit ComplexBuilder(int dimension, Index vertexCount = 0);

    /// Adds one vertex and returns its number.
    Index addVertex() { return vertexCount_++; }

    /// Adds a polyhedron bounded by the given loops of vertices. Returns its number.
    /// \throws TopologyError if a loop has under three vertices, names one twice, or one that does
    ///         not exist, or if this is not being built; the builder is then as it was before
    Index addCell(std::span<const std::vector<Index>> loops);

    /// Adds a tetrahedron, pyramid, wedge or hexahedron. Returns its number.
    /// \throws TopologyError (TooFewVertices) if `vertices` is not vertexCount(cell) long
    Index addCell(StandardCell cell, std::span<const Index> vertices);
    Index addCell(StandardCell cell, std::initializer_list<Index> vertices) {
        return addCell(cell, std::span(vertices.begin(), vertices.size()));
    }

    /// Adds a face of a mesh. Its winding is kept. Returns its number. Throws as addCell does, but
    /// a loop may name a vertex more than once, as degenerate faces in files do; each step from a
    /// vertex to itself, or between two that the loop has joined before, is then an edge of its own
    /// (as in OpenSubdiv).
    Index addFace(std::span<const Index> loop);
    Index addFace(std::initializer_list<Index> loop) {
        return addFace(std::span(loop.begin(), loop.size()));
    }

    /// Adds an edge of a curve. Returns its number. Throws as addCell does.
    Index addEdge(Index tail, Index head);

    /// Drops the vertices that no cell, face or edge names, and numbers the others anew in their
    /// order. Returns the numbers that the dropped vertices had, ascending.
    /// \cost O(n) in the number of entries
    std::vector<Index> dropUnusedVertices();

    /// The complex, validated.
    /// \throws TopologyError naming the first offender
    /// \cost O(n log n) in the number of entries
    CellComplex build() const;

private:
    void checkDimension(int dimension) const;
    void checkLoop(std::span<const Index> loop, std::size_t least, Entity entity) const;
    void appendLoop(std::span<const Index> loop);

    int dimension_;
    Index vertexCount_;
    Rows<Index> loops_;                      ///< every loop as given; an edge is a loop of two
    std::vector<Offset> cellOffsets_ = {0};  ///< cell c has loops cellOffsets_[c] to [c + 1]
};

/// A curve through vertices 0 to vertexCount − 1 in order, closed or not.
ESPALIER_API CellComplex buildCurve(Index vertexCount, bool closed);

/// A mesh of faces given by loops of vertices.
ESPALIER_API CellComplex buildMesh(Index vertexCount, std::span<const std::vector<Index>> loops);

}  // namespace espalier::far
