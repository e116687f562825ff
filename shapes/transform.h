// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/point.h>
#include <espalier/shapes/lattice.h>

#include <array>

/// \file
/// Moves lattices by affine maps.

namespace espalier::shapes {

/// An affine map of space: it maps a point p to linear · p + translation. The default is the
/// identity.
struct ESPALIER_API Affine {
    std::array<std::array<double, 3>, 3> linear = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< rows
    Point3 translation = {0, 0, 0};

    Point3 operator()(const Point3& point) const;
    double determinant() const;
};

/// Returns the map that applies `second`, then `first`: (first * second)(p) = first(second(p)).
ESPALIER_API Affine operator*(const Affine& first, const Affine& second);

ESPALIER_API Affine translation(const Point3& offset);

/// Returns a scaling about the origin, with one factor per axis.
ESPALIER_API Affine scaling(const Point3& factors);

/// Returns a rotation about an axis through the origin, anticlockwise seen from the tip of the
/// axis.
/// \param axis of any length
/// \param angle in radians
/// \throws Error if the axis has no direction
ESPALIER_API Affine rotation(const Point3& axis, double angle);

/// Returns the smallest rotation about the origin that takes one direction to another. For opposite
/// directions, the axis depends on `from` alone.
/// \throws Error if one of the vectors has no direction
ESPALIER_API Affine rotationBetween(const Point3& from, const Point3& to);

/// Returns the complex of a lattice with all faces reversed in their cells. All numbers stay.
/// \throws Error unless the complex has cells
/// \cost O(faces of cells)
ESPALIER_API far::CellComplex insideOut(const far::CellComplex& complex);

/// Returns the lattice moved by an affine map. A map that mirrors would turn cells inside out, so
/// their faces are then reversed, and volumes stay positive.
/// \throws Error if the map is singular or not finite, or the positions do not fit the complex
ESPALIER_API Lattice transformed(const Lattice& lattice, const Affine& map);

}  // namespace espalier::shapes
