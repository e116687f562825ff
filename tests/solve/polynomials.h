// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solve/bernstein.h"

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

namespace espalier::solve {

/// Returns a polynomial with coefficient(a, b, c) at index a + 3 (b + 3 c).
template <class Coefficient>
Trivariate<2, 1> polynomial(Coefficient coefficient) {
    Trivariate<2, 1> result;
    for (std::size_t i = 0; i < 27; ++i) result[i][0] = coefficient(i % 3, i / 3 % 3, i / 9);
    return result;
}

/// Returns a value computed by definition, to compare with.
template <std::size_t Degree, std::size_t Lanes>
double valueAt(const Trivariate<Degree, Lanes>& polynomials, std::size_t lane,
               const Eigen::Vector3d& uvw) {
    const auto weight = [](std::size_t i, double t) {
        double factor = 1;  // Binomial coefficient of i in Degree.
        for (std::size_t k = 0; k < i; ++k) factor = factor * double(Degree - k) / double(k + 1);
        return factor * std::pow(t, double(i)) * std::pow(1 - t, double(Degree - i));
    };
    double sum = 0;
    for (std::size_t i = 0; i < polynomials.size(); ++i)
        sum += weight(i % (Degree + 1), uvw[0]) * weight(i / (Degree + 1) % (Degree + 1), uvw[1]) *
               weight(i / kAxisStride<Degree>[2], uvw[2]) * polynomials[i][lane];
    return sum;
}

template <class Visit>
void forGrid(int parts, Visit visit) {
    for (int i = 0; i <= parts; ++i)
        for (int j = 0; j <= parts; ++j)
            for (int k = 0; k <= parts; ++k)
                visit(Eigen::Vector3d(Eigen::Vector3d(i, j, k) / parts));
}

}  // namespace espalier::solve
