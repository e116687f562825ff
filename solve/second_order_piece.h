// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <span>

#include "piece.h"

// Cells and faces of second order as maps whose determinants have Bernstein coefficients.
//
// A tetrahedron, a wedge, a pyramid or a triangle is a cube or a square of which an edge or a side
// is collapsed. The map from the cube is quadratic along each axis. Its derivatives vanish where
// the cube is collapsed; each is a product of (1 − u), (1 − v) or (1 − w) and of another
// polynomial. The determinant of these other polynomials is the determinant of the cell. So the
// derivatives of the piece are those polynomials, and not the derivatives of one map.

namespace espalier::solve {

/// Returns the map of a cell of second order: of the quadratic polynomials over the tetrahedron, of
/// triquadratic ones over the hexahedron, of products of both over the wedge. Over the pyramid, the
/// map has the terms xⁱ yʲ (1 − z)^max(i, j) P(z) in the coordinates of its collapsed cube, of
/// degree 2 in all, as in Gmsh. A cell without points in the middle of quadrilaterals or of
/// the cell has the serendipity map. It puts such a point at ½ of the sum of the middles of the
/// edges less ¼ of the sum of the corners; in the middle of a hexahedron, at ¼ of the first sum
/// less ¼ of the second.
///
/// \param points of a cell of second order, in the order of far::cellPoints()
/// \cite Bergot, Cohen & Duruflé 2010, Higher-order finite elements for hybrid meshes using new
///       nodal pyramidal elements, section 2
Piece<2> secondOrderCell(std::span<const Index> points, std::span<const Point3> positions);

/// Returns the volume of the same map: the integral of its determinant.
double secondOrderVolume(std::span<const Index> points, std::span<const Point3> positions);

/// Returns the map of a face of second order, whose third derivative is a constant: the
/// determinant is the area along this normal.
///
/// \param points the corners and the middles of the edges that follow them: 6 points of a triangle,
///        8 of a quadrilateral; 9 with its middle
Piece<2> secondOrderFace(std::span<const Index> points, std::span<const Point3> positions,
                         const Point3& normal);

/// Returns the area of the same map along a normal of length 1.
double secondOrderArea(std::span<const Index> points, std::span<const Point3> positions,
                       const Point3& normal);

}  // namespace espalier::solve
