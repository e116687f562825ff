// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/far/cell_complex.h>
#include <espalier/far/face_varying.h>
#include <espalier/far/topology_refiner.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

// shapes/ makes lattices by code.
//
// Its functions take sizes and counts, or other lattices, and return a Lattice.
//
// This header has the type Lattice. inventory.h and solids.h make whole lattices; extrude.h,
// section.h, merge.h and attach.h make lattices from parts.
//
// Read this header, then inventory.h.

namespace espalier {

/// The types of integers that files keep on vertices.
enum class IntegerType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64 };

/// Integers on the vertices of a lattice, such as identifiers or material numbers. They are never
/// averaged: a vertex of a new lattice has the integers of one old vertex, or noInteger().
struct VertexIntegers {
    std::string name;
    int components = 1;
    IntegerType type = IntegerType::Int64;

    /// `components` values per vertex, vertex by vertex, in the range of the type. A UInt64 is
    /// stored by its bits: 2^63 and above are negative.
    std::vector<std::int64_t> values;
};

/// Returns the value of a vertex without an integer: −1 for signed types, the largest number for
/// unsigned ones.
ESPALIER_API std::int64_t noInteger(IntegerType type);

/// Returns the name of a type: "UInt64".
ESPALIER_API const char* integerTypeName(IntegerType type);

/// A quantity on the vertices of a lattice besides their position, such as texture coordinates or
/// material parameters. It is refined and applied by the same tables as positions.
///
/// \cite MacCracken & Joy 1996, section 8
struct VertexAttribute {
    std::string name;
    int components = 1;
    std::vector<double> values;  ///< `components` values per vertex, vertex by vertex
};

/// Values on the corners of the faces of a mesh, such as texture coordinates with seams. They are
/// refined by far::refineFaceVarying().
struct FaceVaryingAttribute {
    int components = 2;
    std::vector<double> values;  ///< `components` numbers per value, value by value
    std::vector<Index> corners;  ///< the value at each corner of each face, in the order of the
                                 ///< loops; empty if there are no values

    bool empty() const { return corners.empty(); }
};

/// Refinement options that a file sets; OBJ meshes can. They override a program's defaults, and the
/// options of its user override them.
struct RefinementTags {
    std::optional<far::Boundary> boundary = {};
    std::optional<far::Creasing> creasing = {};
    std::optional<far::TriangleSubdivision> triangles = {};
    std::optional<far::FaceVaryingLinear> faceVarying = {};  ///< the rule for texture coordinates
    friend bool operator==(const RefinementTags&, const RefinementTags&) = default;
};

/// A complex with positions: a lattice (dimension 3), a mesh (2) or a curve (1).
struct Lattice {
    far::CellComplex complex;
    std::vector<Point3> positions;  ///< one per vertex
    far::Marks marks;
    std::vector<VertexAttribute> attributes;
    RefinementTags tags = {};
    std::vector<VertexIntegers> integers = {};
    FaceVaryingAttribute textureCoordinates = {};  ///< meshes only; `vt` in an OBJ
};

}  // namespace espalier
