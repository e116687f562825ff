// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/sort_unique.h>
#include <espalier/far/star.h>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

/// Checks that a row of a star and a row of the level are the same, up to numbering.
void expectSame(std::span<const Index> inStar, std::span<const Index> inLevel,
                const std::vector<Index>& entities) {
    ASSERT_EQ(inStar.size(), inLevel.size());
    for (std::size_t i = 0; i < inStar.size(); ++i) EXPECT_EQ(entities[inStar[i]], inLevel[i]);
}

// The star has all entities that contain the vertex, with the same loops, signs and strata.
TEST(Star, IsThePartOfTheLevelAroundAVertex) {
    const Marks marks{.edges = {{{0, 1}, kSmooth}}, .vertices = {{2, kInfinitelySharp}}};
    for (const auto& complex : {grid({2, 2, 3}), grid({3, 1, 1}), mixedCells()}) {
        TopologyRefiner refiner = refined(complex, 1, {.marks = marks});
        for (int level = 0; level <= 1; ++level) {
            const Level& whole = refiner.level(level);
            for (Index vertex = 0; vertex < whole.complex.count(0); vertex += 1 + 7 * level) {
                const Star star = starOf(whole, {&vertex, 1});
                const Index center = indexIn(star.entities[0], vertex);
                EXPECT_EQ(star.entities[0][center], vertex);
                for (int d = 1; d <= 3; ++d) {
                    const auto& entities = star.entities[d];
                    EXPECT_TRUE(std::is_sorted(entities.begin(), entities.end()));
                    expectSame(star.level.complex.relation(0, d)[center],
                               whole.complex.relation(0, d)[vertex], entities);
                    for (const Index entity : star.level.complex.relation(0, d)[center]) {
                        const Index there = entities[entity];
                        expectSame(star.level.complex.boundary(d)[entity],
                                   whole.complex.boundary(d)[there],
                                   star.entities[std::size_t(d) - 1]);
                        EXPECT_TRUE(std::ranges::equal(star.level.complex.boundary(d).signs(entity),
                                                       whole.complex.boundary(d).signs(there)));
                    }
                }
                for (int d = 0; d <= 3; ++d)
                    for (Index i = 0; i < star.level.complex.count(d); ++i)
                        EXPECT_EQ(star.level.strata.of({d, i}),
                                  whole.strata.of({d, star.entities[d][i]}));
            }
        }
    }
}

TEST(Star, TwoRingsContainTheStarsOfAllVerticesOfTheFirst) {
    const TopologyRefiner refiner(grid({5, 5, 5}));
    const Index middle = gridVertex({5, 5, 5}, 2, 2, 2);
    EXPECT_EQ(starOf(refiner.level(0), {&middle, 1}).level.complex.count(3), 8);
    EXPECT_EQ(starOf(refiner.level(0), {&middle, 1}, 2).level.complex.count(3), 64);
}

// With Chaikin's rule, the fading of an edge depends on the edges at both of its ends.
TEST(Star, ChaikinNeedsASecondRing) {
    const Marks marks{.edges = {{{0, 1}, 1.5F}}};
    const TopologyRefiner refiner(grid({1, 1, 1}), {.marks = marks});
    EXPECT_EQ(ringsAround(refiner.level(0), Creasing::Chaikin), 2);
    EXPECT_EQ(ringsAround(refiner.level(0), Creasing::Uniform), 1);
    EXPECT_EQ(ringsAround(TopologyRefiner(grid({1, 1, 1})).level(0), Creasing::Chaikin), 1);
}

TEST(Star, MissingVertexIsRefused) {
    const TopologyRefiner refiner(grid({1, 1, 1}));
    for (const Index missing : {-1, 8})
        EXPECT_THROW(starOf(refiner.level(0), {&missing, 1}), Error);
}

}  // namespace
}  // namespace espalier::far
