// SPDX-License-Identifier: Apache-2.0
#include "cages/ranked_bits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "cages/bins.h"

namespace espalier::cages {
namespace {

std::vector<std::size_t> randomNumbers(std::size_t size, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < count; ++i)
        numbers.push_back(std::uniform_int_distribution<std::size_t>(0, size - 1)(random));
    std::ranges::sort(numbers);
    const auto same = std::ranges::unique(numbers);
    numbers.erase(same.begin(), same.end());
    return numbers;
}

TEST(RankedBits, knowMembersAndRanks) {
    for (const std::size_t size : {1u, 63u, 64u, 65u, 128u, 1000u}) {
        const auto numbers = randomNumbers(size, size / 3 + 1, 7);
        RankedBits bits(size);
        EXPECT_FALSE(bits.hasAny(0, size));
        for (const std::size_t number : numbers) bits.insert(number);
        bits.makeRanks();
        EXPECT_EQ(bits.size(), size);
        EXPECT_EQ(bits.count(), numbers.size());
        std::vector<std::size_t> visited;
        bits.forEach([&](std::size_t number) { visited.push_back(number); });
        EXPECT_EQ(visited, numbers);
        for (std::size_t i = 0; i <= size; ++i) {
            const auto at = std::ranges::lower_bound(numbers, i);
            EXPECT_EQ(bits.rank(i), static_cast<std::size_t>(at - numbers.begin()));
            if (i == size) break;
            EXPECT_EQ(bits[i], at != numbers.end() && *at == i);
            EXPECT_EQ(bits.from(i) & 1, bits[i] ? 1u : 0u);
            for (const std::size_t length : {1u, 5u, 64u, 70u, 200u}) {
                const std::size_t last = std::min(i + length, size);
                EXPECT_EQ(bits.hasAny(i, last), at != numbers.end() && *at < last);
            }
        }
        EXPECT_FALSE(bits.hasAny(size, size));
    }
}

TEST(RankedBits, makeBinsOfWhichMostAreEmpty) {
    const std::vector<Bins::Entry> entries = {{70, 0}, {3, 1}, {70, 2}, {199, 3}, {3, 5}};
    // All bins have an array if there are few.
    for (const Index count : {200, 2'000'000}) {
        const Bins bins(count, entries);
        const auto itemsIn = [&](Index first, Index last) {
            const auto items = bins.itemsIn(first, last);
            return std::vector<Index>(items.begin(), items.end());
        };
        EXPECT_EQ(itemsIn(3, 3), (std::vector<Index>{1, 5}));
        EXPECT_EQ(itemsIn(0, 199), (std::vector<Index>{1, 5, 0, 2, 3}));
        EXPECT_EQ(itemsIn(4, 70), (std::vector<Index>{0, 2}));
        EXPECT_EQ(itemsIn(71, 198), std::vector<Index>{});
        EXPECT_EQ(itemsIn(199, 199), std::vector<Index>{3});
    }
}

}  // namespace
}  // namespace espalier::cages
