// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/base/vector3.h>

#include <array>
#include <cstddef>
#include <utility>

// Jacobian determinants as Bernstein polynomials, and proofs that they are positive.
//
// The determinant of a linear map, of a tetrahedron, is constant. The determinant of a trilinear
// map has degree (2, 2, 2) in (u, v, w) and 27 coefficients; of a triquadratic map (5, 5, 5) and
// 216; of a tricubic map (8, 8, 8) and 729. All values in the cube are between the smallest and the
// largest coefficient, and the coefficients at the corners are values. Each halving of the cube
// reduces the gap between coefficients and values to a fourth. So the coefficients can prove that a
// determinant is positive in the whole cell, which samples can only suggest.
//
// The proofs halve the cube until the coefficients decide, up to a limit. An answer "no" may
// therefore also mean that no proof was found.

namespace espalier::solve {

/// `Lanes` polynomials of one degree along each axis, as Bernstein coefficients. Coefficient (a, b,
/// c) of each is at index a + n (b + n c), with n = Degree + 1.
template <std::size_t Degree, std::size_t Lanes>
struct Trivariate
    : std::array<std::array<double, Lanes>, (Degree + 1) * (Degree + 1) * (Degree + 1)> {};

/// Distance of the indices of neighbouring coefficients along each axis.
template <std::size_t Degree>
inline constexpr std::array<std::size_t, 3> kAxisStride = {1, Degree + 1,
                                                           (Degree + 1) * (Degree + 1)};

/// Indices of the coefficients at the corners of the cube, which are values of the polynomial.
template <std::size_t Degree>
inline constexpr std::array<std::size_t, 8> kCornerCoefficients = [] {
    std::array<std::size_t, 8> result{};
    for (std::size_t corner = 0; corner < 8; ++corner)
        for (std::size_t axis = 0; axis < 3; ++axis)
            result[corner] += (corner >> axis & 1) * Degree * kAxisStride<Degree>[axis];
    return result;
}();

/// Bernstein coefficients of the derivatives by u, v and w of a map with one degree along each
/// axis. A derivative has one coefficient fewer along its own axis. Coefficients are ordered by
/// their index along u, then v, then w. Degree 0 stands for linear maps, whose derivatives are
/// constant.
template <std::size_t Degree>
struct Derivatives : std::array<std::array<Point3, Degree*(Degree + 1) * (Degree + 1)>, 3> {};
template <>
struct Derivatives<0> : std::array<std::array<Point3, 1>, 3> {};

/// Degree of the determinant: it has one factor from each derivative.
template <std::size_t Degree>
inline constexpr std::size_t kDeterminantDegree = Degree == 0 ? 0 : 3 * Degree - 1;

/// Returns the determinant of the Jacobian, for maps of degree 0 to 3.
template <std::size_t Degree>
Trivariate<kDeterminantDegree<Degree>, 1> determinant(const Derivatives<Degree>& derivatives);

/// Returns the determinant of the Jacobian while the map changes linearly from `first` to `last`.
/// It is cubic in time: lane m is Bernstein coefficient m of degree 3, so lanes 0 and 3 are the
/// determinants of `first` and `last`.
template <std::size_t Degree>
Trivariate<kDeterminantDegree<Degree>, 4> determinant(const Derivatives<Degree>& first,
                                                      const Derivatives<Degree>& last);

// Inline, because a million polyhedra have tens of millions of tetrahedra.
template <>
inline Trivariate<0, 1> determinant(const Derivatives<0>& derivatives) {
    Trivariate<0, 1> result;
    result[0][0] = dot(derivatives[0][0], cross(derivatives[1][0], derivatives[2][0]));
    return result;
}

template <>
inline Trivariate<0, 4> determinant(const Derivatives<0>& first, const Derivatives<0>& last) {
    const Point3 &u = first[0][0], &v = first[1][0], &w = first[2][0];
    const Point3 &x = last[0][0], &y = last[1][0], &z = last[2][0];
    const Point3 vw = cross(v, w), yz = cross(y, z), mixed = sum(cross(y, w), cross(v, z));
    Trivariate<0, 4> result;
    result[0] = {dot(u, vw), (dot(x, vw) + dot(u, mixed)) / 3, (dot(u, yz) + dot(x, mixed)) / 3,
                 dot(x, yz)};
    return result;
}

/// Splits polynomials into the lower and the upper half of an axis, by de Casteljau's algorithm.
template <std::size_t Degree, std::size_t Lanes>
std::pair<Trivariate<Degree, Lanes>, Trivariate<Degree, Lanes>> halves(
    const Trivariate<Degree, Lanes>& polynomials, std::size_t axis);

/// Splits a polynomial at a time between 0 and 1.
template <std::size_t Degree>
std::pair<Trivariate<Degree, 4>, Trivariate<Degree, 4>> partsInTime(
    const Trivariate<Degree, 4>& polynomial, double time);

/// Returns true if the polynomial is proved to be positive in the whole cube. Returns false where a
/// value comes within about 1e-5 of 0, relative to the largest coefficient.
///
/// \cost usually one pass over the coefficients; at most 1,000 passes
template <std::size_t Degree>
bool isPositive(const Trivariate<Degree, 1>& polynomial);

/// Returns a lower bound of the quotient of two polynomials, the first lane over the second. The
/// bound is positive only if the quotient is. If the quotient is positive and this can be proved,
/// the bound is positive. The bound is below the smallest value by at most 0.1 % of it or 1e-6,
/// unless 2,000 halvings do not suffice.
///
/// \param quotient its second lane must be positive in the sense of isPositive()
/// \cost at most 4,000 passes over the coefficients: 2 ms for degree 2
template <std::size_t Degree>
double leastQuotient(const Trivariate<Degree, 2>& quotient);

/// The time up to which a polynomial is proved to be positive in the whole cube.
struct ProvedTime {
    double time = 0;

    /// True if the polynomial is not positive somewhere shortly after `time`, by a millionth of it
    /// or 1e-12; or if `time` is all that was requested. False if 2,000 halvings of the cube and of
    /// time, which start with the earliest parts, did not decide what happens after `time`.
    bool isTight = true;
};

/// Returns the first root in time of a cubic that is positive before it, or a time at most two
/// roundings before the root; `upTo` if the cubic is positive up to there; 0 if it is not positive
/// at 0.
///
/// \param coefficients Bernstein coefficients of degree 3 over the times 0 to 1
/// \param upTo above 0, at most 1
double firstRoot(const std::array<double, 4>& coefficients, double upTo);

/// Finds the time up to which a polynomial is proved to be positive. Where a corner of the cube
/// ends this time, as it usually does, the time is the firstRoot() there within 1e-12.
///
/// \param upTo above 0, at most 1
/// \cost usually one pass over the coefficients; at most 4,000 passes: 4 ms for degree 2
template <std::size_t Degree>
ProvedTime positiveUpTo(const Trivariate<Degree, 4>& polynomial, double upTo);

}  // namespace espalier::solve
