// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>

#include <filesystem>
#include <string>
#include <vector>

namespace espalier::io {

/// Facts about a file that are no errors, but that its user should know. The library never prints:
/// a reader gives the notes to its caller.
struct ReadNotes {
    /// The vertices that no cell of a lattice, or no line of a curve, uses: their numbers in the
    /// file, ascending. The lattice lacks them, and its vertices are numbered without them.
    std::vector<Index> droppedVertices;

    friend bool operator==(const ReadNotes&, const ReadNotes&) = default;
};

/// The notes on a file as one line for people, "a.vtu: dropped 1 unused vertex (vertex 17)"; empty
/// if there are none. Of many vertices the line names the first few.
ESPALIER_API std::string describe(const std::filesystem::path& path, const ReadNotes& notes);

}  // namespace espalier::io
