// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/pose.h>
#include <espalier/shapes/selection.h>
#include <espalier/shapes/solids.h>
#include <espalier/shapes/transform.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "support/test.h"

namespace espalier::shapes::pose {
namespace {

// The bound that operations and their inverses keep for coordinates up to 2: some 20 roundings.
constexpr double kFewRoundings = 1e-14;

constexpr Point3 kX = {1, 0, 0}, kY = {0, 1, 0}, kZ = {0, 0, 1};

/// Returns 200 points in the box from (−1, −1, 0) to (1, 1, 2), with its corners.
std::vector<Point3> cloud(unsigned seed = 1) {
    const auto numbers = randomValues(600, seed);
    std::vector<Point3> points;
    for (std::size_t i = 0; i < 200; ++i)
        points.push_back({numbers[3 * i], numbers[3 * i + 1], 1 + numbers[3 * i + 2]});
    for (int i = 0; i < 8; ++i)
        points.push_back({2.0 * (i & 1) - 1, 1.0 * (i & 2) - 1, 0.5 * (i & 4)});
    return points;
}

void expectNear(const std::vector<Point3>& points, const std::vector<Point3>& expected,
                double bound = kFewRoundings) {
    ASSERT_EQ(points.size(), expected.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(points[i][axis], expected[i][axis], bound) << "point " << i;
}

/// Returns map(p) for each point.
template <class Map>
std::vector<Point3> each(const std::vector<Point3>& points, const Map& map) {
    std::vector<Point3> result;
    for (const Point3& point : points) result.push_back(map(point));
    return result;
}

TEST(Pose, AffineOperationsAreTheirMaps) {
    const auto points = cloud();
    expectNear(move(points, {1, 2, -3}), each(points, translation({1, 2, -3})));
    // The middle of the box around the points is (0, 0, 1).
    const Affine toMiddle = translation(kZ), back = translation({0, 0, -1});
    expectNear(rotate(points, {1, 2, 3}, 0.7),
               each(points, toMiddle * rotation({1, 2, 3}, 0.7) * back));
    expectNear(scale(points, {2, 3, -0.5}), each(points, toMiddle * scaling({2, 3, -0.5}) * back));
    const Point3 center = {0.3, -0.2, 0.9};
    expectNear(
        rotate(points, kX, 1.5, {.center = center}),
        each(points, translation(center) * rotation(kX, 1.5) * translation({-0.3, 0.2, -0.9})));
    expectNear(
        scale(points, {2, 2, 2}, {.center = center}),
        each(points, translation(center) * scaling({2, 2, 2}) * translation({-0.3, 0.2, -0.9})));
}

TEST(Pose, DisplacementsAreAdded) {
    const std::vector<Point3> points = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}},
                              by = {{1, 0, 0}, {0, 2, -1}, {0, 0, 4}};
    const std::vector<double> weights = {0, 1, 0.5};
    EXPECT_EQ(displace(points, by), (std::vector<Point3>{{2, 2, 3}, {4, 7, 5}, {7, 8, 13}}));
    EXPECT_EQ(displace(points, by, weights),
              (std::vector<Point3>{{1, 2, 3}, {4, 7, 5}, {7, 8, 11}}));
    EXPECT_MESSAGE("displacements has 2 vectors; expected one for each of the 3 positions",
                   displace(points, std::span(by).first(2)));
    EXPECT_REFUSED(Error, "displacements[1]",
                   displace(points, std::vector<Point3>{kX, {0, NAN, 0}, kX}));
    EXPECT_REFUSED(
        Error, "position 0 moves to",
        displace(std::vector<Point3>{{1e308, 0, 0}}, std::vector<Point3>{{1e308, 0, 0}}));
}

TEST(Pose, AffineOperationsHaveInverses) {
    const auto points = cloud();
    const Options about{.center = Point3{0.1, 0.2, 0.3}};
    expectNear(move(move(points, {1, 2, -3}), {-1, -2, 3}), points);
    expectNear(rotate(rotate(points, {1, 2, 3}, 2.5, about), {1, 2, 3}, -2.5, about), points);
    expectNear(scale(scale(points, {2, 0.5, 3}, about), {0.5, 2, 1.0 / 3}, about), points);
}

// Barr's (3.3) for the z axis: x' = x cos θ − y sin θ, y' = x sin θ + y cos θ, z' = z.
TEST(Pose, TwistIsBarrsFormula) {
    const auto points = cloud();
    const auto expected = each(points, [](const Point3& p) -> Point3 {
        const double theta = 1.2 * p[2] / 2;
        return {p[0] * std::cos(theta) - p[1] * std::sin(theta),
                p[0] * std::sin(theta) + p[1] * std::cos(theta), p[2]};
    });
    expectNear(twist(points, kZ, 1.2), expected);
    expectNear(twist(points, {0, 0, 5}, 1.2), expected);  // The length of the axis does not matter.
    // The coordinate along the axis stays, so the inverse is the twist by the opposite angle.
    expectNear(twist(expected, kZ, -1.2, {.center = Point3{0, 0, 0}}), points);
}

TEST(Pose, TwistIsRigidBeyondItsRange) {
    const auto points = cloud();
    const auto twisted =
        twist(points, kZ, 2, {.center = Point3{0, 0, 0}, .range = std::array{0.5, 1.5}});
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i][2] <= 0.5) {
            EXPECT_EQ(twisted[i], points[i]);
        }
        if (points[i][2] >= 1.5) expectNear({twisted[i]}, {rotation(kZ, 2)(points[i])});
    }
}

// Barr's (3.2) for the z axis: x' = r x, y' = r y, z' = z. Its inverse divides by r.
TEST(Pose, TaperIsBarrsFormulaAndHasAnInverse) {
    const auto points = cloud();
    const auto r = [](const Point3& p) { return 1 + (0.25 - 1) * p[2] / 2; };
    const auto tapered = taper(points, kZ, 0.25);
    expectNear(tapered, each(points, [&](const Point3& p) -> Point3 {
                   return {r(p) * p[0], r(p) * p[1], p[2]};
               }));
    expectNear(each(tapered,
                    [&](const Point3& p) -> Point3 {
                        return {p[0] / r(p), p[1] / r(p), p[2]};
                    }),
               points);
}

/// Barr's (3.4) for the y axis and a bend in the y, z plane, with y0 = y_min, and its inverse.
struct BarrBend {
    double low, high, k;

    Point3 operator()(const Point3& p) const {
        const double limited = std::clamp(p[1], low, high), theta = k * (limited - low);
        const double c = std::cos(theta), s = std::sin(theta);
        return {p[0], -s * (p[2] - 1 / k) + low + c * (p[1] - limited),
                c * (p[2] - 1 / k) + 1 / k + s * (p[1] - limited)};
    }

    Point3 inverse(const Point3& p) const {
        const double free = std::atan2(p[1] - low, 1 / k - p[2]);
        const double theta = std::clamp(free, 0.0, k * (high - low));
        const double c = std::cos(theta), s = std::sin(theta), limited = theta / k + low;
        if (theta == free) return {p[0], limited, 1 / k - std::hypot(p[1] - low, p[2] - 1 / k)};
        return {p[0], (p[1] - low) * c + (p[2] - 1 / k) * s + limited,
                -(p[1] - low) * s + (p[2] - 1 / k) * c + 1 / k};
    }
};

TEST(Pose, BendIsBarrsFormulaAndHasAnInverse) {
    for (const double angle : {0.1, 1.0, 1.9}) {
        const BarrBend barr{-0.5, 0.75, angle / 1.25};
        const auto points = each(cloud(), [](const Point3& p) -> Point3 {
            return {p[0], p[1], 0.3 * (p[2] - 1)};  // below 1 / k in z, so that nothing folds
        });
        const auto bent =
            bend(points, kY, angle, kZ,
                 {.center = Point3{0, 0, 0}, .range = std::array{barr.low, barr.high}});
        // 1 / k is up to 12.5: Barr's form loses the digits of the difference from it.
        expectNear(bent, each(points, barr), 1e-13);
        expectNear(each(bent, [&](const Point3& p) { return barr.inverse(p); }), points, 1e-13);
    }
}

TEST(Pose, ABendOfNothingIsExact) {
    const auto points = cloud();
    expectNear(bend(points, kZ, 0, kX), points, 1e-15);
    // A small angle is continuous with it.
    expectNear(bend(points, kZ, 1e-12, kX), points, 1e-11);
}

// What an operation leaves alone stays as it was, to the last digit: positions below the range, and
// coordinates along an axis of rotation.
TEST(Pose, PositionsWithoutEffectStayBitForBit) {
    const auto points = cloud(5);
    const Options upper{.center = Point3{0.1, 0.2, 0.3}, .range = std::array{0.5, 2.0}};
    const std::vector<std::vector<Point3>> poses = {twist(points, kZ, 1.3, upper),
                                                    bend(points, kZ, 1.3, {1, 2, 0}, upper),
                                                    taper(points, kZ, 3, upper)};
    for (const auto& pose : poses)
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (points[i][2] <= 0.5)
                ASSERT_EQ(pose[i], points[i]);
            else
                ASSERT_NE(pose[i], points[i]);
        }
    const auto turned = rotate(points, kZ, 1.3, upper);
    for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(turned[i][2], points[i][2]);
        ASSERT_EQ(poses[0][i][2], points[i][2]);
    }
}

TEST(Pose, AHalfCircleHasTheLengthOfTheAxis) {
    const std::vector<Point3> axis = {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}};
    const double radius = 2 / std::numbers::pi;
    expectNear(bend(axis, kZ, std::numbers::pi, kX),
               {{0, 0, 0}, {radius, 0, radius}, {2 * radius, 0, 0}}, 1e-15);
}

// The direction of a bend is the part of `toward` across the axis.
TEST(Pose, BendTurnsTowards) {
    const auto points = cloud();
    expectNear(bend(points, kZ, 1, {3, 0, 7}), bend(points, kZ, 1, kX));
    const auto opposite = bend(points, kZ, 1, {-1, 0, 0});
    expectNear(opposite, bend(points, kZ, -1, kX));
}

TEST(Pose, WeightsGivePartsOfAnOperation) {
    const auto points = cloud();
    std::vector<double> weights;
    for (std::size_t i = 0; i < points.size(); ++i)
        weights.push_back(0.25 * static_cast<double>(i % 5));
    // Of the whole cloud, so that the places do not depend on the weights.
    const auto with = [&](std::span<const double> chosen) {
        return Options{chosen, Point3{0, 0, 1}, std::array{0.0, 2.0}};
    };
    const std::vector<double> all(points.size(), 1);
    for (std::size_t part = 0; part <= 4; ++part) {
        const double w = 0.25 * static_cast<double>(part);
        const auto expectParts = [&](const std::vector<Point3>& parts,
                                     const std::vector<Point3>& whole) {
            for (std::size_t i = part; i < points.size(); i += 5) {
                expectNear({parts[i]}, {whole[i]});
                if (part == 0) {
                    EXPECT_EQ(parts[i], points[i]);
                }
            }
        };
        const Options parts = with(weights), whole = with(all);
        expectParts(move(points, {1, 2, 3}, weights), move(points, {w, 2 * w, 3 * w}));
        expectParts(rotate(points, kX, 2, parts), rotate(points, kX, 2 * w, whole));
        expectParts(scale(points, {3, 2, 0}, parts),
                    scale(points, {1 + 2 * w, 1 + w, 1 - w}, whole));
        expectParts(twist(points, kZ, 2, parts), twist(points, kZ, 2 * w, whole));
        expectParts(bend(points, kZ, 1, kX, parts), bend(points, kZ, w, kX, whole));
        expectParts(taper(points, kZ, 3, parts), taper(points, kZ, 1 + 2 * w, whole));
    }
}

// By default, centre and range are of the positions with a weight.
TEST(Pose, TheRangeIsTheSelectedPart) {
    const auto points = cloud();
    const auto weights = selectBox(points, {-1, -1, 1}, {1, 1, 2});
    std::vector<Point3> upper;
    for (const Point3& point : points)
        if (point[2] >= 1) upper.push_back(point);
    const auto twisted = twist(points, kZ, 2, {.weights = weights});
    std::vector<Point3> twistedUpper;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (points[i][2] >= 1)
            twistedUpper.push_back(twisted[i]);
        else
            EXPECT_EQ(twisted[i], points[i]);
    expectNear(twistedUpper, twist(upper, kZ, 2));
}

// The length of an axis has no effect, also where its inverse or its square overflows. The lengths
// are powers of two: the results have the same bits.
TEST(Pose, AxesMayHaveAnyLength) {
    const auto points = cloud();
    for (const int exponent : {-1074, -1030, -600, 600, 1023}) {
        const auto along = [&](Point3 axis) {
            for (double& number : axis) number = std::scalbn(number, exponent);
            return axis;
        };
        EXPECT_EQ(rotate(points, along(kZ), 2), rotate(points, kZ, 2)) << exponent;
        EXPECT_EQ(twist(points, along(kY), 2), twist(points, kY, 2)) << exponent;
        EXPECT_EQ(taper(points, along(kX), 2), taper(points, kX, 2)) << exponent;
        EXPECT_EQ(bend(points, along(kZ), 2, along(kX)), bend(points, kZ, 2, kX)) << exponent;
        EXPECT_EQ(selectEnd(points, along(kZ)), selectEnd(points, kZ)) << exponent;
        EXPECT_EQ(selectHalfSpace(points, {0, 0, 1}, along(kZ)),
                  selectHalfSpace(points, {0, 0, 1}, kZ))
            << exponent;
    }
}

TEST(Pose, RefusesArgumentsOutOfRange) {
    const auto points = cloud();
    const std::vector<double> few(3, 1), nothing(points.size(), 0), large(points.size(), 1.5);
    EXPECT_REFUSED(Error, "move: offset: expected finite numbers, got (nan, 0, 0)",
                   move(points, {kNan, 0, 0}));
    EXPECT_REFUSED(Error, "weights has 3 numbers; expected one for each of the 208 positions",
                   move(points, kX, few));
    EXPECT_REFUSED(Error, "weights[0] is 1.5; expected 0 to 1", move(points, kX, large));
    EXPECT_REFUSED(Error, "positions[1]",
                   move(std::vector<Point3>{{0, 0, 0}, {0, kInfinity, 0}}, kX));
    EXPECT_REFUSED(Error, "rotate: axis: expected a vector other than 0, got (0, 0, 0)",
                   rotate(points, {0, 0, 0}, 1));
    EXPECT_REFUSED(Error, "rotate: angle: expected a finite number, got inf",
                   rotate(points, kX, kInfinity));
    EXPECT_REFUSED(Error, "no position has a weight above 0",
                   rotate(points, kX, 1, {.weights = nothing}));
    EXPECT_REFUSED(Error, "scale: factors: expected finite numbers, got (1, 1, nan)",
                   scale(points, {1, 1, kNan}));
    EXPECT_REFUSED(Error, "scale: center: expected finite numbers, got (nan, 0, 0)",
                   scale(points, kX, {.center = Point3{kNan, 0, 0}}));
    EXPECT_REFUSED(
        Error,
        "twist: range: expected two numbers, since the selected positions are all at one place",
        twist(std::vector<Point3>{{0, 0, 5}, {1, 0, 5}}, kZ, 1));
    EXPECT_REFUSED(Error, "range[1]: expected a number above range[0] (1), got 1",
                   twist(points, kZ, 1, {.range = std::array{1.0, 1.0}}));
    EXPECT_REFUSED(
        Error, "bend: toward: expected a vector that is not parallel to the axis, got (0, 0, 2)",
        bend(points, kZ, 1, {0, 0, 2}));
    EXPECT_REFUSED(Error, "taper: factor: expected 0 or more, got -1", taper(points, kZ, -1));
}

TEST(Pose, RefusesResultsThatAreNotFinite) {
    const std::vector<Point3> points = {{0, 0, 0}, {1, 0, 1}};
    EXPECT_MESSAGE(
        "position 0 moves to (-inf, 0, 0); expected finite numbers: an argument or the "
        "position is too large",
        scale(points, {1e308, 1, 1}, {.center = Point3{1e2, 0, 0}}));
    EXPECT_REFUSED(Error, "position 0 moves to (inf",
                   move(std::vector<Point3>{{1e308, 0, 0}}, {1e308, 0, 0}));
}

// A limb bends from its joint on: what is before the centre along the axis stays.
TEST(Pose, TheRangeMayBeginAtTheCentre) {
    const auto points = cloud();
    const Point3 center = {0.2, 0.1, 0.7};
    const Options begins{.center = center, .startsAtCenter = true},
        explicitly{.center = center, .range = {{0.7, 2}}};
    expectNear(bend(points, kZ, 1.1, kX, begins), bend(points, kZ, 1.1, kX, explicitly), 0);
    expectNear(twist(points, kZ, 1.1, begins), twist(points, kZ, 1.1, explicitly), 0);
    expectNear(taper(points, kZ, 0.5, begins), taper(points, kZ, 0.5, explicitly), 0);
    EXPECT_EQ(twist(points, kZ, 1.1, {.startsAtCenter = true}), twist(points, kZ, 1.1));
    const Options beyond{.center = Point3{0, 0, 3}, .startsAtCenter = true};
    EXPECT_REFUSED(Error, "no selected position lies beyond the centre along the axis",
                   bend(points, kZ, 1, kX, beyond));
}

/// Returns a box of 4 × 2 × 2 cells from −2 to 2 along x, and the weights of some vertices.
struct SymmetricBox {
    std::vector<Point3> rest =
        box({.cells = {4, 2, 2}, .min = {-2, 0, 0}, .max = {2, 2, 2}}).positions;
    std::vector<double> weights = std::vector<double>(rest.size());

    std::size_t at(const Point3& place) const {
        return std::ranges::find(rest, place) - rest.begin();
    }
};

TEST(Pose, MirrorLetsTheOtherSideDoWhatOneSideDoes) {
    SymmetricBox lattice;
    lattice.weights[lattice.at({2, 0, 1})] = 1;
    lattice.weights[lattice.at({0, 0, 1})] = 0.5;
    auto moved = lattice.rest;
    for (Point3& p : moved) p = sum(p, {0.25, 0.5, -1});
    const Mirrored result = mirror(lattice.rest, moved, 0, lattice.weights);
    EXPECT_EQ(result.plane, 0);
    EXPECT_EQ(result.withImage, 2);
    EXPECT_EQ(result.withoutImage, 0);
    auto expected = moved;
    expected[lattice.at({-2, 0, 1})] = {-2.25, 0.5, 0};
    expected[lattice.at({0, 0, 1})] = {0, 0.5, 0};  // its own image
    EXPECT_EQ(result.positions, expected);
}

TEST(Pose, TheLargerWeightLeadsAMirror) {
    SymmetricBox lattice;
    const std::size_t left = lattice.at({-2, 0, 0}), right = lattice.at({2, 0, 0});
    auto moved = lattice.rest;
    moved[left] = {-2, 7, 0};
    moved[right] = {2, 9, 0};
    const auto heights = [&](double leftWeight, double rightWeight) {
        lattice.weights[left] = leftWeight;
        lattice.weights[right] = rightWeight;
        const auto result = mirror(lattice.rest, moved, 0, lattice.weights).positions;
        return std::array{result[left][1], result[right][1]};
    };
    EXPECT_EQ(heights(1, 0.5), (std::array{7.0, 7.0}));
    EXPECT_EQ(heights(0.5, 1), (std::array{9.0, 9.0}));
    EXPECT_EQ(heights(1, 1), (std::array{9.0, 9.0})) << "the side of larger coordinates";
    lattice.weights[lattice.at({-1, 0, 0})] = 1;
    EXPECT_EQ(heights(1, 1), (std::array{7.0, 7.0})) << "the side with more weight";
}

TEST(Pose, MirrorFindsImagesAtRest) {
    SymmetricBox lattice;
    lattice.weights[lattice.at({1, 0, 0})] = lattice.weights[lattice.at({2, 0, 0})] = 1;
    auto moved = lattice.rest;
    for (Point3& p : moved) p[0] = p[0] * p[0];
    // At x = 1.5, only 1 and 2 are images of each other; at 5, nothing is.
    EXPECT_EQ(mirror(lattice.rest, moved, 0, lattice.weights, 1.5).withImage, 2);
    EXPECT_MESSAGE(
        "mirror: no position with a weight above 0 has a mirror image at x = 5; the lattice at "
        "rest is not symmetric there",
        mirror(lattice.rest, moved, 0, lattice.weights, 5));
    lattice.rest[lattice.at({-2, 0, 0})][0] = -2.1;
    const Mirrored result = mirror(lattice.rest, moved, 0, lattice.weights, 0);
    EXPECT_EQ(result.withImage, 1);
    EXPECT_EQ(result.withoutImage, 1);
}

TEST(Pose, MirrorTakesImagesNearby) {
    SymmetricBox lattice;
    // The diagonal of the box is about 4.9, so that 0.0049 is the bound.
    lattice.rest[lattice.at({1, 0, 0})][0] = 1.0045;
    EXPECT_EQ(mirror(lattice.rest, lattice.rest, 0).withoutImage, 0);
    lattice.rest[lattice.at({1.0045, 0, 0})][0] = 1.0055;
    EXPECT_EQ(mirror(lattice.rest, lattice.rest, 0).withoutImage, 2);
}

TEST(Pose, MirrorRefusesWrongNumbers) {
    const SymmetricBox lattice;
    const auto few = std::span(lattice.rest).first(3);
    EXPECT_MESSAGE("rest has 3 positions, and there are 45", mirror(few, lattice.rest, 0));
    EXPECT_MESSAGE("mirror: axis: expected 0 to 2, got 3", mirror(lattice.rest, lattice.rest, 3));
    EXPECT_MESSAGE("mirror: plane: expected a finite number, got nan",
                   mirror(lattice.rest, lattice.rest, 0, {}, kNan));
    EXPECT_TRUE(mirror({}, {}, 0).positions.empty());
}

}  // namespace
}  // namespace espalier::shapes::pose
