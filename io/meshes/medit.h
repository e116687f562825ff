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
/// Reads meshes of Medit in ASCII (.mesh), of two or three dimensions, as Gmsh, MMG and FreeFEM
/// write them.
///
/// The points are the Vertices. Tetrahedra, Pyramids, Prisms and Hexahedra are cells; Triangles and
/// Quadrilaterals are faces. All other sections are skipped.

namespace espalier::io {

/// Reads the vertices as a model. Only their coordinates are replaced on writing; a mesh of two
/// dimensions has no z, so new positions must have z = 0.
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line, if Dimension or Vertices is missing or malformed, or if a
///         coordinate is not finite
ESPALIER_API std::unique_ptr<Model> readMeditModel(const std::filesystem::path& path,
                                                   std::string bytes);

/// Reads the cells of a mesh of three dimensions as a lattice. Other elements are skipped, and
/// vertices that no cell uses are dropped.
/// \param notes receives the dropped vertices and skipped elements; may be null
/// \throws FileError with the line, if the file is malformed; TopologyError, with the path in its
///         message, if the cells do not form a lattice
ESPALIER_API Lattice readMedit(const std::filesystem::path& path, std::string_view bytes,
                               ReadNotes* notes = nullptr);

}  // namespace espalier::io
