// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <memory>
#include <string>

namespace espalier::io {

/// Reads a Wavefront OBJ. Its points are the `v` statements; every other statement, and all of a
/// `v` but x, y and z (w, colours, spacing, comments, line ends), is kept and not interpreted. Its
/// directions are the `vn` statements, with the corners that name them.
///
/// A backslash at the end of a line continues the statement on the next, except in a comment. A
/// coordinate that changes is written as the shortest text that reads back as the same double; one
/// that does not keeps its text. A file without `v` is a model of no points.
///
/// A `vn` has no point: it is carried by the gradients of the points at whose corners it is, in
/// `f`, `fo` and `surf`. To nine digits after the point of a unit normal; where these are as
/// before, a component keeps its text.
///
/// - Where all its corners agree, it is rewritten in its place; where no corner has it, it stays.
/// - Where they differ, the first keeps the number, and for each other normal there is a new `vn`,
///   right after the last `vn` before the corner that first needs it: so no corner comes to stand
///   before its normal, as it would if new ones stood at the end, and many readers would fail. (If
///   the corner stands before its own `vn` in the file that was read, right after that.)
/// - The number of a normal in a corner is rewritten if it no longer names the right one. One that
///   counts back does so still. Where all normals precede the faces, these are the corners that
///   need a new normal, and, of numbers that count back, all.
/// - A corner that names no normal of the file stays. One that names a normal, but no point of the
///   file, takes no part in this but keeps its normal.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line, if a `v` is malformed or not finite, or if the first word of a
/// statement is no keyword of the format
/// \cost   one pass; 48 bytes a point and the text are kept. Writing takes one pass too; with
/// gradients three, and 8 bytes a corner and about 80 for each `vn` meanwhile
ESPALIER_API std::unique_ptr<Model> readObj(const std::filesystem::path& path, std::string bytes);

}  // namespace espalier::io
