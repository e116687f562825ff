// SPDX-License-Identifier: Apache-2.0
#include "io/files/zip.h"

#include <sstream>

#include "matrix_target.h"

namespace espalier::fuzz {
namespace {

/// Returns an archive of the arrays of a matrix, with the right checksums, which no mutation would
/// find.
/// \param text the arrays, separated by marks
std::string archiveOf(std::string_view text) {
    constexpr std::string_view kMark = "<>";
    std::ostringstream out;
    io::ZipWriter zip(out);
    for (const char* name : {"indptr.npy", "indices.npy", "data.npy", "shape.npy", "format.npy"}) {
        const std::string_view part = text.substr(0, text.find(kMark));
        zip.add(name, [&](io::ByteOutput& to) { to.bytes(part); });
        text.remove_prefix(std::min(text.size(), part.size() + kMark.size()));
    }
    zip.finish();
    return out.str();
}

const Target kNpz("npz", [](std::string_view bytes) {
    runMatrix("a.npz", bytes);
    runMatrix("a.npz", archiveOf(bytes));
});

}  // namespace
}  // namespace espalier::fuzz
