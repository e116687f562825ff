// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/basis_functions.h>

#include <algorithm>
#include <cmath>

namespace espalier::embed {
namespace {

void bernstein(Index degree, double at, AxisFunctions& result) {
    const double t = at / degree, s = (degree - at) / degree;
    const std::size_t count = Offset{degree} + 1;
    result.first = 0;
    std::vector<double>&values = result.values, &derivatives = result.derivatives;
    values.assign(count, 0);
    derivatives.assign(count, 0);
    values[0] = 1;
    for (std::size_t k = 1; k < count; ++k) {
        // The derivative by t is `degree` times the difference of the polynomials of degree − 1;
        // the derivative by the coordinate at = t · degree is that difference.
        if (k + 1 == count)
            for (std::size_t i = 0; i < count; ++i)
                derivatives[i] = (i > 0 ? values[i - 1] : 0) - values[i];
        for (std::size_t i = k; i > 0; --i) values[i] = s * values[i] + t * values[i - 1];
        values[0] *= s;
    }
}

void splineFunctions(Index cells, double at, AxisFunctions& result) {
    // A knot belongs to the span above it; the last knot, to the span below it.
    const double span = std::clamp(std::floor(at), 1.0, static_cast<double>(cells - 2));
    const auto values = cubicBSpline(at - span, 0), derivatives = cubicBSpline(at - span, 1);
    result.first = static_cast<Index>(span) - 1;
    result.values.assign(values.begin(), values.end());
    result.derivatives.assign(derivatives.begin(), derivatives.end());
}

}  // namespace

AxisRange axisRange(Basis basis, Index cells) {
    if (basis == Basis::Bezier) return {0, static_cast<double>(cells)};
    return {1, static_cast<double>(cells - 1)};
}

OuterWeights outerWeights(double u, const SplineSpan& span) {
    const double v = 1 - u, h = span.spacing;
    // The segment of the polygon starts at `start`, seen from point 0, and at `back`, seen from
    // point 1. The spline itself has segments of length 0.
    double start = u, back = v;
    if (h > 0) {
        start = h * static_cast<double>(static_cast<Index>(std::clamp(u, 0.0, 1 - h) / h));
        back = 1 - h - start;
    }
    OuterWeights result;
    result.lowSlope = -back * (back + h) / 2;
    result.highSlope = start * (start + h) / 2;
    // At a point of a level the quotients are multiples of h³, and exact.
    result.low = back * (back * back - h * h) / 6 - (v - back) * result.lowSlope;
    result.high = start * (start * start - h * h) / 6 + (u - start) * result.highSlope;
    if (!span.hasLow) result.low = result.lowSlope = 0;
    if (!span.hasHigh) result.high = result.highSlope = 0;
    return result;
}

std::array<double, 4> cubicBSpline(double u, int order, const SplineSpan& span) {
    const auto [low, high, lowSlope, highSlope] = outerWeights(u, span);
    switch (order) {
        case 0:
            return {low, 1 - u - 2 * low + high, u + low - 2 * high, high};
        case 1:
            return {lowSlope, highSlope - 2 * lowSlope - 1, 1 + lowSlope - 2 * highSlope,
                    highSlope};
        default: {
            const double lowBend = span.hasLow ? 1 - u : 0, highBend = span.hasHigh ? u : 0;
            return {lowBend, highBend - 2 * lowBend, lowBend - 2 * highBend, highBend};
        }
    }
}

AxisFunctions axisFunctions(Basis basis, Index cells, double at) {
    AxisFunctions result;
    axisFunctions(basis, cells, at, result);
    return result;
}

void axisFunctions(Basis basis, Index cells, double at, AxisFunctions& result) {
    if (basis == Basis::Bezier)
        bernstein(cells, at, result);
    else
        splineFunctions(cells, at, result);
}

}  // namespace espalier::embed
