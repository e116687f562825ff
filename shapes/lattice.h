// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/vertex_integers.h>

#include <optional>
#include <string>
#include <vector>

// shapes/: lattices made by code.
//
// In: sizes and counts; or other lattices. Out: a Lattice.
//
// Types: Lattice (this header), the options and functions of inventory.h and solids.h; extrude.h,
// section.h, merge.h and attach.h make lattices of parts.
//
// Read this header, then inventory.h.
namespace espalier {

/// A quantity on the vertices of a lattice besides their position: texture coordinates, material
/// parameters. It is refined and applied by the same tables as positions.
///
/// \cite MacCracken & Joy 1996, section 8
struct VertexAttribute {
    std::string name;
    int components = 1;
    std::vector<double> values;  ///< `components` a vertex, vertex by vertex
};

/// How a file asks to be refined, where it does; OBJ meshes carry such tags. They win over a
/// program's defaults, and its user's choices over them.
struct RefinementTags {
    std::optional<far::Boundary> boundary = {};
    std::optional<far::Creasing> creasing = {};
    std::optional<far::TriangleSubdivision> triangles = {};
    friend bool operator==(const RefinementTags&, const RefinementTags&) = default;
};

/// A complex (a lattice, of dimension 3, or a mesh or a curve) placed in space.
struct Lattice {
    far::CellComplex complex;
    std::vector<Point3> positions;  ///< one a vertex
    far::Marks marks;
    std::vector<VertexAttribute> attributes;
    RefinementTags tags = {};
    std::vector<VertexIntegers> integers = {};
};

}  // namespace espalier
