// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/io/directions.h>

#include <cmath>
#include <cstddef>
#include <random>

// Gradients for the tests of directions, and their products by plain loops.

namespace espalier::test {

inline constexpr DeformationGradient kIdentity = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/// Maps x to y and y to -x: a normal (1, 2, 3) becomes (-2, 1, 3), exactly.
inline constexpr DeformationGradient kQuarterTurn = {0, -1, 0, 1, 0, 0, 0, 0, 1};

inline Point3 times(const DeformationGradient& f, const Point3& vector) {
    Point3 result{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) result[i] += f[3 * i + j] * vector[j];
    return result;
}

inline DeformationGradient product(const DeformationGradient& f, const DeformationGradient& g) {
    DeformationGradient result{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < 3; ++k) result[3 * i + j] += f[3 * i + k] * g[3 * k + j];
    return result;
}

/// Returns a rotation, by Rodrigues' formula.
/// \param axis vector of any length
inline DeformationGradient rotation(const Point3& axis, double angle) {
    const double size = std::hypot(axis[0], axis[1], axis[2]);
    const Point3 k = {axis[0] / size, axis[1] / size, axis[2] / size};
    const DeformationGradient skew = {0, -k[2], k[1], k[2], 0, -k[0], -k[1], k[0], 0};
    const DeformationGradient square = product(skew, skew);
    DeformationGradient result = kIdentity;
    for (std::size_t i = 0; i < 9; ++i)
        result[i] += std::sin(angle) * skew[i] + (1 - std::cos(angle)) * square[i];
    return result;
}

/// Returns a gradient with random entries from -1 to 1.
inline DeformationGradient randomGradient(std::mt19937& random) {
    std::uniform_real_distribution<double> entry(-1, 1);
    DeformationGradient result{};
    for (double& value : result) value = entry(random);
    return result;
}

}  // namespace espalier::test
