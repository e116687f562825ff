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

/// \file
/// Writes and reads bound models (.espb): a model, its binding, and the gradients that carry
/// its normals.

namespace espalier::io {

/// Tables that give the deformation gradient F at each bound point, by which normals and tangents
/// are carried along.
struct BoundGradients {
    /// One row per point and one column per base vertex, as in limit::LimitTable::gradients. Table
    /// j times a pose is column j of F. Table j times the displacements of the pose from the rest
    /// is column j of F − 1, which is exactly 0 where nothing moves.
    std::array<stencils::StencilTable<double>, 3> tables;

    friend bool operator==(const BoundGradients&, const BoundGradients&) = default;
};

/// A model with its binding: all that is needed to apply a pose, and to write the result in the
/// format of the model.
struct BoundModel {
    embed::Binding binding;
    std::string
        modelName;  ///< file name of the model, without folders; the extension is its format
    std::string modelBytes;  ///< content of the model's file

    /// Present if the model has normals or tangents and is bound to the limit. Without gradients,
    /// applying a pose leaves normals and tangents as they are.
    std::optional<BoundGradients> gradients = {};

    /// The base vertices at rest. With them, points that do not move are given exactly. Empty if
    /// they are not known, as in files of version 1.
    std::vector<Point3> rest = {};
};

/// Writes a bound model (.espb). The file is little-endian throughout and holds:
///
///     8 bytes   "ESPALIER"
///     u32       version of the format: 2 with gradients; 3 with the lattice at rest, and no
///               gradients; 1 with neither
///     u32       0
///     u64       hash of the lattice topology (far::topologyHash)
///     i64 × 6   rows, columns, entries, kept points, bytes of the model's name, bytes of the model
///     i64 × 3   version 2: entries of the gradients by x, y and z
///     i64       offsets of the rows, rows + 1 of them
///     f64       weights
///     f64 × 3   positions of the kept points
///     i32       columns
///     i32       numbers of the kept points
///     three times, version 2: the gradients by x, y and z
///       i64     offsets of the rows, rows + 1 of them
///       f64     weights
///       i32     columns
///     f64 × 3   versions 2 and 3: the lattice at rest, one position per column
///     bytes     the model's name; the model
///     u32       CRC-32 (zlib's) of all bytes before it
///
/// \throws Error if the gradients or the lattice at rest do not have the shape of the binding, or
/// if
///         there are gradients and no lattice at rest; FileError if the file
///         cannot be written
ESPALIER_API void writeBoundModel(const std::filesystem::path& path, const BoundModel& model);

/// Reads a bound model of version 1 to 3. The sizes that the file claims are checked before memory
/// is allocated for them.
/// \throws FileError if the file cannot be read, is of another kind or version, is truncated, or
///         has a wrong checksum; if a weight or a position is not finite
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path);

/// The same for a file that is in memory already.
/// \param path for messages
/// \param bytes the whole file
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path, std::string_view bytes);

}  // namespace espalier::io
