// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/levels.h>

#include <numeric>

#include "support/test.h"

namespace espalier::stencils {
namespace {

// Refines two levels around one cell of 27. The tables, the positions and the product of the tables
// agree.
TEST(Levels, ContainTablesAndPositionsOfRefinedLevels) {
    const Lattice box = shapes::box({.cells = {3, 3, 3}});
    Levels levels(far::TopologyRefiner(box.complex, {.rules = Rules::Cse96}), box.positions);
    EXPECT_EQ(levels.finest(), 0);
    levels.refineAround(std::vector<Index>{0});
    std::vector<Index> children;
    for (Index cell = 0; cell < levels.finestLevel().complex.count(3); ++cell)
        if (levels.refiner().refinement(1).parentOf({3, cell}).upper.index == 0)
            children.push_back(cell);
    EXPECT_EQ(children.size(), 8u);
    levels.refineAround(children, far::TopologyRefiner::Extent::Cells);

    ASSERT_EQ(levels.finest(), 2);
    ASSERT_EQ(levels.tables().size(), 2u);
    for (int k = 1; k <= 2; ++k)
        EXPECT_EQ(levels.tables()[static_cast<std::size_t>(k) - 1],
                  buildLevelTable(levels.refiner(), k));
    std::vector<Index> all(levels.finestLevel().complex.count(0));
    std::iota(all.begin(), all.end(), Index{0});
    const auto expected = applyLevelTable(levels.stencils(all), box.positions);
    const auto positions = levels.finestPositions();
    ASSERT_EQ(positions.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            // Sums of 64 products of size 1, in a different order.
            EXPECT_NEAR(positions[i][axis], expected[i][axis], 1e-14);
}

TEST(Levels, WorkWithoutPositions) {
    const Lattice box = shapes::box({.cells = {2, 2, 2}});
    Levels levels{far::TopologyRefiner(box.complex)};
    levels.refineAround(std::vector<Index>{1});
    EXPECT_EQ(levels.tables().back(), buildLevelTable(levels.refiner(), 1));
}

}  // namespace
}  // namespace espalier::stencils
