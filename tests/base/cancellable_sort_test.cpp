// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/cancellable_sort.h>

#include <chrono>
#include <random>
#include <utility>
#include <vector>

#include "support/test.h"

namespace espalier {
namespace {

using namespace std::chrono_literals;

/// Pairs of which many are equal by their first number.
std::vector<std::pair<int, int>> pairs() {
    std::mt19937 random(1);
    std::vector<std::pair<int, int>> result;
    for (int i = 0; i < 100'000; ++i) result.emplace_back(random() % 1000, i);
    return result;
}

bool isFirstLess(const std::pair<int, int>& a, const std::pair<int, int>& b) {
    return a.first < b.first;
}

TEST(CancellableSort, HasTheOrderOfTheStandardSort) {
    auto expected = pairs(), sorted = pairs();
    std::sort(expected.begin(), expected.end(), isFirstLess);
    sortCancellably(sorted.begin(), sorted.end(), isFirstLess);
    EXPECT_EQ(sorted, expected);  // equal pairs, too, are in the same order

    expected = sorted = pairs();
    std::stable_sort(expected.begin(), expected.end(), isFirstLess);
    stableSortCancellably(sorted.begin(), sorted.end(), isFirstLess);
    EXPECT_EQ(sorted, expected);

    expected = sorted = pairs();
    std::ranges::sort(expected);
    sortCancellably(sorted.begin(), sorted.end());
    EXPECT_EQ(sorted, expected);
}

TEST(CancellableSort, CanBeCancelled) {
    int calls = 0;
    const auto sortAll = [&] {
        auto numbers = pairs();
        sortCancellably(numbers.begin(), numbers.end());
        stableSortCancellably(numbers.begin(), numbers.end());
    };
    {
        const ProgressScope scope([&](const Progress&) { return ++calls > 0; }, 0ms);
        sortAll();
    }
    // Sorting 100,000 elements takes at least log2(100,000!) = 1.5 million comparisons, 23 times
    // 2^16; the second sort, of a sorted list, takes a few.
    EXPECT_GE(calls, 23);
    const int all = std::exchange(calls, 0);
    const ProgressScope scope([&](const Progress&) { return ++calls < all / 2; }, 0ms);
    EXPECT_THROW(sortAll(), Cancelled);
    EXPECT_EQ(calls, all / 2);
}

}  // namespace
}  // namespace espalier
