// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "device_code.h"
#include "device_data.h"

// The weights of one axis of a regular cell, from the parameter of a point: what a row of the form
// without a table is multiplied with (spline_rows.h).
namespace espalier::osd::device {

/// Computes the weights of the columns along one axis, for a point in a cell of a uniform cubic
/// B-spline. They sum to 1, and their first moment is t plus a constant.
///
/// On level n, the point lies on a segment between two neighbouring level-n vertices. The segment
/// from m − h/2 to m + h/2, with h = 2⁻ⁿ, has the weights
///
///     b(t) − (t − m)²/2 · b″ − h²/24 · b″ − (e/3)(t − m) · b‴,   e = h²/4 − (t − m)²
///
/// with b″ at t: level-n vertices are b − h²/6 · b″ at the ends of the segment, and the chord of a
/// cubic is known in closed form. In the limit, h is 0, and b is what remains.
///
/// These are the weights of embed::cubicBSpline(), from a parameter that is 0 in the middle of the
/// cell: single precision has more digits there.
///
/// At a boundary the missing layer of columns is the phantom 2P₀ − P₁: its weight goes to the first
/// two columns.
///
/// \param spline as in Group: kLimitSpline or the level
/// \param size number of columns. 4: inside; 3: a boundary lies before column 0; 2: at both ends
/// \param t −½ at the start of the cell, ½ at its end
/// \param w gets `size` weights, and 0 for the others
/// \cite MacCracken & Joy 1996, section 3: regular lattices give tricubic B-splines
template <class Real>
ESPALIER_DEVICE void splineWeights(Index spline, Index size, Real t, Real (&w)[4]) {
    const Real half = Real(0.5), x = half + t, y = half - t;
    if (size == 2) {
        w[0] = y;
        w[1] = x;
        w[2] = w[3] = 0;
        return;
    }
    const Real xx = x * x, yy = y * y;
    constexpr Real sixth = Real(1) / 6, twoThirds = Real(2) / 3;
    w[0] = yy * (y * sixth);
    w[1] = addProduct(twoThirds, xx, addProduct(Real(-1), x, half));
    w[2] = addProduct(twoThirds, yy, addProduct(Real(-1), y, half));
    w[3] = xx * (x * sixth);
    if (spline != kLimitSpline) {
        const Real segments = static_cast<Real>(Index{1} << spline), h = 1 / segments;
        const Real found = floor(x * segments);
        const Real segment = found < segments ? found : segments - 1;
        const Real r = t + addProduct(half, -(segment + half), h);  // t − m
        const Real e = addProduct(h * h * Real(0.25), -r, r);
        // The weights change by p · b″ at 0 and by q · b‴.
        const Real p = addProduct(h * h * (Real(-1) / 24), r * Real(-0.5), r);
        const Real q = addProduct(e * (r * (Real(-1) / 3)), t, p);
        w[0] = addProduct(w[0], half, p) - q;
        w[1] = addProduct(addProduct(w[1], -half, p), Real(3), q);
        w[2] = addProduct(addProduct(w[2], -half, p), Real(-3), q);
        w[3] = addProduct(w[3], half, p) + q;
    }
    if (size == 3) {
        const Real phantom = w[0];
        w[0] = addProduct(w[1], Real(2), phantom);
        w[1] = w[2] - phantom;
        w[2] = w[3];
        w[3] = 0;
    }
}

}  // namespace espalier::osd::device
