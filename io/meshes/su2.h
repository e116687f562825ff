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
/// Reads meshes of SU2 (.su2), of two or three dimensions, with one zone or several.
///
/// The points are the lines of NPOIN=, zone after zone. The elements of NELEM= of the types 10
/// (tetrahedron), 12 (hexahedron), 13 (wedge) and 14 (pyramid) are cells; triangles (5) and
/// quadrilaterals (9) of NELEM= and of the markers are faces. Elements of other types are counted.

namespace espalier::io {

/// Reads the points as a model. Only their coordinates are replaced on writing; a mesh of two
/// dimensions has no z, so new positions must have z = 0.
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line, if NDIME= or NPOIN= is missing or malformed, or if a coordinate
///         is not finite
ESPALIER_API std::unique_ptr<Model> readSu2Model(const std::filesystem::path& path,
                                                 std::string bytes);

/// Reads the elements of a mesh of three dimensions as a lattice. Markers are skipped, and points
/// that no cell uses are dropped. Points of different zones are not welded.
/// \param notes receives the dropped vertices and skipped elements; may be null
/// \throws FileError with the line, if the file is malformed; TopologyError, with the path in its
///         message, if the cells do not form a lattice
ESPALIER_API Lattice readSu2(const std::filesystem::path& path, std::string_view bytes,
                             ReadNotes* notes = nullptr);

}  // namespace espalier::io
