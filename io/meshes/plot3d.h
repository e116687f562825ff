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
/// Reads grids of PLOT3D (.xyz, .p3d, .fmt): text, Fortran's unformatted records, or plain binary.
/// A grid has one block or several, two or three dimensions, single or double precision, either
/// byte order, and may have iblank. The file does not state these properties; its length tells
/// them.
///
/// The points are those of all blocks, block after block, i fastest. Coordinates that blocks share
/// are points of each of them.

namespace espalier::io {

/// Reads the points as a model. Only their coordinates are replaced on writing; a grid of two
/// dimensions has no z, so new positions must have z = 0. Blocks of more than one layer are cells;
/// blocks of one layer are faces.
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError if the extent of the file fits no variant of the format, if a text has repeat
///         counts (3*0.0), which cannot be replaced in place, or if a coordinate is not finite
ESPALIER_API std::unique_ptr<Model> readPlot3dModel(const std::filesystem::path& path,
                                                    std::string bytes);

/// Reads a lattice whose cells are those of all blocks, such as an FFD box of pyGeo. Points of
/// different blocks that coincide are welded, as by shapes::merge().
/// \param notes unchanged; for the signature of a reader of lattices
/// \throws FileError as above, and if a block has one layer only; TopologyError, with the path in
///         its message, if the cells do not form a lattice, for example because an edge has no
///         length
ESPALIER_API Lattice readPlot3d(const std::filesystem::path& path, std::string_view bytes,
                                ReadNotes* notes = nullptr);

}  // namespace espalier::io
