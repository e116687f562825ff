// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/far/incidence.h>
#include <espalier/far/topology_error.h>

#include <array>
#include <memory>
#include <span>

namespace espalier::far {

/// The topology of a curve (dimension 1), a mesh (2) or a lattice (3): vertices, edges, faces and
/// cells, and which bounds which. No positions.
///
/// Stored relations, each with the incidence numbers of the boundary operator ∂ (±1):
///
///     boundary(1)   edge → its 2 vertices   tail (−1), then head (+1)
///     boundary(2)   face → its edges        in loop order; +1 where the loop runs tail to head
///     boundary(3)   cell → its faces        +1 where the loop is anticlockwise from outside
///
/// They satisfy ∂∂ = 0, and a face between two cells has opposite signs in them. Every other
/// relation is derived on first use and kept.
///
/// A value: copies share the same immutable data, and any number of threads may read it.
///
/// \cite MacCracken & Joy 1996, section 2 (lattice) and 6 (data structure)
class ESPALIER_API CellComplex {
public:
    using Boundaries = std::array<SignedIncidence, kMaxDimension>;

    /// The empty complex: dimension 0, no entities.
    CellComplex();

    /// Takes relations that already satisfy the contract above; validate() checks them.
    /// To build a complex from loops and cells, use ComplexBuilder.
    ///
    /// \param boundaries entry d − 1 is boundary(d); those above `dimension` are empty
    CellComplex(int dimension, Index vertexCount, Boundaries boundaries);

    /// 1 curve, 2 mesh, 3 lattice.
    int dimension() const;

    /// Number of entities of a dimension; 0 above dimension().
    Index count(int dimension) const;

    /// Number of vertices − edges + faces − cells.
    Index eulerCharacteristic() const;

    /// \param dimension 1, 2 or 3
    const SignedIncidence& boundary(int dimension) const;

    /// Which entities of dimension `to` contain, or are contained in, each entity of dimension
    /// `from`. Rows are ascending, except face → edges and face → vertices, which are in loop
    /// order (edge i joins vertices i and i + 1), edge → vertices (tail, head) and cell → faces
    /// (as given).
    ///
    /// An entity contains itself: where the dimensions are the same, its row is itself. Where a
    /// face or an edge of a mesh passes a vertex more than once, both rows name the other as often.
    ///
    /// \param from, to dimensions, 0 to dimension()
    /// \cost O(entries) on the first call for a pair, then constant; thread-safe
    const Incidence& relation(int from, int to) const;

    // Typed rows of relation().
    IdSpan<0> vertices(EdgeId edge) const { return IdSpan<0>(relation(1, 0)[edge.value]); }
    IdSpan<0> vertices(FaceId face) const { return IdSpan<0>(relation(2, 0)[face.value]); }
    IdSpan<0> vertices(CellId cell) const { return IdSpan<0>(relation(3, 0)[cell.value]); }
    IdSpan<1> edges(FaceId face) const { return IdSpan<1>(relation(2, 1)[face.value]); }
    IdSpan<1> edges(CellId cell) const { return IdSpan<1>(relation(3, 1)[cell.value]); }
    IdSpan<2> faces(CellId cell) const { return IdSpan<2>(relation(3, 2)[cell.value]); }
    IdSpan<3> cells(FaceId face) const { return IdSpan<3>(relation(2, 3)[face.value]); }

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

/// Checks every property that refinement relies on, in a complex of any origin and level.
///
/// For a lattice: each face is a loop of at least three different vertices; each cell is bounded by
/// a sphere (each of its edges in two of its faces, one fan of faces at each vertex, connected,
/// Euler characteristic 2) and differs from every other cell; each face bounds one or two cells,
/// with opposite signs if two; every vertex, edge and face bounds something. Separate pieces, and
/// pieces that meet in a vertex or an edge only, are fine. For a curve the same, as far as it
/// applies. A mesh is taken as it comes, as OpenSubdiv does: an edge may have any number of faces,
/// with any signs; a face of three or more corners may pass a vertex more than once, and an edge
/// may join a vertex to itself; a vertex may belong to nothing.
///
/// \throws TopologyError naming the first offender
/// \cost O(entries), in parallel
ESPALIER_API void validate(const CellComplex& complex);

}  // namespace espalier::far
