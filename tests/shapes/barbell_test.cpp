// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/shapes/inventory.h>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

/// Returns a block of 6 by 2 by 0.5: its ends are squares of side 2, and the bar between them has
/// the same width.
BarbellOptions blockOptions() {
    BarbellOptions options;
    options.roundness = 0;
    options.barHalfWidth = options.endRadius;
    return options;
}

TEST(Barbell, HasTheCountsOfTwoDisksAndABar) {
    struct Case {
        DiskPattern pattern;
        int across;
        int segments;
    };
    const Case cases[] = {{{1, Core::Wedges}, 1, 1},
                          {{1, Core::Wedges}, 2, 4},
                          {{3, Core::Wedges}, 3, 2},
                          {{1, Core::Polygon}, 2, 1},
                          {{2, Core::Polygon}, 1, 3}};
    for (const auto& [pattern, across, segments] : cases) {
        BarbellOptions options;
        options.barAcross = across;
        options.barSegments = segments;
        options.pattern = pattern;
        options.layers = 2;
        const Lattice lattice = barbell(options);
        // Each end is a disk of 6 + across sides; the bar adds its inner columns only.
        const Index sides = 6 + across;
        const bool wedges = pattern.core == Core::Wedges;
        const Index vertices =
            2 * (sides * pattern.rings + (wedges ? 1 : 0)) + (segments - 1) * (across + 1);
        const Index faces = 2 * (wedges ? sides * pattern.rings : 1 + sides * (pattern.rings - 1)) +
                            segments * across;
        EXPECT_EQ(countsOf(lattice.complex), sweptDiskCounts(vertices, faces, 2));
        EXPECT_EQ(lattice.complex.eulerCharacteristic(), 1);
        expectValid(lattice);
    }
}

TEST(Barbell, IsABlockWithSquareEndsAndAWideBar) {
    const Lattice lattice = barbell(blockOptions());
    // The block is barLength + 4 endRadius by 2 endRadius by height.
    EXPECT_NEAR(totalVolume(lattice), 6 * 2 * 0.5, kRounding);
    const BoundingBox bounds(lattice.positions);
    // The volume equals the volume of the bounds, so the block fills its box.
    EXPECT_EQ(bounds.min, (Point3{-3, -1, -0.25}));
    EXPECT_EQ(bounds.max, (Point3{3, 1, 0.25}));
    expectValid(lattice);
}

TEST(Barbell, HasOneTopologyFromBlockToBarbell) {
    const Lattice rest = barbell(blockOptions());
    for (const double roundness : {0.0, 0.3, 0.7, 1.0})
        for (const double halfWidth : {0.05, 0.95}) {
            BarbellOptions options;
            options.roundness = roundness;
            options.barHalfWidth = halfWidth;
            options.barLength = 3;
            options.height = 1;
            const Lattice pose = barbell(options);
            EXPECT_TRUE(sameTopology(rest.complex, pose.complex));
            expectValid(pose);
        }
}

TEST(Barbell, HasRoundEnds) {
    BarbellOptions options;
    options.endRadius = 2;
    options.barHalfWidth = 1.2;
    options.barLength = 3;
    const Lattice lattice = barbell(options);
    // The neck is at sqrt(2² − 1.2²) = 1.6 from the centre, and the bar reaches from neck to neck.
    const Point3 centre = at(lattice, 0);
    EXPECT_NEAR(centre[0], -(1.5 + 1.6), kRounding);
    // Vertices 1 to 7 are the arc; the eighth is inside the neck.
    for (Index v = 1; v <= 7; ++v) EXPECT_NEAR(norm(minus(at(lattice, v), centre)), 2, kRounding);
    EXPECT_NEAR(norm(minus(at(lattice, 8), centre)), 1.6, kRounding);
    // The right end is the left end rotated by 180 degrees.
    for (Index v = 0; v < 9; ++v) {
        EXPECT_EQ(at(lattice, 9 + v)[0], -at(lattice, v)[0]);
        EXPECT_EQ(at(lattice, 9 + v)[1], -at(lattice, v)[1]);
    }
}

TEST(Barbell, RefusesABarAsWideAsARoundEnd) {
    BarbellOptions options;
    options.barHalfWidth = options.endRadius;
    EXPECT_MESSAGE(
        "barbell: barHalfWidth: expected with roundness 1, a number below endRadius (1), "
        "got 1",
        barbell(options));
    options.roundness = 0.5;
    options.barHalfWidth = 1.25;
    EXPECT_MESSAGE("barbell: barHalfWidth: expected a number up to endRadius (1), got 1.25",
                   barbell(options));
}

}  // namespace
}  // namespace espalier::shapes
