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
/// Reads meshes of Gmsh (.msh) of the versions 2.2 and 4.1, ASCII and binary.
///
/// The points are the nodes, in the order of the file; the tags of nodes may be any numbers. The
/// elements of the types 4 (tetrahedron), 5 (hexahedron), 6 (prism) and 7 (pyramid) are cells; the
/// types 2 (triangle) and 3 (quadrangle) are faces. Elements of higher order are curved. In ASCII,
/// elements of types that are not known here are counted; in binary they are refused, since their
/// length is not known. Version 2.2 may have $ParametricNodes instead of $Nodes.

namespace espalier::io {

/// Reads the nodes as a model. Only their coordinates are replaced on writing.
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line, if the file is of another version, is malformed up to the end
///         of $Nodes, or if a coordinate is not finite
ESPALIER_API std::unique_ptr<Model> readGmshModel(const std::filesystem::path& path,
                                                  std::string bytes);

/// Reads the elements of a volume as a lattice. Other elements are skipped, and nodes that no cell
/// uses are dropped.
/// \param notes receives the dropped vertices and skipped elements; may be null
/// \throws FileError with the line, if the file is malformed, or an element of a volume is curved;
///         TopologyError, with the path in its message, if the cells do not form a lattice
ESPALIER_API Lattice readGmsh(const std::filesystem::path& path, std::string_view bytes,
                              ReadNotes* notes = nullptr);

}  // namespace espalier::io
