// SPDX-License-Identifier: Apache-2.0
#include <espalier/io/zip_writer.h>

#include <sstream>

#include "matrix_target.h"

namespace {

/// An archive of the arrays of a matrix, which no mutation would give the checksums that it needs.
/// \param text the arrays, with a mark between two
std::string archiveOf(std::string_view text) {
    constexpr std::string_view kMark = "<>";
    std::ostringstream out;
    espalier::io::ZipWriter zip(out);
    for (const char* name : {"indptr.npy", "indices.npy", "data.npy", "shape.npy", "format.npy"}) {
        const std::string_view part = text.substr(0, text.find(kMark));
        zip.add(name, [&](espalier::io::ByteOutput& to) { to.bytes(part); });
        text.remove_prefix(std::min(text.size(), part.size() + kMark.size()));
    }
    zip.finish();
    return out.str();
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes = espalier::fuzz::textOf(data, size);
    espalier::fuzz::runMatrixTarget("a.npz", bytes);
    espalier::fuzz::runMatrixTarget("a.npz", archiveOf(bytes));
    return 0;
}
