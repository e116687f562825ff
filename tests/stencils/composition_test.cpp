// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include "support/complexes.h"
#include "support/test.h"
#include "support/threads.h"

namespace espalier::stencils {
namespace {

TEST(Stencils, DoNotDependOnTheNumberOfThreads) {
    const Lattice lattice = shapes::box({.cells = {5, 5, 5}});
    const auto build = [&](int threads) {
        return withThreads(threads, [&] {
            TopologyRefiner refiner = refined(lattice.complex, 2);
            return buildStencils(refiner, 2);
        });
    };
    EXPECT_EQ(build(1), build(2));
    EXPECT_EQ(build(1), build(8));
}

TEST(LevelTables, ContainTheTableOfEachLevelInOrder) {
    TopologyRefiner refiner = refined(test::bipyramid(5), 2);
    EXPECT_EQ(buildLevelTables(refiner, 2),
              (std::vector{buildLevelTable(refiner, 1), buildLevelTable(refiner, 2)}));
    EXPECT_TRUE(buildLevelTables(refiner, 0).empty());
    EXPECT_THROW(buildLevelTables(refiner, 3), Error);
}

TEST(Stencils, LevelZeroIsTheIdentity) {
    const TopologyRefiner refiner(test::bipyramid(3));
    const auto table = buildStencils(refiner, 0);
    for (Index row = 0; row < 5; ++row) {
        EXPECT_THAT(table.columns(row), ElementsAre(row));
        EXPECT_THAT(table.weights(row), ElementsAre(1));
    }
}

// In a box, rows are copies of others; around the base of two pyramids, none are.
TEST(Stencils, InFloatAreTheRoundedWeights) {
    const TopologyRefiner regular = refined(shapes::box({.cells = {3, 3, 3}}).complex, 2);
    const TopologyRefiner irregular = refined(test::bipyramid(3), 2);
    const std::vector<Index> some = {4, 3, 4};
    for (const TopologyRefiner* refiner : {&regular, &irregular})
        for (const int level : {0, 1, 2}) {
            EXPECT_EQ(buildStencils<float>(*refiner, level),
                      convertTable<float>(buildStencils(*refiner, level)));
            EXPECT_EQ(buildStencils<float>(*refiner, level, some),
                      convertTable<float>(buildStencils(*refiner, level, some)));
        }
}

// Derived by hand from section 2.2 for the cell point of a tetrahedron, and from section 3 for the
// rest: the faces and edges of a single cell are on its surface and sharp, and its vertices are
// corners.
TEST(Stencils, GoldenRowsOfATetrahedron) {
    TopologyRefiner refiner = refined(singleCell(far::StandardCell::Tetrahedron), 1);
    const auto table = buildLevelTable(refiner, 1);
    ASSERT_EQ(table.rowCount(), 4 + 6 + 4 + 1);
    EXPECT_THAT(table.columns(2), ElementsAre(2));
    EXPECT_THAT(table.weights(2), ElementsAre(1));
    for (Index edge = 4; edge < 10; ++edge) EXPECT_THAT(table.weights(edge), ElementsAre(.5, .5));
    for (Index face = 10; face < 14; ++face)
        EXPECT_THAT(table.weights(face), ElementsAre(1. / 3, 1. / 3, 1. / 3));
    EXPECT_THAT(table.weights(14), ElementsAre(.25, .25, .25, .25));
}

// Two pyramids that share their base. The shared square is interior, so its face point is (C0 + 2A
// + C1)/4 with C = (sum of base + apex)/5. The weights are (1/5 + 2/4 + 1/5)/4 = 9/40 for each base
// vertex, and 1/20 for each apex.
TEST(Stencils, GoldenFacePointBetweenTwoPyramids) {
    far::ComplexBuilder builder(3, 6);
    builder.addCell(far::StandardCell::Pyramid, {0, 1, 2, 3, 4});
    builder.addCell(far::StandardCell::Pyramid, {3, 2, 1, 0, 5});
    TopologyRefiner refiner = refined(builder.build(), 1);
    const CellComplex& base = refiner.level(0).complex;
    Index between = 0;
    while (base.relation(2, 3)[between].size() != 2) ++between;
    const auto table = buildLevelTable(refiner, 1);
    const Index row = refiner.refinement(1).childOf({{2, between}, {2, between}})->index;
    const std::vector<double> expected = {.225, .225, .225, .225, .05, .05};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(table.weights(row)[i], expected[i], 1e-16);
}

// Catmull-Clark on the closed mesh of a cube, by hand. A vertex of valence 3 is (Ā + 2M̄)/3. In Ā,
// the vertex has the weight 1/4, each of its 3 neighbours 1/6 and each of the 3 diagonal vertices
// 1/12; in M̄, the vertex has 1/2 and each neighbour 1/6. In total: 5/12, 1/6 and 1/36. An edge
// point is (A₀ + A₁ + P₀ + P₁)/4: 3/8 of each end, and 1/16 of each of the 4 other vertices of its
// faces.
TEST(Stencils, GoldenRowsOfTheSurfaceOfACube) {
    const auto mesh = far::buildMesh(8, far::faceLoops(far::StandardCell::Hexahedron));
    TopologyRefiner refiner = refined(mesh, 1);
    const auto table = buildLevelTable(refiner, 1);
    const auto sorted = [&](Index row) {
        std::vector<double> weights(table.weights(row).begin(), table.weights(row).end());
        std::sort(weights.begin(), weights.end());
        return weights;
    };
    for (Index vertex = 0; vertex < 8; ++vertex)
        EXPECT_THAT(sorted(vertex),
                    ::testing::Pointwise(::testing::DoubleEq(), {1. / 36, 1. / 36, 1. / 36, 1. / 6,
                                                                 1. / 6, 1. / 6, 5. / 12}));
    for (Index edge = 8; edge < 20; ++edge)
        EXPECT_THAT(sorted(edge), ElementsAre(1. / 16, 1. / 16, 1. / 16, 1. / 16, 3. / 8, 3. / 8));
    EXPECT_THAT(table.weights(20), ElementsAre(.25, .25, .25, .25));
}

// A bipyramid, cut into wedges around its axis: n interior faces meet in the axis, an interior
// edge. With n = 5, siggraph96 gives (C̄ + 2Ā + 2M)/5, and cse96 (C̄ + 2Ā + M)/4. Each of the 5
// cells is a tetrahedron. In C̄, an end of the axis has the weight 1/4 and a girdle vertex 2/20; in
// Ā, an end has 1/3 and a girdle vertex 1/15; in M, an end has 1/2.
TEST(Stencils, GoldenEdgeRowsOfBothEditions) {
    const Index n = 5;
    far::ComplexBuilder builder(3, n + 2);
    for (Index i = 0; i < n; ++i)
        builder.addCell(far::StandardCell::Tetrahedron, {i, (i + 1) % n, n + 1, n});
    TopologyRefiner refiner = refined(builder.build(), 1);
    const auto& [base, strata, holes] = refiner.level(0);
    Index axis = 0;
    while (strata.of({1, axis}) != 3) ++axis;
    const Index row = refiner.refinement(1).childOf({{1, axis}, {1, axis}})->index;
    const double girdleC = 2. / 20, girdleA = 1. / 15;
    const std::map<Rules, std::array<double, 2>> expected = {
        {Rules::Siggraph96, {(girdleC + 2 * girdleA) / 5, (1. / 4 + 2. / 3 + 2 * 0.5) / 5}},
        {Rules::Cse96, {(girdleC + 2 * girdleA) / 4, (1. / 4 + 2. / 3 + 0.5) / 4}}};
    for (const auto& [rules, weights] : expected) {
        const auto table = buildLevelTable(withRules(refiner, rules), 1);
        ASSERT_EQ(table.columns(row).size(), 7u);
        for (std::size_t i = 0; i < 7; ++i)
            // About twenty terms below 0.2, each rounded.
            EXPECT_NEAR(table.weights(row)[i], weights[i < 5 ? 0 : 1], 4e-16);
    }
}

TEST(Stencils, MissingVerticesAndLevelsAreRefused) {
    TopologyRefiner refiner = refined(test::bipyramid(3), 1);
    const auto build = [&](int level, Index vertex) {
        return buildStencils(refiner, level, std::vector<Index>{vertex});
    };
    EXPECT_NO_THROW(build(1, 0));
    EXPECT_THROW(build(1, -1), Error);
    EXPECT_THROW(build(1, refiner.level(1).complex.count(0)), Error);
    EXPECT_THROW(build(0, 5), Error);
    EXPECT_THROW(build(2, 0), Error);
    EXPECT_THROW(build(-1, 0), Error);
}

TEST(RefineValues, RefusesAWrongNumberOfValues) {
    const TopologyRefiner refiner(test::bipyramid(3));
    const std::vector<double> values(14);
    EXPECT_REFUSED(Error, "got 14 values; expected 3 for each of 5",
                   refineValues(refiner, 0, values, 3));
}

}  // namespace
}  // namespace espalier::stencils
