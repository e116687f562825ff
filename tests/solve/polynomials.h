// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/solve/bernstein.h>

#include <Eigen/Core>
#include <cstddef>

namespace espalier::solve {

/// Coefficient a + 3 (b + 3 c) of each polynomial from what makes it up along each axis.
template <class Coefficient>
Triquadratics<1> polynomial(Coefficient coefficient) {
    Triquadratics<1> result;
    for (std::size_t i = 0; i < 27; ++i) result[i][0] = coefficient(i % 3, i / 3 % 3, i / 9);
    return result;
}

/// By the definition, to compare with.
template <std::size_t Lanes>
double valueAt(const Triquadratics<Lanes>& polynomials, std::size_t lane,
               const Eigen::Vector3d& uvw) {
    const auto weight = [](std::size_t i, double t) {
        return i == 0 ? (1 - t) * (1 - t) : i == 1 ? 2 * t * (1 - t) : t * t;
    };
    double sum = 0;
    for (std::size_t i = 0; i < 27; ++i)
        sum += weight(i % 3, uvw[0]) * weight(i / 3 % 3, uvw[1]) * weight(i / 9, uvw[2]) *
               polynomials[i][lane];
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
