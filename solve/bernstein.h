// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>

#include <array>
#include <cstddef>
#include <utility>

// Jacobian determinants as Bernstein polynomials: that of a trilinear map is of degree (2, 2, 2) in
// (u, v, w), with 27 coefficients, that of a tricubic one of degree (8, 8, 8), with 729. All values
// lie between the least and the greatest, and those at the corners are values themselves; halving
// the cube closes the gap, by a fourth each time. So "positive in the whole cell" can be proved,
// where samples can only suggest it.

// What Bernstein polynomials are proved to be above: by their coefficients, after halving the cube
// as often as need be, within limits. So "no" may also mean that it could not be proved. For the
// degrees of determinants, 2 and 8.

namespace espalier::solve {

/// So many polynomials of a degree along each axis, by their Bernstein coefficients: coefficient
/// (a, b, c) of each is at a + n (b + n c), n being Degree + 1.
template <std::size_t Degree, std::size_t Lanes>
struct Trivariate
    : std::array<std::array<double, Lanes>, (Degree + 1) * (Degree + 1) * (Degree + 1)> {};

/// From one coefficient to the next along an axis.
template <std::size_t Degree>
inline constexpr std::array<std::size_t, 3> kAxisStride = {1, Degree + 1,
                                                           (Degree + 1) * (Degree + 1)};

/// The coefficients that are values, at the corners of the cube.
template <std::size_t Degree>
inline constexpr std::array<std::size_t, 8> kCornerCoefficients = [] {
    std::array<std::size_t, 8> result{};
    for (std::size_t corner = 0; corner < 8; ++corner)
        for (std::size_t axis = 0; axis < 3; ++axis)
            result[corner] += (corner >> axis & 1) * Degree * kAxisStride<Degree>[axis];
    return result;
}();

/// The derivatives by u, v and w of a map of a degree along each axis, by Bernstein coefficients:
/// one fewer along its own axis than along the others. Those of each are in order of places along
/// u, then v, then w.
template <std::size_t Degree>
struct Derivatives : std::array<std::array<Point3, Degree*(Degree + 1) * (Degree + 1)>, 3> {};

/// A determinant has three factors, one of each derivative.
template <std::size_t Degree>
inline constexpr std::size_t kDeterminantDegree = 3 * Degree - 1;

/// The determinant of the Jacobian. For maps of degree 1 and 3.
template <std::size_t Degree>
Trivariate<kDeterminantDegree<Degree>, 1> determinant(const Derivatives<Degree>& derivatives);

/// The same while the map goes over from one to another linearly: cubic in that, too. Lane m is
/// Bernstein coefficient m of degree 3; lanes 0 and 3 are the determinants at the ends.
template <std::size_t Degree>
Trivariate<kDeterminantDegree<Degree>, 4> determinant(const Derivatives<Degree>& first,
                                                      const Derivatives<Degree>& last);

/// The coefficients on the lower and on the upper half of an axis, by de Casteljau.
template <std::size_t Degree, std::size_t Lanes>
std::pair<Trivariate<Degree, Lanes>, Trivariate<Degree, Lanes>> halves(
    const Trivariate<Degree, Lanes>& polynomials, std::size_t axis);

/// A polynomial up to a time between 0 and 1, and from there on.
template <std::size_t Degree>
std::pair<Trivariate<Degree, 4>, Trivariate<Degree, 4>> partsInTime(
    const Trivariate<Degree, 4>& polynomial, double time);

/// Whether a polynomial is proved to be above 0 in the whole cube. It is not where a value inside
/// comes within 1e-5 or so of 0, in parts of the largest coefficient.
///
/// \cost one look at the coefficients where that will do, as it mostly does; at most 1,000
template <std::size_t Degree>
bool isPositive(const Trivariate<Degree, 1>& polynomial);

/// A lower bound of the quotient of two polynomials, the first and the second lane. Its sign is
/// that of the least value, where it can be proved, and else not positive; its distance from the
/// least value is at most a thousandth of it, or 1e-6, where 2,000 halvings can bring that about.
///
/// \param quotient the second is positive, as isPositive() has it
/// \cost 4,000 looks at the coefficients at most: 2 ms for degree 2
template <std::size_t Degree>
double leastQuotient(const Trivariate<Degree, 2>& quotient);

/// Until when a polynomial is proved to be above 0 in the whole cube.
struct ProvedTime {
    double time = 0;

    /// Whether it is not above 0 somewhere by a millionth of the time later, or by 1e-12; or the
    /// time is all that was asked for. If not, 2,000 halvings of the cube and of time, the earliest
    /// parts first, did not tell what comes next.
    bool isTight = true;
};

/// \param upTo above 0, at most 1
/// \cost one look at the coefficients where that will do; at most 4,000: 4 ms for degree 2
template <std::size_t Degree>
ProvedTime positiveUpTo(const Trivariate<Degree, 4>& polynomial, double upTo);

}  // namespace espalier::solve
