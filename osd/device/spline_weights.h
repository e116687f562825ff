// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "device_code.h"
#include "device_data.h"

// One axis of a regular cell: a point on a uniform cubic B-spline, from its parameter. Rows of the
// form without a table have only parameters (spline_rows.h).
//
// Inside a cell the spline is a cubic polynomial, so the columns of a cell are converted to its
// coefficients once, and a point needs only the powers of its parameter. Column −1 at a boundary is
// the phantom 2P₀ − P₁.
namespace espalier::osd::device {

/// Number of coefficients along an axis with `size` columns.
///
/// \param size 4: inside; 3: a boundary lies before column 0; 2: at both ends, where the spline is
///        linear
ESPALIER_DEVICE constexpr Index coefficientCount(Index size) {
    return size == 3 ? 4 : size;
}

/// The powers of a parameter that the coefficients of a cell are multiplied with: 1, t, t² and t³
/// in the limit.
template <class Real>
struct SplinePowers {
    Real of[4];
};

/// Returns the powers of a parameter.
///
/// On level n, the point lies on a segment between two neighbouring level-n vertices. The segment
/// from m − h/2 to m + h/2, with h = 2⁻ⁿ, has the weights
///
///     b(t) − (t − m)²/2 · b″ − h²/24 · b″ − (e/3)(t − m) · b‴,   e = h²/4 − (t − m)²
///
/// with b″ at t: level-n vertices are b − h²/6 · b″ at the ends of the segment, and the chord of a
/// cubic is known in closed form. In the limit, h is 0, and b is what remains. As b″ and b‴ are 2
/// and 6 times the last two coefficients, only the last two powers differ from t² and t³.
///
/// These are the weights of embed::cubicBSpline(), from a parameter that is 0 in the middle of the
/// cell: single precision has more digits there.
///
/// \param spline as in Group: kLimitSpline or the level
/// \param t −½ at the start of the cell, ½ at its end
/// \cite MacCracken & Joy 1996, section 3: regular lattices give tricubic B-splines
template <class Real>
ESPALIER_DEVICE SplinePowers<Real> splinePowers(Index spline, Real t) {
    const Real square = t * t, cube = square * t;
    if (spline == kLimitSpline) return {{Real{1}, t, square, cube}};
    constexpr Real half = Real(0.5);
    const Real segments = static_cast<Real>(Index{1} << spline), h = 1 / segments;
    const Real found = floor((half + t) * segments);
    const Real segment = found < segments ? found : segments - 1;
    const Real r = t + addProduct(half, -(segment + half), h);  // t − m
    const Real e = addProduct(h * h * Real(0.25), -r, r);
    // The curve changes by p · b″ at 0 and by q · b‴.
    const Real p = addProduct(h * h * (Real(-1) / 24), r * Real(-0.5), r);
    const Real q = addProduct(e * (r * (Real(-1) / 3)), t, p);
    return {{Real{1}, t, addProduct(square, Real(2), p), addProduct(cube, Real(6), q)}};
}

/// Converts the columns along one axis to coefficients: Σ coefficient · power is the point.
/// \param p `size` columns; gets coefficientCount(size) coefficients
template <class Real>
ESPALIER_DEVICE void columnsToCoefficients(Index size, Real (&p)[4]) {
    constexpr Real half = Real(0.5);
    if (size == 2) {
        const Real first = p[0];
        p[0] = half * (first + p[1]);
        p[1] = p[1] - first;
        return;
    }
    if (size == 3) {
        p[3] = p[2];
        p[2] = p[1];
        p[1] = p[0];
        p[0] = addProduct(-p[2], Real(2), p[1]);
    }
    const Real inner = p[1] + p[2], outer = p[0] + p[3];
    const Real innerStep = p[2] - p[1], outerStep = p[3] - p[0];
    p[0] = addProduct(inner * (Real(23) / 48), outer, Real(1) / 48);
    p[1] = addProduct(innerStep * (Real(5) / 8), outerStep, Real(1) / 8);
    p[2] = Real(0.25) * (outer - inner);
    p[3] = addProduct(outerStep * (Real(1) / 6), -half, innerStep);
}

/// Computes the weights of the columns along one axis: the transpose of columnsToCoefficients(),
/// applied to the powers. They sum to 1, and their first moment is t plus a constant.
/// \param w gets `size` weights, and 0 for the others
template <class Real>
ESPALIER_DEVICE void splineWeights(Index spline, Index size, Real t, Real (&w)[4]) {
    constexpr Real half = Real(0.5);
    if (size == 2) {
        w[0] = half - t;
        w[1] = half + t;
        w[2] = w[3] = 0;
        return;
    }
    const SplinePowers<Real> powers = splinePowers(spline, t);
    const Real square = Real(0.25) * powers.of[2];
    const Real odd = addProduct(powers.of[3] * (Real(1) / 6), t, Real(1) / 8);
    const Real innerOdd = addProduct(powers.of[3] * -half, t, Real(5) / 8);
    const Real even = Real(1) / 48 + square, innerEven = Real(23) / 48 - square;
    w[0] = even - odd;
    w[1] = innerEven - innerOdd;
    w[2] = innerEven + innerOdd;
    w[3] = even + odd;
    if (size == 3) {
        const Real phantom = w[0];
        w[0] = addProduct(w[1], Real(2), phantom);
        w[1] = w[2] - phantom;
        w[2] = w[3];
        w[3] = 0;
    }
}

}  // namespace espalier::osd::device
