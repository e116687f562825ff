// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/point.h>

#include <array>
#include <cstddef>
#include <utility>

// Jacobian determinants as Bernstein polynomials. The determinant of a trilinear map is of degree
// (2, 2, 2) in (u, v, w): 27 coefficients. All values lie between the least and the greatest, and
// those at the corners are values themselves; halving the cube closes the gap, by a fourth each
// time. So "positive in the whole cell" can be proved, where samples can only suggest it
// (bernstein_bounds.h).

namespace espalier::solve {

/// The derivatives of a trilinear map by u, v and w: along each axis four edges, at the Bernstein
/// coefficients of the derivative. Edge i + 2j of an axis is that at place i (0 or 1) of the next
/// axis and place j of the one after that, in the order u, v, w, u, v.
using Derivatives = std::array<std::array<Point3, 4>, 3>;

/// So many polynomials of degree (2, 2, 2), by their Bernstein coefficients: coefficient (a, b, c)
/// of each is at a + 3 (b + 3 c).
template <std::size_t Lanes>
using Triquadratics = std::array<std::array<double, Lanes>, 27>;

/// From one coefficient to the next along an axis.
inline constexpr std::array<std::size_t, 3> kAxisStride = {1, 3, 9};

/// The coefficients that are values, at the corners of the cube.
inline constexpr std::array<std::size_t, 8> kCornerCoefficients = {0, 2, 6, 8, 18, 20, 24, 26};

/// The determinant of the Jacobian.
Triquadratics<1> determinant(const Derivatives& derivatives);

/// The same while the map goes over from one to another linearly: cubic in that, too. Lane m is
/// Bernstein coefficient m of degree 3; lanes 0 and 3 are the determinants at the ends.
Triquadratics<4> determinant(const Derivatives& first, const Derivatives& last);

/// The coefficients on the lower and on the upper half of an axis, by de Casteljau.
template <std::size_t Lanes>
std::pair<Triquadratics<Lanes>, Triquadratics<Lanes>> halves(
    const Triquadratics<Lanes>& polynomials, std::size_t axis);

/// A polynomial up to a time between 0 and 1, and from there on.
std::pair<Triquadratics<4>, Triquadratics<4>> partsInTime(const Triquadratics<4>& polynomial,
                                                          double time);

}  // namespace espalier::solve
