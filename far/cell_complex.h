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
/// cells, and their incidences. It has no positions.
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
/// Has value semantics: copies share the same immutable data, and any number of threads may read
/// it.
///
/// \cite MacCracken & Joy 1996, section 2 (lattice) and 6 (data structure)
class ESPALIER_API CellComplex {
public:
    using Boundaries = std::array<SignedIncidence, kMaxDimension>;

    /// Creates an empty complex: dimension 0, no entities.
    CellComplex();

    /// Takes relations that already satisfy the contract above; validate() checks it. To build a
    /// complex from loops and cells, use ComplexBuilder.
    ///
    /// \param boundaries entry d − 1 is boundary(d); entries above `dimension` are empty
    CellComplex(int dimension, Index vertexCount, Boundaries boundaries);

    /// Takes the relations of the child that a Refinement makes. The complex equals the complex
    /// that the constructor makes of the same relations, but derives further relations faster. The
    /// relations must have the order that isRefined() states; it is not checked.
    static CellComplex refined(int dimension, Index vertexCount, Boundaries boundaries);

    /// Returns true for a complex that refined() made. Its faces are quadrilaterals. In a
    /// lattice, a cell [v, c] of type n has 2n faces: first n faces [v, f], then n faces [e, c].
    /// The first and the last vertex of the cell have n edges in it, all other vertices three.
    bool isRefined() const;

    /// Returns 1 for a curve, 2 for a mesh, 3 for a lattice.
    int dimension() const;

    /// Returns the number of entities of a dimension; 0 above dimension().
    Index count(int dimension) const;

    /// Returns the number of vertices − edges + faces − cells.
    Index eulerCharacteristic() const;

    /// \param dimension 1, 2 or 3
    const SignedIncidence& boundary(int dimension) const;

    /// Returns, for each entity of dimension `from`, the entities of dimension `to` that contain it
    /// or are contained in it. Rows are ascending, except face → edges and face → vertices, which
    /// are in loop order (edge i joins vertices i and i + 1), edge → vertices (tail, head) and cell
    /// → faces (as given).
    ///
    /// An entity contains itself: if the dimensions are equal, each row contains its own entity. If
    /// a face or an edge of a mesh passes a vertex several times, its row lists the vertex once for
    /// each pass, and so does the row of the vertex for the face or edge.
    ///
    /// \param from, to dimensions, 0 to dimension()
    /// \cost O(entries) on the first call for a pair, then constant; thread-safe
    const Incidence& relation(int from, int to) const;

    // The rows of relation(), typed.
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

/// Checks every property that refinement relies on. Works for a complex of any origin and level.
///
/// A lattice must satisfy: each face is a loop of at least three different vertices; each cell is
/// bounded by a sphere (each of its edges is in two of its faces, its faces at each vertex form one
/// fan, it is connected, and its Euler characteristic is 2) and differs from every other cell; each
/// face bounds one cell, or two cells with opposite signs; every vertex, edge and face bounds
/// something. Separate pieces are allowed, and so are pieces that meet in a vertex or an edge only.
/// The same holds for a curve, as far as it applies. A mesh is accepted as OpenSubdiv accepts it:
/// an edge may have any number of faces, with any signs; a face of three or more corners may pass a
/// vertex more than once, and an edge may join a vertex to itself; a vertex may belong to nothing.
///
/// \throws TopologyError that names the first offender
/// \cost O(entries), in parallel
ESPALIER_API void validate(const CellComplex& complex);

}  // namespace espalier::far
