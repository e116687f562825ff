// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/shapes/lattice.h>

#include <map>
#include <utility>
#include <vector>

#include "arguments.h"

// Conversion of the arguments that lattices, meshes and curves are made from. A wrong argument
// throws an Error that names it, as in arguments.h.
namespace espalier::python {

/// The values of vertices besides their positions.
struct VertexArrays {
    std::vector<VertexAttribute> attributes;
    std::vector<VertexIntegers> integers;
};

/// Sharpness by the two vertices of an edge.
using EdgeSharpness = std::map<std::pair<Index, Index>, double>;
using VertexSharpness = std::map<Index, double>;

/// Builds the complex of cells: an array (C, 4), (C, 5), (C, 6) or (C, 8) of standard cells, or a
/// list of cells that are each 4, 5, 6 or 8 vertices or a list of loops.
/// \throws Error naming the first cell that is neither; TopologyError as far::ComplexBuilder
far::CellComplex complexOfCells(Index vertexCount, const py::object& cells);

/// Builds the complex of faces: an array (F, k), or a list of loops.
far::CellComplex complexOfFaces(Index vertexCount, const py::object& faces);

/// Splits a dictionary from names to arrays (V,) or (V, k) into attributes, for arrays of real
/// numbers, and integers, for arrays of integers.
VertexArrays vertexArraysOf(const py::dict& arrays, std::size_t vertexCount);

/// Returns marks that have been checked against the complex.
far::Marks marksOf(const far::CellComplex& complex, const EdgeSharpness& edges,
                   const VertexSharpness& vertices, std::vector<Index> holes);

/// Returns texture coordinates that fit a mesh.
/// \param corners an array (F, k), or a list with the values at the corners of each face
FaceVaryingAttribute texturesOf(const far::CellComplex& mesh, const ArrayLike& coordinates,
                                const py::object& corners);

}  // namespace espalier::python
