// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/word.h>

#include <array>
#include <optional>
#include <vector>

namespace espalier::embed {

/// Basis functions that free-form deformation used before subdivision.
enum class Basis {
    Bezier,  ///< Bernstein polynomials over the whole lattice (Sederberg & Parry 1986)
    BSpline  ///< uniform cubic B-splines (Griessmair & Purgathofer 1989)
};

/// Names of the ways to weight the vertices of a lattice: subdivision (nullopt) or a basis.
inline constexpr Word<std::optional<Basis>> kBasisWords[] = {
    {"subdivision", std::nullopt}, {"bezier", Basis::Bezier}, {"bspline", Basis::BSpline}};

/// A range of coordinates along an axis of n cells, which runs from 0 to n.
struct AxisRange {
    double low = 0, high = 0;
};

/// Returns where the basis functions of an axis sum to 1: everywhere for Bernstein polynomials;
/// from 1 to cells − 1 for B-splines, which is the region that remains in the limit under
/// Boundary::Open.
ESPALIER_API AxisRange axisRange(Basis basis, Index cells);

/// The basis functions of consecutive grid points of an axis at one coordinate; all others are 0
/// there.
struct AxisFunctions {
    Index first = 0;                  ///< grid point of the first function
    std::vector<double> values = {};  ///< they sum to 1
    /// Derivatives by the coordinate, in cells; they sum to 0.
    std::vector<double> derivatives = {};
};

/// A span of a uniform cubic B-spline, between points 0 and 1.
struct SplineSpan {
    /// True if the span has a point −1 (hasLow), and a point 2 (hasHigh). At a boundary the spline
    /// lacks one of them, and uses the point 2P₀ − P₁ instead: P₀ is the next point, and P₁ the
    /// point after it.
    bool hasLow = true, hasHigh = true;
    /// 0 for the spline itself. 2⁻ⁿ for level n of its refinement: the polygon of the level-n
    /// points, which are `spacing` apart.
    double spacing = 0;
};

/// The weights of points −1 and 2 for a place in a span, and their derivatives.
struct OuterWeights {
    double low, high;
    double lowSlope, highSlope;
};

/// Returns the outer weights: u³/6 for point 2. At a level-n point it is u (u² − h²)/6 with h =
/// 2⁻ⁿ, because this point is b − h²/6 · b″ of the spline b. A missing point has the weight 0,
/// exactly.
/// \param u 0 to 1; beyond, the polynomials are extrapolated
ESPALIER_API OuterWeights outerWeights(double u, const SplineSpan& span);

/// Returns the weights of points −1, 0, 1 and 2 for a place in a span, or their derivatives. The
/// weights of the position sum to 1.
///
/// Along a span, a spline is a line plus multiples of two cubics, one for each end: with the
/// weights w₋₁ and w₂ of the outer points, w₀ = 1 − u − 2w₋₁ + w₂ and w₁ = u + w₋₁ − 2w₂.
///
/// \param order of the derivative by u: 0, 1, or, for the spline itself, 2
/// \cite Joy, bicubic refinement: [1 u u² u³] M; MacCracken & Joy 1996, section 2.2
ESPALIER_API std::array<double, 4> cubicBSpline(double u, int order, const SplineSpan& span = {});

/// Returns the basis functions at a coordinate.
///
/// Bézier: the `cells` + 1 Bernstein polynomials of degree `cells` at the parameter at / cells,
/// computed by de Casteljau's scheme. Nothing cancels in it, so values keep double precision at any
/// degree; sums are off by at most 2e-16 per degree. B-spline: the four functions [1 u u² u³] M.
///
/// \param at in axisRange(basis, cells), which must not be empty
/// \cost Bézier O(cells²), B-spline constant
/// \cite MacCracken & Joy 1996, section 4, on Sederberg & Parry; Joy, bicubic refinement, for M
ESPALIER_API AxisFunctions axisFunctions(Basis basis, Index cells, double at);

/// Does the same in existing memory.
ESPALIER_API void axisFunctions(Basis basis, Index cells, double at, AxisFunctions& result);

}  // namespace espalier::embed
