// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/embed/binding.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::io {

/// How the surroundings of bound points are deformed, which carries their normals and tangents.
struct BoundGradients {
    /// As limit::LimitTable::gradients: the products with a pose are the columns of F. One row a
    /// point, one column a base vertex.
    std::array<stencils::StencilTable<double>, 3> tables;

    /// The base vertices at rest. The products with their displacements are the columns of F − 1,
    /// exactly 0 where nothing moves.
    std::vector<Point3> rest;

    friend bool operator==(const BoundGradients&, const BoundGradients&) = default;
};

/// A bound model, complete: apply it to a pose, and write the result in the format of the model.
struct BoundModel {
    embed::Binding binding;
    std::string modelName;   ///< of the model's file, without folders; its extension is its format
    std::string modelBytes;  ///< the model's file

    /// The gradients that carry normals and tangents, if the model has such and is bound to the
    /// limit. Without gradients, apply leaves normals and tangents as they are.
    std::optional<BoundGradients> gradients = {};
};

/// Writes a bound model (.espb). The file, little-endian throughout:
///
///     8 bytes   "ESPALIER"
///     u32       version of the format: 2 with gradients, 1 without
///     u32       0
///     u64       hash of the lattice topology (far::topologyHash)
///     i64 × 6   rows, columns, entries, kept points, bytes of the model's name, bytes of the model
///     i64 × 3   version 2: entries of the gradients by x, y and z
///     i64       offsets of the rows, rows + 1 of them
///     f64       weights
///     f64 × 3   where the kept points stay
///     i32       columns
///     i32       the kept points
///     three times, version 2: the gradients by x, y and z
///       i64     offsets of the rows, rows + 1 of them
///       f64     weights
///       i32     columns
///     f64 × 3   version 2: the lattice at rest, one position a column
///     bytes     the model's name; the model
///     u32       CRC-32 of all before (that of zlib)
///
/// \throws Error if the gradients do not have the shape of the binding; FileError if the file
/// cannot
///         be written
ESPALIER_API void writeBoundModel(const std::filesystem::path& path, const BoundModel& model);

/// Reads a bound model of version 1 or 2.
/// \throws FileError if the file cannot be read, is of another kind or version, is truncated, or
///         does not have the checksum that it should; if a weight or a position is not finite;
///         nothing is allocated by the sizes that it claims before they are checked
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path);

/// The same for a file that is in memory already.
/// \param path for messages
/// \param bytes the whole file
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path, std::string_view bytes);

}  // namespace espalier::io
