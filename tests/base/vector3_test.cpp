// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>

#include <cmath>
#include <limits>

#include "support/test.h"

namespace espalier {
namespace {

// (3, 0, -4) has length 5. The smallest denormal and the largest double are lengths, too: the
// inverse of the one overflows, the sum of the squares of the other.
TEST(Normalised, OfAnyLength) {
    for (const int exponent : {-1072, -1030, -900, -1, 0, 1, 900, 1020}) {
        const Point3 unit = normalised({std::scalbn(3, exponent), 0, std::scalbn(-4, exponent)});
        // Each number is rounded twice.
        EXPECT_DOUBLE_EQ(unit[0], 0.6) << exponent;
        EXPECT_EQ(unit[1], 0) << exponent;
        EXPECT_DOUBLE_EQ(unit[2], -0.8) << exponent;
    }
    const double least = std::numeric_limits<double>::denorm_min();
    EXPECT_EQ(normalised({0, 0, -least}), (Point3{0, 0, -1}));
    const double most = std::numeric_limits<double>::max();
    for (const double number : normalised({most, -most, most}))
        EXPECT_DOUBLE_EQ(std::abs(number), 1 / std::sqrt(3.0));
}

}  // namespace
}  // namespace espalier
