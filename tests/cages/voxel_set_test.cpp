// SPDX-License-Identifier: Apache-2.0
#include "cages/voxel_set.h"

#include <gtest/gtest.h>

#include "support/test.h"

namespace espalier::cages {
namespace {

using Counts = std::array<Index, 3>;

std::vector<char> marksOf(const VoxelSet& set, const Counts& counts) {
    std::vector<char> marks(static_cast<std::size_t>(counts[0]) * counts[1] * counts[2], 0);
    set.forEach([&](Index voxel) { marks[voxel] = 1; });
    return marks;
}

Counts placeOf(Index voxel, const Counts& counts) {
    return {voxel % counts[0], voxel / counts[0] % counts[1], voxel / counts[0] / counts[1]};
}

/// Grids whose rows end in the middle of a word, at its end, and after it.
constexpr std::array<Counts, 6> kGrids = {
    {{1, 1, 1}, {7, 5, 6}, {64, 3, 4}, {65, 4, 3}, {130, 2, 5}, {3, 1, 9}}};

RankedBits bitsOf(std::span<const char> marks) {
    RankedBits bits(marks.size());
    for (std::size_t i = 0; i < marks.size(); ++i)
        if (marks[i] != 0) bits.insert(i);
    return bits;
}

/// One of `rarity` voxels has a mark.
std::vector<char> randomMarks(const Counts& counts, unsigned rarity, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<char> marks(static_cast<std::size_t>(counts[0]) * counts[1] * counts[2]);
    for (char& mark : marks) mark = random() % rarity == 0 ? 1 : 0;
    return marks;
}

TEST(VoxelSet, holdsItsMarks) {
    for (const Counts& counts : kGrids) {
        const auto marks = randomMarks(counts, 3, 1);
        const VoxelSet set(counts, bitsOf(marks));
        EXPECT_EQ(marksOf(set, counts), marks);
        std::vector<char> others = marks;
        for (std::size_t i = 0; i < marks.size(); ++i) {
            EXPECT_EQ(set.contains(placeOf(static_cast<Index>(i), counts)), marks[i] != 0);
            others[i] = 1 - others[i];
        }
        EXPECT_EQ(marksOf(set.complement(), counts), others);
        EXPECT_EQ(marksOf(VoxelSet(counts), counts), std::vector<char>(marks.size(), 0));
    }
}

TEST(VoxelSet, holdsTheVoxelsWithinARadius) {
    for (const Counts& counts : kGrids)
        for (const unsigned rarity : {2u, 40u, 1000u})
            for (const double radius : {0.0, 0.9, 1.0, 1.5, 2.0, 3.7, 70.0}) {
                const auto marks = randomMarks(counts, rarity, 2);
                std::vector<char> expected(marks.size(), 0);
                for (std::size_t i = 0; i < marks.size(); ++i)
                    for (std::size_t k = 0; k < marks.size(); ++k) {
                        if (marks[k] == 0) continue;
                        const Counts a = placeOf(static_cast<Index>(i), counts),
                                     b = placeOf(static_cast<Index>(k), counts);
                        double square = 0;
                        for (int axis = 0; axis < 3; ++axis)
                            square += (a[axis] - b[axis]) * (a[axis] - b[axis]);
                        if (square <= radius * radius) expected[i] = 1;
                    }
                EXPECT_EQ(marksOf(VoxelSet(counts, bitsOf(marks)).within(radius), counts), expected)
                    << radius;
            }
}

TEST(VoxelSet, findsTheVoxelsConnectedWithTheFirst) {
    for (const Counts& counts : kGrids)
        for (unsigned seed = 0; seed < 20; ++seed) {
            auto marks = randomMarks(counts, 4, seed);  // walls
            marks[0] = seed == 0 ? 1 : 0;
            for (char& mark : marks) mark = 1 - mark;
            // Passes over all voxels, until nothing changes.
            std::vector<char> expected(marks.size(), 0);
            expected[0] = marks[0];
            for (bool isChanged = true; isChanged;) {
                isChanged = false;
                for (std::size_t i = 0; i < marks.size(); ++i) {
                    if (marks[i] == 0 || expected[i] != 0) continue;
                    const Counts place = placeOf(static_cast<Index>(i), counts);
                    Index stride = 1;
                    for (int axis = 0; axis < 3; stride *= counts[axis], ++axis)
                        if ((place[axis] > 0 && expected[i - stride] != 0) ||
                            (place[axis] + 1 < counts[axis] && expected[i + stride] != 0))
                            expected[i] = 1;
                    isChanged = isChanged || expected[i] != 0;
                }
            }
            EXPECT_EQ(marksOf(VoxelSet(counts, bitsOf(marks)).connectedWithFirst(), counts),
                      expected);
        }
}

}  // namespace
}  // namespace espalier::cages
