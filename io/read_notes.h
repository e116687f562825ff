// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

/// \file
/// Notes of readers on files that are valid but unusual.

namespace espalier::io {

class Model;

/// Facts about a file that are no errors, but that its user should know. The library never prints:
/// a reader passes the notes to its caller.
struct ReadNotes {
    /// Vertices that no cell of the lattice, or no line of the curve, uses: their numbers in the
    /// file, ascending. The reader leaves them out and numbers the other vertices without gaps.
    std::vector<Index> droppedVertices;

    /// The numbers of vertex cells, line cells and surface cells in a file of a lattice (.vtu,
    /// .vtk), by dimension. The reader skips them and numbers the other cells without gaps.
    std::array<Index, 3> skippedCells = {};

    /// The number of texture coordinates that were dropped, because some corners of faces name
    /// none.
    Index droppedTextureCoordinates = 0;

    /// Further notes as phrases, as those of Model::notes().
    std::vector<std::string> others = {};

    friend bool operator==(const ReadNotes&, const ReadNotes&) = default;
};

/// Returns the notes on a file as one line of text, "a.vtu: skipped 2 lines and 6 surface cells,
/// which are not cells of a lattice; dropped 1 unused vertex (vertex 17)"; empty if there are no
/// notes. The line names at most five vertices.
ESPALIER_API std::string describe(const std::filesystem::path& path, const ReadNotes& notes);

/// Returns the notes on a model (Model::notes()) as one line of text; empty if there are none.
/// \param path of the model
ESPALIER_API std::string describe(const std::filesystem::path& path, const Model& model);

/// Refuses a model on which its reader has notes, for callers that want to use no file of which a
/// part is not understood.
/// \throws FileError with the notes, if there are any
ESPALIER_API void refuseNotes(const std::filesystem::path& path, const Model& model);

}  // namespace espalier::io
