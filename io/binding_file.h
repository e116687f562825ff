// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/api.h>
#include <espalier/stencils/binding.h>

#include <filesystem>
#include <string>
#include <string_view>

namespace espalier::io {

/// A bound model, complete: apply it to a pose, and write the result in the format of the model.
struct BoundModel {
    stencils::Binding<double> binding;
    std::string modelName;   ///< of the model's file, without folders; its extension is its format
    std::string modelBytes;  ///< the model's file
};

/// Writes a bound model (.espb). The file, little-endian throughout:
///
///     8 bytes   "ESPALIER"
///     u32       version of the format: 1
///     u32       0
///     u64       hash of the lattice topology (far::topologyHash)
///     i64 × 6   rows, columns, entries, kept points, bytes of the model's name, bytes of the model
///     i64       offsets of the rows, rows + 1 of them
///     f64       weights
///     f64 × 3   where the kept points stay
///     i32       columns
///     i32       the kept points
///     bytes     the model's name; the model
///     u32       CRC-32 of all before (that of zlib)
///
/// \throws FileError if the file cannot be written
ESPALIER_API void writeBoundModel(const std::filesystem::path& path, const BoundModel& model);

/// Reads a bound model.
/// \throws FileError if the file cannot be read, is of another kind or version, is truncated, or
///         does not have the checksum that it should; nothing is allocated by what it claims before
///         that
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path);

/// The same for a file that is in memory already.
/// \param path for messages
/// \param bytes the whole file
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path, std::string_view bytes);

}  // namespace espalier::io
