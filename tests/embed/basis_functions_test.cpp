// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/basis_functions.h>

#include "support/test.h"

namespace espalier::embed {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

double sumOf(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

// (1 − t, t) at t = 1/4; ((1 − t)², 2t(1 − t), t²) at t = 1/2. Its derivatives by t are (−2(1 − t),
// 2 − 4t, 2t), and t is half the coordinate.
TEST(BasisFunctions, BernsteinPolynomialsByHand) {
    const AxisFunctions linear = axisFunctions(Basis::Bezier, 1, 0.25);
    EXPECT_EQ(linear.first, 0);
    EXPECT_THAT(linear.values, ElementsAre(0.75, 0.25));
    EXPECT_THAT(linear.derivatives, ElementsAre(-1, 1));
    const AxisFunctions quadratic = axisFunctions(Basis::Bezier, 2, 1);
    EXPECT_THAT(quadratic.values, ElementsAre(0.25, 0.5, 0.25));
    EXPECT_THAT(quadratic.derivatives, ElementsAre(-0.5, 0, 0.5));
}

/// Returns C(n, i) tⁱ (1 − t)ⁿ⁻ⁱ by definition.
long double bernstein(Index degree, Index i, long double t) {
    if (i < 0 || i > degree) return 0;
    long double value = 1;
    for (Index k = 1; k <= i; ++k)
        value *= static_cast<long double>(degree - i + k) / static_cast<long double>(k) * t;
    for (Index k = i; k < degree; ++k) value *= 1 - t;
    return value;
}

TEST(BasisFunctions, BernsteinPolynomialsAgreeWithTheDefinitionAtAnyDegree) {
    for (const Index degree : {1, 2, 3, 7, 20, 100})
        for (const double t : {0.0, 1e-3, 0.25, 0.3, 0.5, 0.77, 0.999, 1.0}) {
            const double at = t * degree;
            const AxisFunctions functions = axisFunctions(Basis::Bezier, degree, at);
            ASSERT_EQ(functions.values.size(), std::size_t(degree) + 1);
            for (Index i = 0; i <= degree; ++i) {
                const long double exact = static_cast<long double>(at) / degree;
                const double value = functions.values[i];
                const auto expected = double(bernstein(degree, i, exact));
                // Nothing cancels: each degree rounds two products, their sum, t and 1 − t by half
                // an epsilon each. Numbers below 1e-290 do not have full precision.
                EXPECT_NEAR(value, expected, 2.5 * degree * kEpsilon * expected + 1e-290);
                const auto slope =
                    double(bernstein(degree - 1, i - 1, exact) - bernstein(degree - 1, i, exact));
                // The slope is a difference of two such values, both below 1.
                EXPECT_NEAR(functions.derivatives[i], slope, 5 * degree * kEpsilon);
            }
            // t and 1 − t are rounded once per degree.
            EXPECT_NEAR(sumOf(functions.values), 1, degree * kEpsilon);
            EXPECT_NEAR(sumOf(functions.derivatives), 0, degree * kEpsilon);
        }
}

/// 6 M (Joy, bicubic refinement): rows are for 1, u, u² and u³, columns for control points.
constexpr std::array<std::array<double, 4>, 4> kSixM = {
    {{1, 4, 1, 0}, {-3, 0, 3, 0}, {3, -6, 3, 0}, {-1, 3, -3, 1}}};

TEST(BasisFunctions, BSplinesAgreeWithTheMatrixM) {
    const Index cells = 5;
    for (Index span = 1; span <= 3; ++span)
        for (const double u : {0.0, 0.125, 0.5, 0.9, 1.0}) {
            // The end of each span but the last is the start of the next.
            if (u == 1 && span < 3) continue;
            const AxisFunctions functions = axisFunctions(Basis::BSpline, cells, span + u);
            EXPECT_EQ(functions.first, span - 1);
            ASSERT_EQ(functions.values.size(), 4u);
            for (std::size_t i = 0; i < 4; ++i) {
                const double value =
                    kSixM[0][i] + u * (kSixM[1][i] + u * (kSixM[2][i] + u * kSixM[3][i]));
                const double slope = kSixM[1][i] + u * (2 * kSixM[2][i] + u * 3 * kSixM[3][i]);
                // span + u is rounded by 2e-16, and the terms are below 12.
                EXPECT_NEAR(functions.values[i], value / 6, 1e-15);
                EXPECT_NEAR(functions.derivatives[i], slope / 6, 1e-15);
            }
            EXPECT_NEAR(sumOf(functions.values), 1, 4 * kEpsilon);
            EXPECT_NEAR(sumOf(functions.derivatives), 0, 4 * kEpsilon);
        }
}

TEST(BasisFunctions, RangesAreWhereFunctionsSumToOne) {
    EXPECT_EQ(axisRange(Basis::Bezier, 4).low, 0);
    EXPECT_EQ(axisRange(Basis::Bezier, 4).high, 4);
    EXPECT_EQ(axisRange(Basis::BSpline, 4).low, 1);
    EXPECT_EQ(axisRange(Basis::BSpline, 4).high, 3);
}

/// Refines a polygon of a curve: points become (P₋₁ + 6P₀ + P₁)/8, and the middles of its edges
/// follow them.
std::vector<double> refinedCurve(const std::vector<double>& points) {
    std::vector<double> result;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        result.push_back((points[i - 1] + 6 * points[i] + points[i + 1]) / 8);
        result.push_back((points[i] + points[i + 1]) / 2);
    }
    return result;
}

// The weights on level n are the polygon that refinement makes of one point, and in the limit the
// spline. A missing point is 2P₀ − P₁.
TEST(BasisFunctions, SpansOfRefinedCurves) {
    for (const bool hasLow : {true, false})
        for (const bool hasHigh : {true, false})
            for (int level = 0; level <= 6; ++level) {
                const double h = std::ldexp(1, -level);
                for (std::size_t which = 0; which < 4; ++which) {
                    // Points −3 to 4, of which refinement keeps the span from 0 to 1.
                    std::vector<double> points(8, 0.0);
                    points[which + 2] = 1;
                    if (!hasLow) points[2] = 2 * points[3] - points[4];
                    if (!hasHigh) points[5] = 2 * points[4] - points[3];
                    if ((which == 0 && !hasLow) || (which == 3 && !hasHigh)) continue;
                    std::size_t zero = 3;
                    for (int k = 0; k < level; ++k) {
                        points = refinedCurve(points);
                        zero = 2 * (zero - 1);
                    }
                    const auto count = static_cast<std::size_t>(1) << level;
                    for (std::size_t i = 0; i < count; ++i)
                        for (const double t : {0.0, 0.25, 0.7, 1.0}) {
                            const double u = h * (double(i) + t);
                            const double a = points[zero + i], b = points[zero + i + 1];
                            const SplineSpan span{hasLow, hasHigh, h};
                            EXPECT_NEAR(cubicBSpline(u, 0, span)[which], a + t * (b - a),
                                        4 * kEpsilon);
                            if (t > 0 && t < 1) {
                                // A difference of two numbers below 1, divided by h.
                                EXPECT_NEAR(cubicBSpline(u, 1, span)[which], (b - a) / h,
                                            4 * kEpsilon / h);
                            }
                            // Both are dyadic.
                            if (t == 0) {
                                EXPECT_EQ(cubicBSpline(u, 0, span)[which], a);
                            }
                            // A level is within h²/6 · |b″| of the limit, and the polygon within
                            // h²/8 · |b″|; |b″| is at most 2.
                            EXPECT_NEAR(cubicBSpline(u, 0, {hasLow, hasHigh})[which],
                                        a + t * (b - a), h * h * (1.0 / 3 + 1.0 / 4));
                        }
                }
                const auto all = cubicBSpline(0.3, 0, {hasLow, hasHigh, h});
                EXPECT_NEAR(all[0] + all[1] + all[2] + all[3], 1, kEpsilon);
                if (!hasLow) {
                    EXPECT_EQ(all[0], 0);
                }
                if (!hasHigh) {
                    EXPECT_EQ(all[3], 0);
                }
            }
}

}  // namespace
}  // namespace espalier::embed
