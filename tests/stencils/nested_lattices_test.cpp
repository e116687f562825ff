// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/local_binding.h>
#include <gtest/gtest.h>

#include "support/refined_lattice.h"
#include "support/zoo.h"

// A lattice embedded in another moves with it, and carries its model along: x' = D_child · D_parent
// · p', one table.
namespace espalier::stencils {
namespace {

StencilTable<double> bindTo(const Lattice& lattice, int level, const std::vector<Point3>& points) {
    return bindPoints<double>(far::TopologyRefiner(lattice.complex), lattice.positions, level,
                              Rules::Siggraph96, points, {.outside = OutsidePolicy::Error})
        .binding.table;
}

TEST(NestedLattices, AreOneTable) {
    const Lattice parent = shapes::cylinder({.sectors = 5});
    const Lattice child =
        shapes::box({.cells = {2, 1, 1}, .min = {-0.3, -0.2, 0.3}, .max = {0.3, 0.2, 0.7}});
    const auto points = test::pointsIn(test::Refined(child, 2), 200, 3);
    const auto ofChild = bindTo(child, 2, points);
    const auto ofParent = bindTo(parent, 2, child.positions);
    const auto nested = multiply<double>(ofChild, ofParent);
    EXPECT_EQ(nested.rowCount(), 200);
    EXPECT_EQ(nested.columnCount(), parent.complex.count(0));
    // At rest the points come back.
    const auto atRest = applyLevelTable(nested, parent.positions);
    // A pose moves the child, and that its points.
    auto pose = parent.positions;
    const auto random = test::randomValues(3 * pose.size(), 4);
    for (std::size_t i = 0; i < random.size(); ++i) pose[i / 3][i % 3] += 0.2 * random[i];
    const auto expected = applyLevelTable(ofChild, applyLevelTable(ofParent, pose));
    const auto moved = applyLevelTable(nested, pose);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(atRest[i][c], points[i][c], 1e-14);
            EXPECT_NEAR(moved[i][c], expected[i][c], 1e-14);
        }
}

}  // namespace
}  // namespace espalier::stencils
