// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/sort_unique.h>

#include <numeric>
#include <random>
#include <vector>

#include "support/test.h"

namespace espalier {
namespace {

TEST(RepeatedIn, NamesTheSmallest) {
    EXPECT_EQ(repeatedIn(std::vector<Index>{}), std::nullopt);
    EXPECT_EQ(repeatedIn(std::vector<Index>{7}), std::nullopt);
    EXPECT_EQ(repeatedIn(std::vector<Index>{7, 2, 9}), std::nullopt);
    EXPECT_EQ(repeatedIn(std::vector<Index>{7, 2, 9, 7, 2}), 2);
}

// Short lists and long ones are searched in different ways.
TEST(RepeatedIn, FindsOneRepeatedNumberAmongAny) {
    std::mt19937 random(1);
    for (const std::size_t size : {2, 15, 16, 17, 18, 40}) {
        std::vector<Index> numbers(size);
        std::iota(numbers.begin(), numbers.end(), Index{-3});
        std::shuffle(numbers.begin(), numbers.end(), random);
        EXPECT_EQ(repeatedIn(numbers), std::nullopt) << size;
        numbers.front() = numbers.back();
        EXPECT_EQ(repeatedIn(numbers), numbers.back()) << size;
    }
}

}  // namespace
}  // namespace espalier
