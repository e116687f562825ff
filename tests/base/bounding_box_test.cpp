// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>

#include <vector>

#include "support/test.h"

namespace espalier {
namespace {

TEST(BoundingBox, HoldsAllPoints) {
    const std::vector<Point3> points = {{1, 5, -2}, {3, 4, -2}, {2, 6, -4}};
    BoundingBox box(points);
    EXPECT_EQ(box.min, (Point3{1, 4, -4}));
    EXPECT_EQ(box.max, (Point3{3, 6, -2}));
    EXPECT_EQ(box.size(), (Point3{2, 2, 2}));
    box.include({1, 5, -5});
    EXPECT_EQ(box.size(), (Point3{2, 2, 3}));
    EXPECT_EQ(BoundingBox({0, 0, 0}, {2, 1, 2}).diagonal(), 3);
}

TEST(BoundingBox, ContainsItsSurface) {
    const BoundingBox box({0, 0, 0}, {1, 2, 3});
    EXPECT_TRUE(box.contains({1, 0, 3}));
    EXPECT_FALSE(box.contains({std::nextafter(1, 2), 0, 3}));
    EXPECT_FALSE(box.contains({0.5, -1e-300, 1}));
    EXPECT_FALSE(box.contains({0.5, 1, std::numeric_limits<double>::quiet_NaN()}));
}

TEST(BoundingBox, WithoutPointsHasNoSize) {
    const BoundingBox box;
    EXPECT_EQ(box.size(), (Point3{0, 0, 0}));
    EXPECT_EQ(box.diagonal(), 0);
    EXPECT_FALSE(box.contains({0, 0, 0}));
}

}  // namespace
}  // namespace espalier
