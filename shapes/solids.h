// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/shapes/lattice.h>

/// \file
/// Makes lattices of a single cell about the origin: regular solids, prisms, pyramids and
/// bipyramids. Refinement turns a vertex where n edges of its cell meet into a type-n cell
/// (MacCracken & Joy 1996, section 2.2).
///
/// Every function throws ArgumentError for the first field out of range.
namespace espalier::shapes {

struct RegularSolidOptions {
    double radius = 1;  ///< radius of the sphere through the vertices, above 0
};
ESPALIER_API Lattice tetrahedron(const RegularSolidOptions& options = {});  ///< 4 vertices, type-3
ESPALIER_API Lattice cube(const RegularSolidOptions& options = {});         ///< 8 vertices, type-3
ESPALIER_API Lattice octahedron(const RegularSolidOptions& options = {});   ///< 6 vertices, type-4
ESPALIER_API Lattice
dodecahedron(const RegularSolidOptions& options = {});                      ///< 20 vertices, type-3
ESPALIER_API Lattice icosahedron(const RegularSolidOptions& options = {});  ///< 12 vertices, type-5

/// Options of a solid over a regular polygon in a plane of constant z. The first vertex of the
/// polygon is on the side of +x.
struct PolygonalSolidOptions {
    int sides = 4;      ///< sides of the polygon: 3 or more
    double radius = 1;  ///< radius of the circle through the vertices of the polygon, above 0
    double height = 1;  ///< extent along z, from -height / 2 to height / 2; above 0
};

/// Makes a prism, with the polygon at the bottom (vertices 0 to sides − 1) and at the top (sides to
/// 2 sides − 1). With 3 sides it is a wedge.
ESPALIER_API Lattice prism(const PolygonalSolidOptions& options = {});

/// Makes a pyramid, with the polygon at the bottom (vertices 0 to sides − 1) and an apex at the top
/// (vertex sides), which is type-n for n sides. With 3 sides it is a tetrahedron.
ESPALIER_API Lattice pyramid(const PolygonalSolidOptions& options = {});

/// Makes a bipyramid, with the polygon in the middle (vertices 0 to sides − 1) and an apex at the
/// bottom (vertex sides) and at the top (vertex sides + 1), both type-n for n sides. With 4 sides
/// it is an octahedron.
ESPALIER_API Lattice bipyramid(const PolygonalSolidOptions& options = {});

}  // namespace espalier::shapes
