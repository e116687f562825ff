// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/topology_refiner.h>
#include <espalier/stencils/stencil_table.h>

#include <span>

// The directions in which the limit goes on from a vertex.
namespace espalier::limit {

/// A cell and one of its vertices.
struct CellCorner {
    Index cell = 0;
    Index vertex = 0;
};

/// Rows 3i to 3i + 2 give three directions in the limit at corners[i], over the vertices of the
/// level: those in which three edges of the cell leave the vertex, level after level. Rows sum to
/// 0. Their lengths and their order mean nothing; the space that they span does. With T the rows, X
/// the rest pose and x another one, the gradient F = ∂x/∂X at the corner has Fᵀ = (T X)⁻¹ T x.
///
/// Each level shrinks all edges, some more slowly than others. The rows are bases of the space that
/// the edges' rows tend to, found by orthogonal iteration with the matrix of the vertex's ring.
///
/// \param corners vertices are not open; all that contains them must be there
/// \throws Error as ringOf()
/// \cost O(entries of the ring's matrix), some hundred times, once for each shape of ring and
/// corner
///       in it. In parallel
/// \cite Halstead, Kass, DeRose 1993 (limits by eigenvectors); Reif 1995 (when tangents exist)
stencils::StencilTable<double> buildTangentTable(const far::TopologyRefiner& refiner, int level,
                                                 std::span<const CellCorner> corners);

}  // namespace espalier::limit
