// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <memory>
#include <string>

namespace espalier::io {

/// Reads a PLY as a model: ASCII, or binary of either byte order. Its points are the properties x,
/// y and z of the element `vertex`, of type float or double. All other data is kept and not
/// interpreted.
///
/// The properties nx, ny and nz are a normal, and tx, ty and tz a tangent, if each of the three
/// exists once and is a float or a double. In these properties a word that is no number is not an
/// error.
///
/// The faces are the rows of the element `face`: its lists `vertex_indices` or `vertex_index`.
///
/// The file must have exactly the rows that its header claims. In ASCII a row is a line; empty
/// lines between and after rows are kept and ignored. In binary one line end may follow the rows.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError as readModel(); if x, y or z has an integer type, which could not hold a
///         deformed position; or if a position is not finite
/// \cost one pass; the file, and 48 bytes for each point and each direction, are kept
ESPALIER_API std::unique_ptr<Model> readPly(const std::filesystem::path& path, std::string bytes);

}  // namespace espalier::io
