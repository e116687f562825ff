// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>

#include <array>

namespace espalier::shapes {

/// An affine map of space: point p goes to linear · p + translation. The identity by default.
struct ESPALIER_API Affine {
    std::array<std::array<double, 3>, 3> linear = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< by row
    Point3 translation = {0, 0, 0};

    Point3 operator()(const Point3& point) const;
    double determinant() const;
};

/// First `second`, then `first`: (first * second)(p) = first(second(p)).
ESPALIER_API Affine operator*(const Affine& first, const Affine& second);

ESPALIER_API Affine translation(const Point3& offset);

/// Scales about the origin, by a factor an axis.
ESPALIER_API Affine scaling(const Point3& factors);

/// Turns about an axis through the origin, anticlockwise seen from the tip of the axis.
/// \param axis of any length
/// \param angle in radians
/// \throws Error if the axis has no direction
ESPALIER_API Affine rotation(const Point3& axis, double angle);

/// The smallest rotation about the origin that takes one direction to another; for opposite
/// directions, about an axis that is chosen by `from` alone.
/// \throws Error if one of them has no direction
ESPALIER_API Affine rotationBetween(const Point3& from, const Point3& to);

/// The lattice moved by an affine map. A map that mirrors turns the cells of a lattice inside out,
/// so their faces are then wound the other way round: volumes stay positive.
/// \throws Error if the map is singular or not finite, or the positions do not fit the complex
ESPALIER_API Lattice transformed(const Lattice& lattice, const Affine& map);

}  // namespace espalier::shapes
