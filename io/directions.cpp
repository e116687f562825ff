// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/io/directions.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace espalier::io {
namespace {

/// A matrix by rows, and for each entry the sum of the absolute values of its terms.
struct MatrixWithSizes {
    std::array<double, 9> entries;
    std::array<double, 9> sizes;
};

/// Returns the exponent e for which the largest absolute value of the numbers is in [2^e, 2^(e +
/// 1)), or 0 if it is near 1, where products of the numbers are in range without scaling.
template <class Numbers>
int exponentOf(const Numbers& numbers) {
    double largest = 0;
    for (const double number : numbers) largest = std::max(largest, std::abs(number));
    constexpr double kNear = 0x1p100;
    if (largest == 0 || (largest > 1 / kNear && largest < kNear)) return 0;
    return std::ilogb(largest);
}

/// Multiplies the numbers by 2^exponent. The products are exact unless one number is 2^1000 times
/// smaller than another.
template <class Numbers>
Numbers timesPowerOfTwo(Numbers numbers, int exponent) {
    if (exponent == 0) return numbers;
    // In two factors: 2^exponent may exceed the range of doubles. The product by one of them is
    // between the number and the result, so it neither overflows nor rounds before the result does.
    const double half = std::ldexp(1, exponent / 2), rest = std::ldexp(1, exponent - exponent / 2);
    for (double& number : numbers) number = number * half * rest;
    return numbers;
}

MatrixWithSizes gradientMap(const DeformationGradient& f) {
    MatrixWithSizes map{f, f};
    for (double& size : map.sizes) size = std::abs(size);
    return map;
}

MatrixWithSizes cofactorMap(const DeformationGradient& f) {
    MatrixWithSizes map{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            const auto at = [&](std::size_t row, std::size_t column) {
                return f[3 * ((i + row) % 3) + (j + column) % 3];
            };
            // Cyclic indices give the signs of the cofactors.
            const double plus = at(1, 1) * at(2, 2);
            const double minus = at(1, 2) * at(2, 1);
            map.entries[3 * i + j] = plus - minus;
            map.sizes[3 * i + j] = std::abs(plus) + std::abs(minus);
        }
    }
    return map;
}

/// Returns map · direction, scaled to the length of `direction`; zero if the product is only
/// rounding.
Point3 carryBy(const MatrixWithSizes& map, const Point3& direction) {
    // Relative to its terms, the rounding error of an entry (two products) and of the sum over a
    // row is less than this.
    constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
    const int exponent = exponentOf(direction);
    const Point3 from = timesPowerOfTwo(direction, -exponent);
    Point3 to{};
    bool isLost = true;
    for (std::size_t i = 0; i < 3; ++i) {
        double size = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            to[i] += map.entries[3 * i + j] * from[j];
            size += map.sizes[3 * i + j] * std::abs(from[j]);
        }
        isLost = isLost && std::abs(to[i]) <= kRounding * size;
    }
    if (isLost) return direction == Point3{} ? direction : Point3{};
    to = timesPowerOfTwo(to, -exponentOf(to));
    if (to == from) return direction;
    return timesPowerOfTwo(scaled(to, length(from) / length(to)), exponent);
}

DeformationGradient balanced(const DeformationGradient& gradient) {
    return timesPowerOfTwo(gradient, -exponentOf(gradient));
}

}  // namespace

Point3 carryNormal(const DeformationGradient& gradient, const Point3& normal) {
    return carryBy(cofactorMap(balanced(gradient)), normal);
}

Point3 carryTangent(const DeformationGradient& gradient, const Point3& tangent) {
    return carryBy(gradientMap(balanced(gradient)), tangent);
}

}  // namespace espalier::io
