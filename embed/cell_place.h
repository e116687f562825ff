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
/// In a hexahedron (type-3 cell), `uvw` are the parameters (u, v, w) in [0, 1]³ of the trilinear
/// map of its corners. In a type-n cell, they are coordinates in one of its 4n tetrahedra: P₀ +
/// u(P₁ − P₀) + v(P₂ − P₀) + w(P₃ − P₀). P₀ is the average of the cell's vertices. P₁P₂P₃ is half a
/// face, which is cut from the first to the third vertex of its loop (a choice that depends on the
/// refinement alone, not on numbering).
///
/// For a point outside the cell, `offset` continues from there along the tangent of the map, in the
/// same coordinates. It is 0 for points inside.
///
/// \cite MacCracken & Joy 1996, sections 4 to 6, Figure 6
struct CellPlace {
    CellId cell;
    Index tetrahedron = 0;  ///< 2·face + half, faces in the order of the cell; 0 in a hexahedron
    std::array<double, 3> uvw = {};
    std::array<double, 3> offset = {};
};

/// One vertex and its weight in a position.
struct VertexWeight {
    Index vertex = 0;
    double weight = 0;
};

/// Returns the position of a place as weights of the vertices of `complex`: 8 in a hexahedron. In a
/// type-n cell, the three vertices of the tetrahedron's base and then all 2n + 2 vertices of the
/// cell, each with its part of P₀; so a vertex may occur twice. The weights sum to 1, and are
/// between 0 and 1 if the offset is 0. Zero weights are left out of a hexahedron and of a base.
///
/// \param complex a refined lattice: level 1 or above
ESPALIER_API std::vector<VertexWeight> placeWeights(const far::CellComplex& complex,
                                                    const CellPlace& place);

/// Returns the derivative of these weights by coordinate `axis` of the place, with offset 0: the
/// direction in which the position moves. The weights sum to 0.
/// \param axis 0 for u, 1 for v, 2 for w
ESPALIER_API std::vector<VertexWeight> directionWeights(const far::CellComplex& complex,
                                                        const CellPlace& place, int axis);

/// Returns the weights of a place in a hexahedron, one per corner in the order of
/// far::hexahedronVertices().
ESPALIER_API std::array<double, 8> hexahedronWeights(const CellPlace& place);

/// Returns the vertices P₁P₂P₃ of a tetrahedron of a type-n cell.
ESPALIER_API std::array<Index, 3> tetrahedronBase(const far::CellComplex& complex, CellId cell,
                                                  Index tetrahedron);

/// Returns the number of tetrahedra of a type-n cell: 4n.
ESPALIER_API Index tetrahedronCount(const far::CellComplex& complex, CellId cell);

}  // namespace espalier::embed
