// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/cell_complex.h>
#include <espalier/far/marks.h>
#include <espalier/far/topology_error.h>
#include <espalier/shapes/lattice.h>
#include <pybind11/pybind11.h>

#include <map>
#include <utility>
#include <vector>

// Lattices made of what Python has: arrays, lists and dictionaries.
namespace espalier::python {

namespace py = pybind11;

/// The complex of cells: an array (C, 4), (C, 5), (C, 6) or (C, 8) of standard cells, or a list of
/// cells that are each 4, 5, 6 or 8 vertices or a list of loops.
/// \throws Error naming the first cell that is neither; TopologyError as far::ComplexBuilder
far::CellComplex complexOfCells(Index vertexCount, const py::object& cells);

/// The complex of faces: an array (F, k), or a list of loops.
far::CellComplex complexOfFaces(Index vertexCount, const py::object& faces);

/// What vertices carry besides their positions.
struct VertexArrays {
    std::vector<VertexAttribute> attributes;
    std::vector<VertexIntegers> integers;
};

/// Attributes of a dictionary from names to arrays (V,) or (V, k) of real numbers, and integers of
/// arrays of integers, as the files of lattices have them.
VertexArrays vertexArraysOf(const py::dict& arrays, std::size_t vertexCount);

/// By the two vertices of an edge.
using EdgeSharpness = std::map<std::pair<Index, Index>, double>;
using VertexSharpness = std::map<Index, double>;

/// Checked against the complex.
far::Marks marksOf(const far::CellComplex& complex, const EdgeSharpness& edges,
                   const VertexSharpness& vertices, std::vector<Index> holes);

}  // namespace espalier::python
