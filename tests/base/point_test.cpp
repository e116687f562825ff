// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/point.h>

#include <cmath>
#include <limits>

#include "support/test.h"

namespace espalier {
namespace {

TEST(Point, LengthsOfKnownVectors) {
    EXPECT_EQ(length({0, 0, 0}), 0);
    EXPECT_EQ(length({-3, 4, 12}), 13);
    EXPECT_EQ(length({0, 0, -0x1p-1074}), 0x1p-1074);
    // The squares are above the largest double, and below the least.
    EXPECT_EQ(length({0x3p700, 0x4p700, 0}), 0x5p700);
    EXPECT_EQ(length({0x3p-700, 0, 0x4p-700}), 0x5p-700);
}

TEST(Point, LengthsHaveTheSameBitsEverywhere) {
    // sqrt(0.14) = 0.374165738677394…, off by the rounding of the steps: recorded with GCC on
    // x86-64. It reveals another order of the steps, and products that are fused.
    EXPECT_EQ(length({0.1, 0.2, 0.3}), 0x1.7f254dab9cc3bp-2);
}

TEST(Point, LengthsOfVectorsThatAreNotFinite) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Point3& vector : {Point3{nan, 0, 0}, Point3{0, nan, 0}, Point3{1, 2, nan}})
        EXPECT_TRUE(std::isnan(length(vector)));
    // The difference of two positions may overflow. It must not pass as short.
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(length({1, -infinity, 2}), infinity);
}

}  // namespace
}  // namespace espalier
