// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::far {

/// What meets at the edges and the vertices of one cell of a lattice after the other. Pairs of
/// incident entities are named by their positions in the values of the relations.
class CellCorners {
public:
    /// \param lattice must outlive this
    explicit CellCorners(const CellComplex& lattice);

    /// One of the two faces at an edge.
    struct EdgeFace {
        Offset edgeInFace = 0;       ///< in face → edges
        Offset inCell = 0;           ///< of the face, in cell → faces
        std::int8_t edgeSign = 0;    ///< of the edge in the boundary of the face
        std::int8_t inCellSign = 0;  ///< of the face in that of the cell
    };
    struct Edge {
        Offset inCell = 0;  ///< in cell → edges
        std::array<EdgeFace, 2> faces;
        std::array<std::size_t, 2> ends = {};  ///< tail and head among the vertices of the cell
    };
    struct VertexFace {
        Offset vertexInFace = 0;  ///< in face → vertices
        std::int8_t inCellSign = 0;
    };
    struct VertexEdge {
        Offset inCell = 0;           ///< in cell → edges
        std::int8_t vertexSign = 0;  ///< −1 where the vertex is the tail
    };

    /// Goes to a cell. \cost O(n log n) in its faces
    void visit(Index cell);

    /// In the order of cell → edges.
    std::span<const Edge> edges() const { return edges_; }

    std::size_t vertexCount() const { return vertexCount_; }

    /// Position of vertex `v` of the cell in cell → vertices.
    Offset vertexInCell(std::size_t v) const { return firstVertex_ + static_cast<Offset>(v); }

    /// The faces at it, in the order of cell → faces, and the edges, in that of cell → edges.
    std::span<const VertexFace> facesAt(std::size_t v) const { return corners_[v].faces; }
    std::span<const VertexEdge> edgesAt(std::size_t v) const { return corners_[v].edges; }

private:
    struct Corner {
        std::vector<VertexFace> faces;
        std::vector<VertexEdge> edges;
    };

    const SignedIncidence& cellFaces_;
    const SignedIncidence& faceEdges_;
    const Incidence& faceVertices_;
    const Incidence& cellVertices_;
    const Incidence& cellEdges_;

    std::vector<Edge> edges_;
    std::vector<std::uint8_t> facesSeen_;  ///< of each edge
    std::size_t vertexCount_ = 0;
    Offset firstVertex_ = 0;
    std::vector<Corner> corners_;  ///< as many as any cell so far has had vertices
    std::vector<std::size_t> loop_;
};

}  // namespace espalier::far
