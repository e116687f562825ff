// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/sort_unique.h>

#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "support/test.h"

namespace espalier {
namespace {

// Dense lists, sparse lists and short lists are sorted in different ways.
TEST(SortUnique, SortsAndRemovesDuplicates) {
    std::mt19937 random(1);
    for (const std::size_t size : {0, 1, 2, 32, 33, 64, 1000})
        for (const Index span : {1, 3, 64, 65, 5000, 64'000, 70'000, 1 << 30}) {
            std::vector<Index> numbers(size);
            for (Index& number : numbers) number = static_cast<Index>(random() % span) - span / 2;
            const std::set<Index> expected(numbers.begin(), numbers.end());
            sortUnique(numbers);
            EXPECT_TRUE(std::ranges::equal(numbers, expected)) << size << " in " << span;
        }
    std::vector<Index> extremes(40, kMaxIndex);
    extremes[7] = -kMaxIndex - 1;
    sortUnique(extremes);
    EXPECT_EQ(extremes, (std::vector<Index>{-kMaxIndex - 1, kMaxIndex}));
}

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
