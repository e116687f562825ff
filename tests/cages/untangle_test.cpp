// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/solve/validity.h>

#include "cages/untangle.h"
#include "support/test.h"

namespace espalier::cages {
namespace {

/// A box of 4 × 4 × 4 unit cells of which only the 27 inner vertices may move.
struct Tangle {
    Lattice lattice = shapes::box({{4, 4, 4}, {0, 0, 0}, {4, 4, 4}});
    far::TopologyRefiner base{lattice.complex, refinerOptions(lattice)};
    std::vector<VertexFreedom> freedoms;
    std::vector<double> lengths = std::vector<double>(std::size_t(lattice.complex.count(1)), 1.0);
    std::vector<double> weights = std::vector<double>(std::size_t(lattice.complex.count(3)), 1.0);

    Tangle() {
        for (const Point3& position : lattice.positions) {
            bool isInner = true;
            for (const double x : position) isInner = isInner && x > 0.5 && x < 3.5;
            freedoms.push_back({isInner});
        }
    }
    TangledCells cells() const { return {base, freedoms, lengths, weights}; }
};

TEST(Untangle, RemovesFolds) {
    Tangle tangle;
    std::vector<Point3> positions = tangle.lattice.positions;
    // The inner vertices change places with their mirror images, so that all cells fold.
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (tangle.freedoms[v].isFree) positions[v][0] = 4 - positions[v][0];
    ASSERT_THAT(solve::cellsBadAtRest(tangle.base, positions), Not(IsEmpty()));
    EXPECT_TRUE(untangle(positions, tangle.cells()));
    EXPECT_THAT(solve::cellsBadAtRest(tangle.base, positions), IsEmpty());
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (!tangle.freedoms[v].isFree) {
            EXPECT_EQ(positions[v], tangle.lattice.positions[v]) << v;
        }
}

TEST(Untangle, KeepsVerticesInPlanes) {
    Tangle tangle;
    std::vector<Point3> positions = tangle.lattice.positions;
    constexpr std::size_t kMiddle = 2 + 5 * (2 + 5 * 2);
    tangle.freedoms[kMiddle].planes.add({0, 0, 1});
    positions[kMiddle] = {3.4, 3.4, 2.25};
    EXPECT_TRUE(untangle(positions, tangle.cells()));
    EXPECT_EQ(positions[kMiddle][2], 2.25);
    EXPECT_LT(positions[kMiddle][0], 3);
}

TEST(Untangle, TellsThatFoldsRemain) {
    Tangle tangle;
    std::vector<Point3> positions = tangle.lattice.positions;
    // A corner of the box, which must not move, is inside.
    positions[0] = {3, 3, 3};
    EXPECT_FALSE(untangle(positions, tangle.cells()));
    tangle.weights[0] = 0;
    positions = tangle.lattice.positions;
    EXPECT_TRUE(untangle(positions, tangle.cells()));
}

}  // namespace
}  // namespace espalier::cages
