// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/base/word.h>

#include <array>
#include <optional>
#include <vector>

namespace espalier::embed {

/// The functions by which the points of a box lattice were weighed before there was subdivision.
enum class Basis {
    Bezier,  ///< Bernstein polynomials over the whole lattice (Sederberg & Parry 1986)
    BSpline  ///< uniform cubic B-splines (Griessmair & Purgathofer 1989)
};

/// What a lattice weighs points by: a basis, or its subdivision.
inline constexpr Word<std::optional<Basis>> kBasisWords[] = {
    {"subdivision", std::nullopt}, {"bezier", Basis::Bezier}, {"bspline", Basis::BSpline}};

/// A range of places along an axis of n cells, which runs from 0 to n.
struct AxisRange {
    double low = 0, high = 0;
};

/// Where the functions of an axis add up to 1: all of it for Bernstein polynomials; 1 to cells − 1
/// for B-splines, which is what Boundary::Open leaves in the limit.
ESPALIER_API AxisRange axisRange(Basis basis, Index cells);

/// The functions of successive grid points of an axis at one place; all others are 0 there.
struct AxisFunctions {
    Index first = 0;                       ///< grid point of the first of them
    std::vector<double> values = {};       ///< they sum to 1
    std::vector<double> derivatives = {};  ///< by the place, in cells; they sum to 0
};

/// The four pieces of the uniform cubic B-spline in one span, or their derivatives: the weights of
/// points −1, 0, 1 and 2 between points 0 and 1.
/// \param u 0 to 1; beyond, the polynomials go on
/// \param order of the derivative by u: 0, 1 or 2
/// \cite Joy, bicubic refinement: [1 u u² u³] M
ESPALIER_API std::array<double, 4> cubicBSpline(double u, int order);

/// Bézier: the `cells` + 1 Bernstein polynomials of degree `cells` at the parameter at / cells,
/// added up by de Casteljau's scheme: nothing cancels, so that values keep double precision at any
/// degree, and sums are off by no more than 2e-16 a degree. B-spline: the four of [1 u u² u³] M.
///
/// \param at in axisRange(basis, cells), which must not be empty
/// \cost Bézier O(cells²), B-spline constant
/// \cite MacCracken & Joy 1996, section 4, on Sederberg & Parry; Joy, bicubic refinement, for M
ESPALIER_API AxisFunctions axisFunctions(Basis basis, Index cells, double at);

}  // namespace espalier::embed
