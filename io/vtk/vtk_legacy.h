// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/far/topology_error.h>
#include <espalier/io/model.h>
#include <espalier/io/read_notes.h>
#include <espalier/shapes/lattice.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

/// \file
/// Reads and writes lattices in VTK's legacy files (.vtk). Marks and
/// attributes have the names and conventions of .vtu files (vtu.h); marks of edges are in the FIELD
/// of the data set.

namespace espalier::io {

/// Reads a lattice from a file of version 1 to 5, ASCII or BINARY: an unstructured grid with cells
/// of the types 10 to 16 and 42, or a structured grid of at least two points along each axis.
///
/// SCALARS, VECTORS, NORMALS, TEXTURE_COORDINATES, TENSORS and the arrays of FIELD in POINT_DATA
/// become attributes, or Lattice::integers if they have an integer type. The reader skips
/// vtkGhostType, arrays without numbers, colours, ids, lookup tables, METADATA and all of
/// CELL_DATA. Vertices, lines and surface cells are skipped, and the other cells keep their order.
/// Vertices that no other cell uses are dropped, and the vertices after them get lower numbers.
///
/// \param path for messages
/// \param bytes the whole file
/// \param notes receives the dropped vertices and skipped cells; may be null
/// \throws FileError with the line, if the file is malformed or holds cells of other types;
///         TopologyError, with the path in its message, if the cells do not form a lattice
ESPALIER_API Lattice readVtkLegacy(const std::filesystem::path& path, std::string_view bytes,
                                   ReadNotes* notes = nullptr);

/// Writes a lattice as ASCII, version 3.0, so that it reads back the same: positions, attributes
/// and integers bit for bit, integers with their type, marks in canonical order.
///
/// \throws FileError if the lattice is not of dimension 3, its parts do not fit together, or the
///         file cannot be written; TopologyError if a mark names an entity that does not exist
ESPALIER_API void writeVtkLegacy(const std::filesystem::path& path, const Lattice& lattice);

}  // namespace espalier::io
