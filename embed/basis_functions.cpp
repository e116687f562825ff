// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/basis_functions.h>

#include <algorithm>
#include <cmath>

namespace espalier::embed {
namespace {

AxisFunctions bernstein(Index degree, double at) {
    const double t = at / degree, s = (degree - at) / degree;
    const auto count = static_cast<std::size_t>(degree) + 1;
    std::vector<double> values(count, 0), derivatives(count, 0);
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
    return {0, std::move(values), std::move(derivatives)};
}

AxisFunctions splineFunctions(Index cells, double at) {
    // A knot belongs to the span above it; the last knot, to the span below it.
    const double span = std::clamp(std::floor(at), 1.0, static_cast<double>(cells - 2));
    const auto values = cubicBSpline(at - span, 0), derivatives = cubicBSpline(at - span, 1);
    return {static_cast<Index>(span) - 1,
            {values.begin(), values.end()},
            {derivatives.begin(), derivatives.end()}};
}

}  // namespace

AxisRange axisRange(Basis basis, Index cells) {
    if (basis == Basis::Bezier) return {0, static_cast<double>(cells)};
    return {1, static_cast<double>(cells - 1)};
}

std::array<double, 4> cubicBSpline(double u, int order) {
    const double v = 1 - u;
    switch (order) {
        case 0:
            return {v * v * v / 6, (4 - 3 * u * u * (2 - u)) / 6, (4 - 3 * v * v * (2 - v)) / 6,
                    u * u * u / 6};
        case 1:
            return {-v * v / 2, u * (3 * u - 4) / 2, v * (4 - 3 * v) / 2, u * u / 2};
        default:
            return {v, 3 * u - 2, 3 * v - 2, u};
    }
}

AxisFunctions axisFunctions(Basis basis, Index cells, double at) {
    return basis == Basis::Bezier ? bernstein(cells, at) : splineFunctions(cells, at);
}

}  // namespace espalier::embed
