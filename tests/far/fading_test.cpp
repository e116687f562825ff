// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/strata.h>
#include <espalier/far/topology_refiner.h>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

/// A plane of 4 × 4 quadrilaterals. The four edges at its middle, vertex 12, are marked: to the
/// west (11), east (13), south (7) and north (17).
struct Cross {
    CellComplex complex = gridMesh(4, 4);
    Creasing creasing = Creasing::Uniform;
    TopologyRefiner refiner;

    explicit Cross(std::array<double, 4> sharpness, double middle = 0,
                   Creasing method = Creasing::Uniform)
        : creasing(method),
          refiner(complex, {.creasing = method,
                            .marks = {.edges = {{{11, 12}, sharpness[0]},
                                                {{12, 13}, sharpness[1]},
                                                {{7, 12}, sharpness[2]},
                                                {{12, 17}, sharpness[3]}},
                                      .vertices = {{12, middle}}}}) {
        refiner.refineUniform(3);
    }

    const Strata& strata() const { return refiner.level(0).strata; }
    Index edge(Index neighbour) const {
        for (const Index e : complex.relation(0, 1)[12])
            if (contains(complex.relation(1, 0)[e], neighbour)) return e;
        throw std::logic_error("no such edge");
    }
    std::optional<Fading> ofMiddle() const {
        return fadingOf(complex, strata(), creasing, {0, 12});
    }
    std::optional<Fading> ofEdge(Index neighbour) const {
        return fadingOf(complex, strata(), creasing, {1, edge(neighbour)});
    }
    /// Returns the stratum of the middle on each level.
    std::vector<int> middleStrata() const {
        std::vector<int> strata;
        for (int level = 0; level <= 3; ++level)
            strata.push_back(refiner.level(level).strata.of({0, 12}));
        return strata;
    }
};

constexpr double kInfinite = kInfinitelySharp;

TEST(Fading, StrataFollowTheRemainingSharpness) {
    // Two edges of 2.5: a crease on levels 0 to 2, smooth on level 3.
    EXPECT_EQ(Cross({2.5, 2.5, 0, 0}).middleStrata(), (std::vector{1, 1, 1, 2}));
    // A third edge of 1: a corner that is a crease from level 1 on.
    EXPECT_EQ(Cross({kInfinite, kInfinite, 1, 0}).middleStrata(), (std::vector{0, 1, 1, 1}));
    // A vertex of 1.5 on a crease.
    EXPECT_EQ(Cross({kInfinite, kInfinite, 0, 0}, 1.5).middleStrata(), (std::vector{0, 0, 1, 1}));
    // One edge is a dart, which is smooth.
    EXPECT_EQ(Cross({3, 0, 0, 0}).middleStrata(), (std::vector{2, 2, 2, 2}));
}

TEST(Fading, SharpnessIsInheritedByTheHalvesOfAnEdge) {
    const Cross cross({2.5, 2.5, 0, 0}, 0.75);
    const Strata& next = cross.refiner.level(1).strata;
    const auto child = [&](Entity lower, Entity upper) {
        return cross.refiner.refinement(1).childOf({lower, upper}).value();
    };
    const Entity west{1, cross.edge(11)};
    EXPECT_EQ(next.sharpness(child({0, 12}, west)), 1.5F);
    EXPECT_EQ(next.sharpness(child({0, 11}, west)), 1.5F);
    EXPECT_EQ(next.of(child(west, west)), 1);
    EXPECT_EQ(next.sharpness(child({0, 12}, {0, 12})), 0);
    // An edge that begins inside a face is smooth.
    const Index face = cross.complex.relation(1, 2)[west.index].front();
    EXPECT_EQ(next.sharpness(child(west, {2, face})), 0);
}

TEST(Fading, WeightOfAnEdgeIsItsSharpness) {
    EXPECT_FALSE(Cross({1.25, 0, 0, 0}).ofEdge(11)) << "0.25 is left of it";
    EXPECT_FALSE(Cross({kInfinite, 0, 0, 0}).ofEdge(11));
    EXPECT_FALSE(Cross({0.5, 0, 0, 0}).ofEdge(13)) << "smooth";
    const auto fading = Cross({0.75, 0, 0, 0}).ofEdge(11);
    ASSERT_TRUE(fading);
    EXPECT_EQ(fading->next, 2);
    EXPECT_EQ(fading->weight, 0.75);
    // With Chaikin's rule, 0.75 is averaged with 3 at the middle, which gives 1.3125, and with
    // nothing at its other end: one of its halves is smooth.
    const auto half = Cross({0.75, 3, 0, 0}, 0, Creasing::Chaikin).ofEdge(11);
    ASSERT_TRUE(half);
    EXPECT_EQ(half->weight, 0.75);
    // 1.25 is averaged with 0.25 at one end: 0.75 · 1.25 + 0.25 · 0.25 = 1 is used up.
    const auto above = Cross({1.25, 0.25, 0, 0}, 0, Creasing::Chaikin).ofEdge(11);
    ASSERT_TRUE(above);
    EXPECT_EQ(above->weight, 1.25) << "the rules are extrapolated, as in OpenSubdiv";
}

TEST(Fading, WeightOfAVertexIsTheMeanOfFadingSharpness) {
    EXPECT_FALSE(Cross({2, 2, 0, 0}).ofMiddle()) << "still a crease";
    EXPECT_FALSE(Cross({0.5, 0, 0, 0}).ofMiddle()) << "a dart is smooth already";
    EXPECT_FALSE(Cross({2, 2, 2, 0.5}).ofMiddle()) << "a corner by the three others";

    const auto crease = Cross({0.75, 0.25, 0, 0}).ofMiddle();
    ASSERT_TRUE(crease);
    EXPECT_EQ(crease->next, 2);
    EXPECT_EQ(crease->weight, 0.5);

    // One edge fades and one stays: a dart remains.
    const auto dart = Cross({0.75, 3, 0, 0}).ofMiddle();
    ASSERT_TRUE(dart);
    EXPECT_EQ(dart->next, 2);
    EXPECT_EQ(dart->weight, 0.75);

    // A corner of four edges; the edges to the east and to the north stay.
    const Cross cross({0.25, 3, 0.5, 2});
    const auto corner = cross.ofMiddle();
    ASSERT_TRUE(corner);
    EXPECT_EQ(corner->next, 1);
    EXPECT_EQ(corner->weight, 0.375);
    auto staySharp = corner->staySharp.value();
    std::sort(staySharp.begin(), staySharp.end());
    std::array<Index, 2> expected = {cross.edge(13), cross.edge(17)};
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(staySharp, expected);

    // The vertex's own sharpness counts like the sharpness of an edge: (1 + 0.5) / 2.
    const auto own = Cross({0.5, kInfinite, 0, 0}, 1).ofMiddle();
    ASSERT_TRUE(own);
    EXPECT_EQ(own->next, 2);
    EXPECT_EQ(own->weight, 0.75);
}

}  // namespace
}  // namespace espalier::far
