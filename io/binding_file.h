// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/bind/bind.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file
/// Writes and reads bound models (.espb): a model, its binding, and the gradients that carry
/// its normals.

namespace espalier::io {

/// A model with its binding: all that is needed to apply a pose, and to write the result in the
/// format of the model.
struct BoundModel {
    /// Files have the gradients if the model has normals or tangents and was bound to the limit;
    /// without gradients, applying a pose leaves normals and tangents as they are. Files of version
    /// 1 do not have the lattice at rest.
    bind::Binding binding;

    std::string
        modelName;  ///< file name of the model, without folders; the extension is its format
    std::string modelBytes;  ///< content of the model's file

    /// The faces of the lattice. readPose() compares the faces of an editor mesh with them
    /// (pose_file.h). Empty if they are not known, as in files of versions 1 to 3.
    ModelFaces faces = {};
};

/// Writes a bound model (.espb). The file is little-endian throughout and holds:
///
///     8 bytes   "ESPALIER"
///     u32       version of the format: 4 with the lattice at rest and its faces; without faces:
///               2 with gradients; 3 with the lattice at rest, and no gradients; 1 with neither
///     u32       version 4: 1 with gradients, 0 without; other versions: 0
///     u64       hash of the lattice topology (far::topologyHash)
///     i64 × 6   rows, columns, entries, kept points, bytes of the model's name, bytes of the model
///     i64 × 3   with gradients: entries of the gradients by x, y and z
///     i64 × 2   version 4: faces, corners of all faces
///     i64       offsets of the rows, rows + 1 of them
///     f64       weights
///     f64 × 3   positions of the kept points
///     i32       columns
///     i32       numbers of the kept points
///     three times, with gradients: the gradients by x, y and z
///       i64     offsets of the rows, rows + 1 of them
///       f64     weights
///       i32     columns
///     f64 × 3   versions 2 to 4: the lattice at rest, one position per column
///     i64       version 4: for each face, the end of its corners in the next list
///     i32       version 4: the corners of all faces, by their columns
///     bytes     the model's name; the model
///     u32       CRC-32 (zlib's) of all bytes before it
///
/// If the bound model has no file of a model, the points of the binding are stored as a model
/// points.obj, so that `espalier apply` can write them; else the file of the model has them.
///
/// \throws Error if the gradients, the lattice at rest or its faces do not have the shape of the
///         binding; if there are gradients or faces but no lattice at rest; if there are points,
///         but not one per row; if a point that is to be stored is not finite; FileError if the
///         file cannot be written
ESPALIER_API void writeBoundModel(const std::filesystem::path& path, const BoundModel& model);

/// Reads a bound model of version 1 to 4. The points of the binding are in the file of the model:
/// see pointsAtRest(). The sizes that the file claims are checked before memory
/// is allocated for them.
/// \throws FileError if the file cannot be read, is of another kind or version, is truncated, or
///         has a wrong checksum; if a weight or a position is not finite
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path);

/// The same for a file that is in memory already.
/// \param path for messages
/// \param bytes the whole file
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path, std::string_view bytes);

/// Returns the points of the model at rest, one per row; nothing if the bound model has rows but no
/// file of a model.
/// \throws Error if the model cannot be read, or has another number of points
ESPALIER_API std::optional<std::vector<Point3>> pointsAtRest(const BoundModel& model);

/// The same for a bound model from a file.
/// \throws FileError that names the file instead of Error; MemoryError as readModel()
ESPALIER_API std::optional<std::vector<Point3>> pointsAtRest(const BoundModel& model,
                                                             const std::filesystem::path& path);

/// Checks that the parts of a bound model fit together, as writeBoundModel() does.
/// \throws Error unless the gradients have the binding's points as rows and its lattice vertices as
///         columns, and the lattice at rest has these vertices and its faces name no others
ESPALIER_API void checkBoundModel(const BoundModel& model);

}  // namespace espalier::io
