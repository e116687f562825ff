// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/transform.h>

#include <numbers>

#include "lattice_checks.h"
#include "support/test.h"

namespace espalier::shapes {
namespace {

using std::numbers::pi;

/// Upper bound of a few rounding errors of numbers of size 1.
constexpr double kFewRoundings = 1e-14;

void expectNear(const Point3& a, const Point3& b) {
    EXPECT_NEAR(norm(minus(a, b)), 0, kFewRoundings);
}

TEST(Affine, TurnsAnticlockwise) {
    expectNear(rotation({0, 0, 2}, pi / 2)({1, 0, 0}), {0, 1, 0});
    expectNear(rotation({1, 0, 0}, pi / 2)({0, 1, 0}), {0, 0, 1});
    expectNear(rotation({1, 1, 1}, 2 * pi / 3)({1, 2, 3}), {3, 1, 2});
}

TEST(Affine, ComposesFromRightToLeft) {
    const Affine both = translation({1, 0, 0}) * rotation({0, 0, 1}, pi / 2);
    expectNear(both({1, 0, 0}), {1, 1, 0});
    const Affine other = rotation({0, 0, 1}, pi / 2) * translation({1, 0, 0});
    expectNear(other({1, 0, 0}), {0, 2, 0});
}

TEST(Affine, TurnsOneDirectionIntoAnother) {
    const Point3 directions[] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},        {-1, 0, 0},
                                 {0, -1, 0}, {0, 0, -1}, {0.6, -0.8, 0.0}, {0.48, 0.6, -0.64}};
    for (const Point3& from : directions)
        for (const Point3& to : directions) {
            const Affine turn = rotationBetween({3 * from[0], 3 * from[1], 3 * from[2]}, to);
            expectNear(turn(from), to);
            EXPECT_NEAR(turn.determinant(), 1, kFewRoundings);
            // The smallest rotation keeps vectors that are perpendicular to both directions.
            const Point3 axis = {from[1] * to[2] - from[2] * to[1],
                                 from[2] * to[0] - from[0] * to[2],
                                 from[0] * to[1] - from[1] * to[0]};
            expectNear(turn(axis), axis);
        }
}

TEST(Affine, RefusesDirectionsWithoutLength) {
    EXPECT_MESSAGE("rotation: axis: expected a vector other than 0, got (0, 0, 0)",
                   rotation({0, 0, 0}, 1));
    EXPECT_MESSAGE("rotation: to: expected a vector other than 0, got (0, 0, 0)",
                   rotationBetween({1, 0, 0}, {0, 0, 0}));
}

TEST(Transformed, ScalesVolumesByTheDeterminant) {
    const Lattice lattice = cylinder({5, {2}, 2});
    const Affine map = translation({3, 2, 1}) * rotation({1, 2, 3}, 1) * scaling({1, 2, 3});
    const Lattice image = transformed(lattice, map);
    EXPECT_NEAR(totalVolume(image), 6 * totalVolume(lattice), 1e-12);  // sums of 30 terms of size 1
    EXPECT_TRUE(sameTopology(image.complex, lattice.complex));
    expectValid(image);
}

TEST(Transformed, KeepsVolumesPositiveInAMirror) {
    const Lattice lattice = torus();
    const Lattice image = transformed(lattice, scaling({-1, 1, 1}));
    EXPECT_NEAR(totalVolume(image), totalVolume(lattice), 1e-12);  // sums of 8 terms of size 1
    EXPECT_EQ(image.positions[0][0], -lattice.positions[0][0]);
    expectValid(image);
}

TEST(Transformed, RefusesASingularMap) {
    EXPECT_MESSAGE(
        "transformed: the determinant of the map: expected a finite number other than 0, got 0",
        transformed(box(), scaling({1, 0, 1})));
}

}  // namespace
}  // namespace espalier::shapes
