// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/io/model.h>

#include <filesystem>
#include <memory>
#include <string>

namespace espalier::io {

/// Reads a Wavefront OBJ as a model. Its points are the `v` statements, and its directions the `vn`
/// statements. All other statements, and everything in a `v` besides x, y and z (w, colours,
/// spacing, comments, line ends), are kept and not interpreted.
///
/// A backslash at the end of a line continues the statement on the next line, except in a comment.
/// A coordinate that changes is written as the shortest text that reads back as the same double; a
/// coordinate that does not change keeps its text. A file without `v` is a model without points.
///
/// A `vn` has no point of its own. It is used at corners of `f`, `fo` and `surf`, and the gradients
/// of the points at these corners carry it. The result is rounded to nine digits after the decimal
/// point for a unit normal; a component that does not change at this precision keeps its text.
///
/// - If all corners of a normal agree on the result, the normal is rewritten in place. A normal
///   without corners stays.
/// - If they differ, the result at the first corner replaces the normal under its number, and each
///   other result gets a new `vn`. The new line follows the last `vn` before the corner that first
///   needs it, because many readers fail if a corner precedes its normal. (If the corner already
///   precedes its own `vn` in the old file, the new line follows that `vn`.)
/// - A corner whose number no longer names the right normal is rewritten; a number that counts back
///   still counts back. If all normals precede the faces, the rewritten corners are those that need
///   a new normal, and all corners whose numbers count back.
/// - A corner that names no normal of the file stays. A corner that names a normal but no point of
///   the file keeps its normal, and does not count as a corner of this normal above.
///
/// The faces are the statements `f` and `fo`.
///
/// \param path for messages
/// \param bytes the whole file
/// \throws FileError with the line, if a `v` is malformed or not finite, or if the first word of a
///         statement is no keyword of the format
/// \cost one pass; the text and 48 bytes per point are kept. Writing takes one pass too. With
/// gradients it takes three, and temporarily 8 bytes per corner and about 80 per `vn`.
ESPALIER_API std::unique_ptr<Model> readObj(const std::filesystem::path& path, std::string bytes);

}  // namespace espalier::io
