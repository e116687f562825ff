// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bernstein.h"

// What Bernstein polynomials are proved to be above: by their coefficients, after halving the cube
// as often as need be, within limits. So "no" may also mean that it could not be proved. For the
// degrees of determinants, 2 and 8.

namespace espalier::solve {

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
