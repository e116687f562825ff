// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>

#include <numbers>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

using std::numbers::pi;

/// Returns a limb of constant radius through the points.
ArmOptions limb(const std::vector<Point3>& points, double radius = 0.2) {
    ArmOptions options;
    options.joints.clear();
    for (const Point3& point : points) options.joints.push_back({point, radius, 0});
    return options;
}

double squareArea(double radius) {
    return 2 * radius * radius;
}

TEST(Arm, HasTheCountsOfASweptDisk) {
    struct Case {
        int joints;
        int segments;
        int sides;
        int rings;
    };
    for (const auto& [joints, segments, sides, rings] :
         {Case{2, 1, 4, 1}, Case{2, 3, 6, 2}, Case{4, 1, 5, 2}, Case{4, 2, 4, 1}}) {
        ArmOptions options;
        options.joints.resize(joints);
        options.segments = segments;
        options.sides = sides;
        options.pattern.rings = rings;
        const Lattice lattice = arm(options);
        EXPECT_EQ(countsOf(lattice.complex),
                  sweptDiskCounts(sides * rings, 1 + sides * (rings - 1), (joints - 1) * segments));
        EXPECT_EQ(lattice.complex.eulerCharacteristic(), 1);
        expectValid(lattice);
    }
}

TEST(Arm, PutsTheFirstVertexOnTheSideOfUp) {
    ArmOptions options = limb({{1, 1, 1}, {3, 1, 1}}, 0.5);
    options.up = {5, 2, 0};  // Without its part along the bone, `up` is +y.
    const Lattice lattice = arm(options);
    EXPECT_NEAR(norm(minus(at(lattice, 0), {1, 1.5, 1})), 0, kRounding);
    // Vertices run anticlockwise seen from the hand: from +y to +z.
    EXPECT_NEAR(norm(minus(at(lattice, 1), {1, 1, 1.5})), 0, kRounding);
    EXPECT_NEAR(norm(minus(at(lattice, 8), {3, 1.5, 1})), 0, kRounding);
}

// The part of `up` along the bone would be rounded to a whole denormal.
TEST(Arm, TakesAnUpOfAnyLength) {
    ArmOptions options = limb({{0, 0, 0}, {1, 1, 0}}, 0.5);
    options.up = {1, 0, 0};
    const std::vector<Point3> expected = arm(options).positions;
    options.up = {std::numeric_limits<double>::denorm_min(), 0, 0};
    EXPECT_EQ(arm(options).positions, expected);
}

TEST(Arm, KeepsItsThicknessAroundBends) {
    // The bends of the polyline are at most 90°. A tube of constant cross-section, cut by bisecting
    // planes, has the volume of the cross-section times the length of its axis.
    const std::vector<Point3> points = {{0, 0, 0}, {1, 0, 0},     {1, 1, 0},
                                        {1, 1, 1}, {2, 1.5, 1.2}, {3, 1, 2}};
    const ArmOptions options = limb(points);
    const Lattice lattice = arm(options);
    double total = 0;
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
        total += norm(minus(points[i + 1], points[i]));
    EXPECT_NEAR(totalVolume(lattice), squareArea(0.2) * total, kRounding);
    expectValid(lattice);

    // Between two joints every vertex moves along the bone: no twist, no flip, no thinning.
    for (std::size_t bone = 0; bone + 1 < points.size(); ++bone) {
        const Point3 along = minus(points[bone + 1], points[bone]);
        for (Index v = 0; v < 4; ++v) {
            const Index first = Index(bone) * 2 * 4 + v;
            const Point3 step = minus(at(lattice, first + 8), at(lattice, first));
            const Point3 half = minus(at(lattice, first + 4), at(lattice, first));
            EXPECT_GT(step[0] * along[0] + step[1] * along[1] + step[2] * along[2], 0);
            for (const Point3& part : {step, half})
                EXPECT_NEAR(std::abs(part[0] * along[1] - part[1] * along[0]) +
                                std::abs(part[1] * along[2] - part[2] * along[1]) +
                                std::abs(part[2] * along[0] - part[0] * along[2]),
                            0, kRounding);
        }
    }
}

TEST(Arm, CutsABendByTheBisectingPlane) {
    const Lattice lattice = arm(limb({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}));
    // The bones leave (1, 0, 0) in −x and +y: the bisecting plane there is y = 1 − x.
    for (Index v = 8; v < 12; ++v) EXPECT_NEAR(at(lattice, v)[0] + at(lattice, v)[1], 1, kRounding);
}

TEST(Arm, StaysValidAroundSharpBends) {
    for (const double bend : {60.0, 120.0, 150.0}) {
        const double angle = bend * pi / 180;
        const ArmOptions options =
            limb({{0, 0, 0}, {2, 0, 0}, {2 + 2 * std::cos(angle), 2 * std::sin(angle), 0}});
        expectValid(arm(options));
    }
}

TEST(Arm, TwistsEvenlyFromJointToJoint) {
    ArmOptions options = limb({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}, 0.5);
    options.segments = 4;
    options.joints[2].twist = 1.2;
    const Lattice lattice = arm(options);
    for (Index station = 0; station <= 8; ++station) {
        // The first vertex of a station is at `up` = +z, turned about +x.
        const double twist = station <= 4 ? 0 : 1.2 * (station - 4) / 4.0;
        const Point3 vertex = at(lattice, station * 4);
        EXPECT_NEAR(vertex[1], -0.5 * std::sin(twist), kRounding);
        EXPECT_NEAR(vertex[2], 0.5 * std::cos(twist), kRounding);
    }
    expectValid(lattice);
}

TEST(Arm, HasTheTopologyOfItsPose) {
    ArmOptions options;
    options.pattern.rings = 2;
    const Lattice rest = arm(options);
    options.joints[1].position = {0.8, 0.6, 0};
    options.joints[2].position = {1, 1.6, 0};
    options.joints[3].position = {1, 2, 0.2};
    options.joints[3].twist = pi / 2;
    options.joints[0].radius = 0.35;
    const Lattice pose = arm(options);
    EXPECT_TRUE(sameTopology(rest.complex, pose.complex));
    expectValid(pose);
}

TEST(Arm, RefusesInvalidJoints) {
    EXPECT_MESSAGE(
        "arm: joints[2].position: expected a place other than the one of the joint "
        "before, got (1, 0, 0)",
        arm(limb({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}})));
    EXPECT_MESSAGE(
        "arm: joints[1].position: expected a place at which the limb bends by less "
        "than 179 degrees, got (1, 0, 0)",
        arm(limb({{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}})));
    EXPECT_MESSAGE("arm: joints: expected 2 or more, got 1", arm(limb({{0, 0, 0}})));
    EXPECT_MESSAGE(
        "arm: up: expected a vector that is not along the first bone (0, 0, 1), got (0, 0, 1)",
        arm(limb({{0, 0, 0}, {0, 0, 2}})));
}

}  // namespace
}  // namespace espalier::shapes
