// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/disjoint_sets.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "support/test.h"

namespace espalier {
namespace {

TEST(DisjointSets, JoinsByHand) {
    DisjointSets sets(5);
    EXPECT_EQ(sets.setCount(), 5U);
    sets.join(0, 3);
    sets.join(4, 3);
    sets.join(0, 4);  // in one set already
    EXPECT_EQ(sets.setCount(), 3U);
    EXPECT_EQ(sets.rootOf(0), sets.rootOf(4));
    EXPECT_NE(sets.rootOf(0), sets.rootOf(1));
    EXPECT_NE(sets.rootOf(1), sets.rootOf(2));
    EXPECT_EQ(sets.rootOf(sets.rootOf(3)), sets.rootOf(3));
}

// The reference gives each number the label of its set, and renames a whole set at each join.
TEST(DisjointSets, AgreeWithLabels) {
    constexpr std::size_t kCount = 300;
    std::mt19937 random(1);
    DisjointSets sets(kCount);
    std::vector<std::size_t> labels(kCount);
    std::iota(labels.begin(), labels.end(), std::size_t{0});
    for (std::size_t joins = 0; joins < kCount; ++joins) {
        const std::size_t a = random() % kCount, b = random() % kCount;
        sets.join(a, b);
        std::ranges::replace(labels, std::size_t{labels[a]}, std::size_t{labels[b]});
        const std::size_t c = random() % kCount, d = random() % kCount;
        ASSERT_EQ(sets.rootOf(c) == sets.rootOf(d), labels[c] == labels[d]);
    }
    EXPECT_EQ(sets.setCount(), std::set<std::size_t>(labels.begin(), labels.end()).size());
}

}  // namespace
}  // namespace espalier
