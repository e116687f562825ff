// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/extrude.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/solids.h>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

/// Returns the default options with one field set.
template <class Options, class Member, class Value>
Options with(Member Options::*field, Value value) {
    Options options;
    options.*field = value;
    return options;
}

TEST(Parameters, AreRefusedByNameValueAndRange) {
    const std::string positive = "; allowed: finite numbers above 0";
    EXPECT_MESSAGE("box: cells[1] is 0; allowed: 1 or more", box({{1, 0, 1}}));
    EXPECT_MESSAGE("box: max[2] is 0; allowed: numbers above min[2], which is 0",
                   box({{1, 1, 1}, {0, 0, 0}, {1, 1, 0}}));
    EXPECT_MESSAGE("box: max[0] is inf; allowed: finite numbers",
                   box({{1, 1, 1}, {0, 0, 0}, {kInfinity, 1, 1}}));
    EXPECT_MESSAGE("cylinder: sectors is 2; allowed: 3 or more",
                   cylinder(with(&CylinderOptions::sectors, 2)));
    EXPECT_MESSAGE("cylinder: rings is 0; allowed: 1 or more",
                   cylinder(with(&CylinderOptions::pattern, DiskPattern{0})));
    EXPECT_MESSAGE("cylinder: layers is -1; allowed: 1 or more",
                   cylinder(with(&CylinderOptions::layers, -1)));
    EXPECT_MESSAGE("cylinder: radius is nan" + positive,
                   cylinder(with(&CylinderOptions::radius, kNan)));
    EXPECT_MESSAGE("cylinder: to is (0, 0, 0); allowed: points other than `from`",
                   cylinder(with(&CylinderOptions::to, Point3{0, 0, 0})));
    EXPECT_MESSAGE("torus: segments is 2; allowed: 3 or more",
                   torus(with(&TorusOptions::segments, 2)));
    EXPECT_MESSAGE("torus: gridCells is 0; allowed: 1 or more",
                   torus(with(&TorusOptions::gridCells, 0)));
    EXPECT_MESSAGE("torus: sides is 0; allowed: 3 or more", torus(with(&TorusOptions::sides, 0)));
    EXPECT_MESSAGE("torus: minorRadius is 1; allowed: numbers below majorRadius, which is 1",
                   torus(with(&TorusOptions::minorRadius, 1.0)));
    EXPECT_MESSAGE("torus: majorRadius is -2.5" + positive,
                   torus(with(&TorusOptions::majorRadius, -2.5)));
    EXPECT_MESSAGE("star: points is 1; allowed: 2 or more", star(with(&StarOptions::points, 1)));
    EXPECT_MESSAGE("star: innerRadius is 0" + positive, star(with(&StarOptions::innerRadius, 0.0)));
    EXPECT_MESSAGE("star: height is inf" + positive, star(with(&StarOptions::height, kInfinity)));
    EXPECT_MESSAGE("barbell: endSegments is 2; allowed: 3 or more",
                   barbell(with(&BarbellOptions::endSegments, 2)));
    EXPECT_MESSAGE("barbell: barSegments is 0; allowed: 1 or more",
                   barbell(with(&BarbellOptions::barSegments, 0)));
    EXPECT_MESSAGE("barbell: barAcross is 0; allowed: 1 or more",
                   barbell(with(&BarbellOptions::barAcross, 0)));
    EXPECT_MESSAGE("barbell: barLength is 0" + positive,
                   barbell(with(&BarbellOptions::barLength, 0.0)));
    EXPECT_MESSAGE("barbell: roundness is 1.5; allowed: numbers from 0 to 1",
                   barbell(with(&BarbellOptions::roundness, 1.5)));
    EXPECT_MESSAGE("arm: segments is 0; allowed: 1 or more", arm(with(&ArmOptions::segments, 0)));
    EXPECT_MESSAGE("arm: sides is 2; allowed: 3 or more", arm(with(&ArmOptions::sides, 2)));
    EXPECT_MESSAGE("arm: joints[1].radius is 0" + positive,
                   arm(with(&ArmOptions::joints,
                            std::vector<ArmJoint>{{{0, 0, 0}, 1, 0}, {{1, 0, 0}, 0, 0}})));
    EXPECT_MESSAGE("icosahedron: radius is -1" + positive, icosahedron({-1}));
    EXPECT_MESSAGE("prism: sides is 2; allowed: 3 or more", prism({2}));
    EXPECT_MESSAGE("bipyramid: height is 0" + positive, bipyramid({3, 1, 0}));
    EXPECT_MESSAGE("extrude: layers is 0; allowed: 1 or more", extrude(gridMesh(), {{0, 0, 1}, 0}));
    EXPECT_MESSAGE("extrude: direction is (0, 0, 0); allowed: non-zero vectors",
                   extrude(gridMesh(), {{0, 0, 0}, 1}));
    EXPECT_MESSAGE("grid: cells[1] is -3; allowed: 1 or more", gridMesh({{1, -3}}));
    EXPECT_MESSAGE("disk: rings is 0; allowed: 1 or more",
                   diskMesh(regularPolygon(4, 1), {0, 0, 0}, {0}));
}

TEST(Parameters, AreRefusedIfThereWouldBeTooManyEntities) {
    // Each call asks for more entities than an Index can count; the last two for more than 64 bits
    // can count. No call may allocate memory for them first.
    constexpr int kMany = std::numeric_limits<int>::max();
    const auto isTooMany = [](auto call) {
        return causeOf(call) == far::TopologyCause::TooManyEntities;
    };
    EXPECT_TRUE(isTooMany([] { return box({{2000, 2000, 2000}}); }));
    EXPECT_TRUE(isTooMany([] { return cylinder({kMany, {1}, 1}); }));
    EXPECT_TRUE(isTooMany([] { return torus({1000, TorusSection::Grid, 10'000}); }));
    EXPECT_TRUE(isTooMany([] { return star({1000, {1000}, 1000}); }));
    EXPECT_TRUE(isTooMany([] { return extrude(gridMesh(), {{0, 0, 1}, kMany}); }));
    EXPECT_TRUE(isTooMany([] { return arm(with(&ArmOptions::segments, kMany)); }));
    EXPECT_TRUE(isTooMany([] { return bipyramid({kMany}); }));
    EXPECT_TRUE(isTooMany([] { return gridMesh({{kMany, kMany}}); }));
    EXPECT_TRUE(isTooMany([] { return cylinder({kMany, {kMany}, kMany}); }));
    EXPECT_MESSAGE("box: needs 2000 x 2000 x 2000 x 24 entries; the maximum is 2147483647",
                   box({{2000, 2000, 2000}}));
}

}  // namespace
}  // namespace espalier::shapes
