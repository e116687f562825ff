// SPDX-License-Identifier: Apache-2.0
#include "cell_corners.h"

#include <algorithm>

namespace espalier::far {
namespace {

/// Where an ascending row has a value that is in it.
std::size_t placeIn(std::span<const Index> row, Index value) {
    // Short rows are counted through without a branch: 12 edges and 8 vertices in a hexahedron.
    constexpr std::size_t kShort = 16;
    if (row.size() > kShort)
        return static_cast<std::size_t>(std::lower_bound(row.begin(), row.end(), value) -
                                        row.begin());
    std::size_t less = 0;
    for (const Index other : row) less += other < value;
    return less;
}

}  // namespace

CellCorners::CellCorners(const CellComplex& lattice)
    : cellFaces_(lattice.boundary(3)),
      faceEdges_(lattice.boundary(2)),
      faceVertices_(lattice.relation(2, 0)),
      cellVertices_(lattice.relation(3, 0)),
      cellEdges_(lattice.relation(3, 1)) {}

void CellCorners::visit(Index cell) {
    const auto vertices = cellVertices_[cell], edges = cellEdges_[cell], faces = cellFaces_[cell];
    const auto faceSigns = cellFaces_.signs(cell);
    const Offset firstFace = cellFaces_.unsignedRows().offset(cell);
    const Offset firstEdge = cellEdges_.offset(cell);
    firstVertex_ = cellVertices_.offset(cell);
    vertexCount_ = vertices.size();
    edges_.resize(edges.size());
    facesSeen_.assign(edges.size(), 0);
    if (corners_.size() < vertexCount_) corners_.resize(vertexCount_);
    for (std::size_t v = 0; v < vertexCount_; ++v) {
        corners_[v].faces.clear();
        corners_[v].edges.clear();
    }

    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto loopEdges = faceEdges_[faces[f]], loop = faceVertices_[faces[f]];
        const auto signs = faceEdges_.signs(faces[f]);
        const Offset first = faceVertices_.offset(faces[f]);
        loop_.clear();
        for (const Index vertex : loop) loop_.push_back(placeIn(vertices, vertex));
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Offset position = first + static_cast<Offset>(i);
            corners_[loop_[i]].faces.push_back({position, faceSigns[f]});
            const std::size_t e = placeIn(edges, loopEdges[i]);
            Edge& edge = edges_[e];
            // A cell of a valid lattice has each of its edges in two of its faces.
            if (facesSeen_[e] == 2) continue;
            edge.faces[facesSeen_[e]++] = {position, firstFace + static_cast<Offset>(f), signs[i],
                                           faceSigns[f]};
            const std::size_t next = loop_[i + 1 < loop.size() ? i + 1 : 0];
            edge.ends = {signs[i] > 0 ? loop_[i] : next, signs[i] > 0 ? next : loop_[i]};
        }
    }
    for (std::size_t e = 0; e < edges.size(); ++e) {
        edges_[e].inCell = firstEdge + static_cast<Offset>(e);
        corners_[edges_[e].ends[0]].edges.push_back({edges_[e].inCell, -1});
        corners_[edges_[e].ends[1]].edges.push_back({edges_[e].inCell, 1});
    }
}

}  // namespace espalier::far
