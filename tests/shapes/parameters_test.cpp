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

// Finite lengths, whose sums or products are not.
TEST(Parameters, AreRefusedByNameIfLengthsOverflow) {
    EXPECT_MESSAGE(
        "cylinder: to: expected a point at a finite distance from from, got "
        "(1.5e+308, 0, 0)",
        cylinder({.from = {-1.5e308, 0, 0}, .to = {1.5e308, 0, 0}}));
    EXPECT_MESSAGE("barbell: endRadius: expected a radius whose square is finite, got 1e+308",
                   barbell(with(&BarbellOptions::endRadius, 1e308)));
    EXPECT_MESSAGE(
        "arm: joints[1].position: expected a place at a finite distance from the joint before, got "
        "(1.5e+308, 0, 0)",
        arm(with(&ArmOptions::joints,
                 std::vector<ArmJoint>{{{-1.5e308, 0, 0}, 1, 0}, {{1.5e308, 0, 0}, 1, 0}})));
    EXPECT_MESSAGE("layers[0][2] is (inf, 0, -1e+308); expected finite numbers",
                   torus({.majorRadius = 1.7e308, .minorRadius = 1e308}));
}

TEST(Parameters, AreRefusedByNameValueAndRange) {
    const auto positive = [](const std::string& field, const std::string& got) {
        return field + ": expected a finite number above 0, got " + got;
    };
    EXPECT_MESSAGE("box: cells[1]: expected 1 or more, got 0", box({{1, 0, 1}}));
    EXPECT_MESSAGE("box: max[2]: expected a number above min[2] (0), got 0",
                   box({{1, 1, 1}, {0, 0, 0}, {1, 1, 0}}));
    EXPECT_MESSAGE("box: max[0]: expected a finite number, got inf",
                   box({{1, 1, 1}, {0, 0, 0}, {kInfinity, 1, 1}}));
    EXPECT_MESSAGE("cylinder: sectors: expected 3 or more, got 2",
                   cylinder(with(&CylinderOptions::sectors, 2)));
    EXPECT_MESSAGE("cylinder: rings: expected 1 or more, got 0",
                   cylinder(with(&CylinderOptions::pattern, DiskPattern{0})));
    EXPECT_MESSAGE("cylinder: layers: expected 1 or more, got -1",
                   cylinder(with(&CylinderOptions::layers, -1)));
    EXPECT_MESSAGE(positive("cylinder: radius", "nan"),
                   cylinder(with(&CylinderOptions::radius, kNan)));
    EXPECT_MESSAGE("cylinder: to: expected a point other than from, got (0, 0, 0)",
                   cylinder(with(&CylinderOptions::to, Point3{0, 0, 0})));
    EXPECT_MESSAGE("torus: segments: expected 3 or more, got 2",
                   torus(with(&TorusOptions::segments, 2)));
    EXPECT_MESSAGE("torus: gridCells: expected 1 or more, got 0",
                   torus(with(&TorusOptions::gridCells, 0)));
    EXPECT_MESSAGE("torus: sides: expected 3 or more, got 0", torus(with(&TorusOptions::sides, 0)));
    EXPECT_MESSAGE("torus: minorRadius: expected a number below majorRadius (1), got 1",
                   torus(with(&TorusOptions::minorRadius, 1.0)));
    EXPECT_MESSAGE(positive("torus: majorRadius", "-2.5"),
                   torus(with(&TorusOptions::majorRadius, -2.5)));
    EXPECT_MESSAGE("star: points: expected 2 or more, got 1", star(with(&StarOptions::points, 1)));
    EXPECT_MESSAGE(positive("star: innerRadius", "0"), star(with(&StarOptions::innerRadius, 0.0)));
    EXPECT_MESSAGE(positive("star: height", "inf"), star(with(&StarOptions::height, kInfinity)));
    EXPECT_MESSAGE("barbell: endSegments: expected 3 or more, got 2",
                   barbell(with(&BarbellOptions::endSegments, 2)));
    EXPECT_MESSAGE("barbell: barSegments: expected 1 or more, got 0",
                   barbell(with(&BarbellOptions::barSegments, 0)));
    EXPECT_MESSAGE("barbell: barAcross: expected 1 or more, got 0",
                   barbell(with(&BarbellOptions::barAcross, 0)));
    EXPECT_MESSAGE(positive("barbell: barLength", "0"),
                   barbell(with(&BarbellOptions::barLength, 0.0)));
    EXPECT_MESSAGE("barbell: roundness: expected 0 to 1, got 1.5",
                   barbell(with(&BarbellOptions::roundness, 1.5)));
    EXPECT_MESSAGE("arm: segments: expected 1 or more, got 0", arm(with(&ArmOptions::segments, 0)));
    EXPECT_MESSAGE("arm: sides: expected 3 or more, got 2", arm(with(&ArmOptions::sides, 2)));
    EXPECT_MESSAGE(positive("arm: joints[1].radius", "0"),
                   arm(with(&ArmOptions::joints,
                            std::vector<ArmJoint>{{{0, 0, 0}, 1, 0}, {{1, 0, 0}, 0, 0}})));
    EXPECT_MESSAGE(positive("icosahedron: radius", "-1"), icosahedron({-1}));
    EXPECT_MESSAGE("prism: sides: expected 3 or more, got 2", prism({2}));
    EXPECT_MESSAGE(positive("bipyramid: height", "0"), bipyramid({3, 1, 0}));
    EXPECT_MESSAGE("extrude: layers: expected 1 or more, got 0",
                   extrude(gridMesh(), {{0, 0, 1}, 0}));
    EXPECT_MESSAGE("extrude: direction: expected a vector other than 0, got (0, 0, 0)",
                   extrude(gridMesh(), {{0, 0, 0}, 1}));
    EXPECT_MESSAGE("grid: cells[1]: expected 1 or more, got -3", gridMesh({{1, -3}}));
    EXPECT_MESSAGE("disk: rings: expected 1 or more, got 0",
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
