// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>

#include <array>

namespace espalier::io {

/// The deformation gradient F at a point, by rows: number 3 i + j is d x'_i / d X_j, the change of
/// coordinate i of the deformed point by coordinate j of the point at rest. All are finite.
///
/// Where nothing moves it should be the identity to the last bit, as 1 + d u / d X is, of the
/// displacements u: then directions keep theirs.
using DeformationGradient = std::array<double, 9>;

// What a deformation makes of the directions at a point. Only the direction follows F, and the
// length stays (to a few roundings): unit vectors remain so, as renderers expect. The zero vector
// comes back bit for bit, and so does what the map given below takes to itself. Zero is also what
// F leaves no direction of, but for what its rounding makes up.
//
// The vectors are finite, and so are their lengths, with a factor of 2 to spare. F may be of any
// size; a determinant of 0 or below is as good as any.

/// A normal, along cof(F) n = det(F) F⁻ᵀ n: the cross product of two tangents that F carries. So it
/// keeps to the side from which a face runs anticlockwise, in a deformation that mirrors too, and
/// there is one where F flattens space onto the surface. Zero where F shrinks the surface to a
/// curve.
ESPALIER_API Point3 carryNormal(const DeformationGradient& gradient, const Point3& normal);

/// A tangent, along F t. Zero where F shrinks its line to a point.
ESPALIER_API Point3 carryTangent(const DeformationGradient& gradient, const Point3& tangent);

}  // namespace espalier::io
