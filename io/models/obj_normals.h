// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/deformation_gradient.h>
#include <espalier/base/point.h>

#include <iosfwd>
#include <span>

#include "file_model.h"

// A `vn` has no point of its own. It is used at corners of `f`, `fo` and `surf`, and the gradients
// of the points at these corners carry it. The result is rounded to nine digits after the decimal
// point for a unit normal; a component that does not change at this precision keeps its text.
//
// - If all corners of a normal agree on the result, the normal is rewritten in place. A normal
//   without corners stays.
// - If they differ, the result at the first corner replaces the normal under its number, and each
//   other result gets a new `vn`. The new line follows the last `vn` before the corner that first
//   needs it, because many readers fail if a corner precedes its normal. (If the corner already
//   precedes its own `vn` in the old file, the new line follows that `vn`.)
// - A corner whose number no longer names the right normal is rewritten; a number that counts back
//   still counts back. If all normals precede the faces, the rewritten corners are those that need
//   a new normal, and all corners whose numbers count back.
// - A corner that names no normal of the file stays. A corner that names a normal but no point of
//   the file keeps its normal, and does not count as a corner of this normal above.
namespace espalier::io {

/// Writes an OBJ with moved points, and with normals that follow the gradients of the points.
/// \param gradients one per point
/// \cost three passes over the file, and temporarily 8 bytes per corner and about 80 per `vn`
void writeObjNormals(std::ostream& out, const FileView& file, std::span<const Point3> moved,
                     std::span<const DeformationGradient> gradients);

}  // namespace espalier::io
