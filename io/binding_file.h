// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/bind/bind.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

/// \file
/// Writes and reads bound models (.espb): a model, its binding, and the gradients that carry
/// its normals.

namespace espalier::io {

/// A model with its binding: all that is needed to apply a pose, and to write the result in the
/// format of the model.
struct BoundModel {
    /// With gradients if normals, tangents and splats of the model follow its points. Without them,
    /// applying a pose leaves them as they are.
    bind::Binding binding;

    std::string modelName = {};   ///< file name without folders, whose extension is the format;
                                  ///< empty if the points are of no file
    std::string modelBytes = {};  ///< content of the file

    /// The faces of the lattice. readPose() compares the faces of an editor mesh with them
    /// (pose_file.h).
    ModelFaces faces = {};
};

/// Writes a bound model (.espb). The file is little-endian throughout and holds:
///
///     8 bytes   "ESPALIER"
///     u32       version of the format: 8
///     u32       1 with gradients, 0 without
///     u64       hash of the lattice topology (far::topologyHash)
///     f64       largest residual
///     i64 × 7   rows, columns, entries, faces of the lattice, corners of all faces, bytes of the
///               model's name, bytes of the model
///     i64 × 10  of the gradients: vertices, their entries, points with rows, their entries,
///               cells, places in cells, patches, places in patches, places in a basis,
///               weights; 0 without
///     the table:
///       i64     offsets of the rows, rows + 1 of them
///       f64     weights
///       i32     columns
///     with gradients (embed::Gradients):
///       a table of the vertices over the columns
///       i32      the points with rows
///       a table of three rows for each of these points, over the vertices
///       i32 × 8  vertices of each cell
///       i32 × 2, f64 × 3   point, cell, u, v and w of each place in a cell
///       f64      spacing
///       i32 × 64 vertices of each patch; 2³¹ − 1 where a layer is missing
///       i32 × 2, f64 × 3   point, patch, u, v and w of each place in a patch
///       i32 × 4  basis (0 Bézier, 1 B-spline), and cells along x, y and z
///       i32, f64 × 3       point, and place in a basis along x, y and z
///       f64 × 4  weight of each point, and its slope by x, y and z; none if all are 1
///     f64 × 3   the points at rest, one per row
///     f64 × 3   the lattice at rest, one position per column
///     u8        status of each point (embed::PointStatus)
///     i64       for each face, the end of its corners in the next list
///     i32       the corners of all faces, by their columns
///     bytes     the model's name; the model
///     u32       CRC-32 (zlib's) of all bytes before it
///
/// The factors of a binding are not written.
///
/// \throws Error as checkBoundModel(); FileError if the file cannot be written
ESPALIER_API void writeBoundModel(const std::filesystem::path& path, const BoundModel& model);

/// Returns the bytes of this file.
/// \throws Error as checkBoundModel()
ESPALIER_API std::string boundModelBytes(const BoundModel& model);

/// Reads a bound model. The sizes that the file claims are checked before memory is allocated for
/// them.
/// \throws FileError if the file cannot be read, is of another kind or version, is truncated, or
///         has a wrong checksum; if a weight or a position is not finite
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path);

/// The same for a file that is in memory already.
/// \param path for messages
/// \param bytes the whole file
ESPALIER_API BoundModel readBoundModel(const std::filesystem::path& path, std::string_view bytes);

/// Reads the model of a bound model, to write it in a pose. Points that are of no file are a model
/// points.obj.
/// \param path of the bound model, for messages
/// \throws FileError if the model cannot be read, or has another number of points than the binding;
///         MemoryError as readModel()
ESPALIER_API std::unique_ptr<Model> modelOf(const BoundModel& model,
                                            const std::filesystem::path& path);

/// Checks a bound model, as writeBoundModel() does.
/// \throws Error if the parts of the binding do not fit together; if a position or the largest
///         residual is not finite; if the faces do not divide their corners, or name other vertices
ESPALIER_API void checkBoundModel(const BoundModel& model);

}  // namespace espalier::io
