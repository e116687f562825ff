// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/deformation_gradient.h>
#include <espalier/base/point.h>

/// \file
/// Carries normals and tangents along with a deformation.

namespace espalier::io {

// carryNormal() and carryTangent() turn a direction as the deformation turns it, and keep its
// length (to a few roundings): unit vectors stay unit vectors, as renderers expect. A direction
// that F maps to itself comes back bit for bit, and so does the zero vector. The result is zero
// where F maps the direction to zero up to rounding.
//
// The vectors and F must be finite, and the lengths of the vectors at most half of the largest
// double. F may be of any size, and its determinant may be 0 or negative.

/// Returns the normal of the deformed surface, along cof(F) n = det(F) F⁻ᵀ n, the cross product of
/// two tangents that F carries. It stays on the side from which the face runs anticlockwise, even
/// if the deformation mirrors, and it exists where F flattens space onto the surface. Zero where F
/// shrinks the surface to a curve.
ESPALIER_API Point3 carryNormal(const DeformationGradient& gradient, const Point3& normal);

/// Returns the tangent of the deformed surface, along F t. Zero where F shrinks the line of the
/// tangent to a point.
ESPALIER_API Point3 carryTangent(const DeformationGradient& gradient, const Point3& tangent);

}  // namespace espalier::io
