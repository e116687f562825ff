// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <memory>
#include <string>

namespace espalier::io {

/// Reads a PLY: ASCII, or binary of either byte order. Its points are the properties x, y and z of
/// the element `vertex`, of type float or double; all else is kept and not interpreted.
///
/// Directions are its properties nx, ny and nz, a normal, and tx, ty and tz, a tangent, if each of
/// the three is there once and is a float or a double. Words that are no numbers are no error
/// there.
///
/// Every row that the header claims must be there, and nothing after them. In ASCII a row is a
/// line; empty lines between and after rows are kept and passed over. In binary one line end may
/// follow.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError as readModel(); if x, y or z is of an integer type, which would not hold a
/// deformed position; or if a position is not finite
/// \cost   one pass; 48 bytes for each point and each direction, and the file, are kept
ESPALIER_API std::unique_ptr<Model> readPly(const std::filesystem::path& path, std::string bytes);

}  // namespace espalier::io
