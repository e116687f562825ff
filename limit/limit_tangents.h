// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <span>

// Directions of the limit at a vertex.
namespace espalier::limit {

/// A cell and one of its vertices.
struct CellCorner {
    Index cell = 0;
    Index vertex = 0;
};

/// Builds the directions of the limit at corners of cells, over the vertices of the level. Rows 3i
/// to 3i + 2 belong to corners[i]: they are the directions that three edges of the cell at the
/// vertex converge to, level after level. Rows sum to 0. Only the space that the three rows span
/// has a meaning, not their lengths or order. With T the rows, X the rest pose and x another pose,
/// the gradient F = ∂x/∂X at the corner satisfies Fᵀ = (T X)⁻¹ T x.
///
/// Each level shrinks all edges, some more slowly than others. The rows are a basis of the space
/// that the rows of the edges converge to. Orthogonal iteration with the matrix of the vertex's
/// ring finds the basis.
///
/// \param corners their vertices are not open; the level has all entities that contain a vertex
/// \throws Error as ringOf()
/// \cost O(entries of the ring's matrix), some hundred times for each distinct shape of ring and
///       each corner in it. In parallel
/// \cite Halstead, Kass, DeRose 1993 (limits by eigenvectors); Reif 1995 (when tangents exist)
stencils::StencilTable<double> buildTangentTable(const far::TopologyRefiner& refiner, int level,
                                                 std::span<const CellCorner> corners);

}  // namespace espalier::limit
