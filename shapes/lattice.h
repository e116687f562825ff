// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/topology_refiner.h>

#include <cstdint>
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

/// The types of integers that files keep on vertices.
enum class IntegerType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64 };

/// Integers on the vertices of a lattice: identifiers, numbers of materials. They are never
/// averaged: a vertex has the integers of one vertex that it comes from, or noInteger().
struct VertexIntegers {
    std::string name;
    int components = 1;
    IntegerType type = IntegerType::Int64;

    /// `components` a vertex, vertex by vertex, in the range of the type. UInt64 has its bits here:
    /// 2^63 and above are negative.
    std::vector<std::int64_t> values;
};

/// Marks a vertex that has no integer: −1 of signed types, the largest number of unsigned ones.
ESPALIER_API std::int64_t noInteger(IntegerType type);

/// The name of a type: "UInt64".
ESPALIER_API const char* integerTypeName(IntegerType type);

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
