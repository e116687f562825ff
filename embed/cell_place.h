// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>

#include <array>
#include <vector>

namespace espalier::embed {

/// A place in a cell of a refined lattice.
///
/// In a hexahedron (type-3 cell), (u, v, w) in [0, 1]³ of the trilinear map of its corners. In a
/// type-n cell, (u, v, w) in one of its 4n tetrahedra: P₀ + u(P₁ − P₀) + v(P₂ − P₀) + w(P₃ − P₀),
/// with P₀ the average of the cell's vertices and P₁P₂P₃ half a face, cut from the first to the
/// third vertex of its loop (a choice that depends on the refinement alone, not on numbering).
///
/// `offset`, in the same coordinates, goes on from there along the tangent of the map: the place of
/// a point that is not in the cell. It is 0 for points inside.
///
/// \cite MacCracken & Joy 1996, sections 4 to 6, Figure 6
struct CellPlace {
    CellId cell;
    Index tetrahedron = 0;  ///< 2·face + half, faces in the order of the cell; 0 in a hexahedron
    std::array<double, 3> uvw = {};
    std::array<double, 3> offset = {};
};

/// One vertex and its share in a position.
struct VertexWeight {
    Index vertex = 0;
    double weight = 0;
};

/// The position of a place as weights of the vertices of `complex`: 8 in a hexahedron; in a type-n
/// cell all 2n + 2, of which those beside the three of the tetrahedron have their share of P₀ only.
/// They sum to 1, and are between 0 and 1 where the offset is 0. A vertex may come twice.
///
/// \param complex a refined lattice: level 1 or above
ESPALIER_API std::vector<VertexWeight> placeWeights(const far::CellComplex& complex,
                                                    const CellPlace& place);

/// The weights of a place in a hexahedron, one a corner in the order of far::hexahedronVertices().
ESPALIER_API std::array<double, 8> hexahedronWeights(const CellPlace& place);

/// The vertices P₁P₂P₃ of a tetrahedron of a type-n cell.
ESPALIER_API std::array<Index, 3> tetrahedronBase(const far::CellComplex& complex, CellId cell,
                                                  Index tetrahedron);

/// Number of tetrahedra of a type-n cell: 4n.
ESPALIER_API Index tetrahedronCount(const far::CellComplex& complex, CellId cell);

}  // namespace espalier::embed
