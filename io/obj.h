// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/api.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <memory>
#include <string>

namespace espalier::io {

/// Reads a Wavefront OBJ. Its points are the `v` statements; every other statement, and all of a
/// `v` but x, y and z (w, colours, spacing, comments, line ends), is kept and not interpreted.
///
/// A backslash at the end of a line continues the statement on the next, except in a comment. A
/// coordinate that changes is written as the shortest text that reads back as the same double; one
/// that does not keeps its text. A file without `v` is a model of no points.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line, if a `v` is malformed or not finite
/// \cost   one pass; 48 bytes a point and the text are kept
ESPALIER_API std::unique_ptr<Model> readObj(const std::filesystem::path& path, std::string bytes);

}  // namespace espalier::io
