// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/io/directions.h>
#include <io/gradient_samples.h>

#include "support/test.h"

namespace espalier::io {
namespace {

// Upper bound of rounding errors in arithmetic on numbers near 1.
constexpr double kRounding = 1e-14;

void expectNear(const Point3& got, const Point3& expected, double tolerance) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(got[axis], expected[axis], tolerance) << "axis " << axis;
}

Point3 randomVector(std::mt19937& random) {
    std::uniform_real_distribution<double> coordinate(-1, 1);
    return {coordinate(random), coordinate(random), coordinate(random)};
}

TEST(Directions, RotationRotatesNormalsAndTangents) {
    const DeformationGradient turn = rotation({1, 2, 3}, 0.7);
    const Point3 direction = {0.3, -0.5, 0.8};
    expectNear(carryNormal(turn, direction), times(turn, direction), kRounding);
    expectNear(carryTangent(turn, direction), times(turn, direction), kRounding);
}

/// A paraboloid, X(u, v), in a space that is twisted about z and bulges: x(X).
Point3 surface(double u, double v) {
    return {u, v, 0.3 * u * u - 0.2 * v * v + 0.1 * u};
}

Point3 deformed(const Point3& x) {
    const double c = std::cos(x[2] + 0.5 * x[0]), s = std::sin(x[2] + 0.5 * x[0]);
    return {c * x[0] - s * x[1], s * x[0] + c * x[1], x[2] * (1 + x[0] * x[1])};
}

TEST(Directions, MatchFiniteDifferencesOfTheDeformedSurface) {
    // Central differences have an error of h² and a rounding error of ε/h, both about 1e-10 times
    // numbers near 1.
    constexpr double kStep = 1e-5, kTolerance = 1e-8;
    const auto along = [&](const auto& at) {
        return scaled(difference(at(kStep), at(-kStep)), 0.5 / kStep);
    };
    for (const auto& [u, v] : {std::pair{0.2, 0.3}, std::pair{-0.7, 0.4}, std::pair{1.1, -0.9}}) {
        const Point3 rest = surface(u, v);
        DeformationGradient gradient{};
        for (std::size_t j = 0; j < 3; ++j) {
            const Point3 column = along([&](double step) {
                Point3 moved = rest;
                moved[j] += step;
                return deformed(moved);
            });
            for (std::size_t i = 0; i < 3; ++i) gradient[3 * i + j] = column[i];
        }
        const double a = u, b = v;  // Lambdas cannot capture structured bindings.
        const auto byU = [&](double step) { return surface(a + step, b); };
        const auto byV = [&](double step) { return surface(a, b + step); };
        const Point3 tangentU = normalised(along(byU));
        const Point3 normal = normalised(cross(along(byU), along(byV)));
        const Point3 deformedU = along([&](double step) { return deformed(byU(step)); });
        const Point3 deformedV = along([&](double step) { return deformed(byV(step)); });
        expectNear(carryNormal(gradient, normal), normalised(cross(deformedU, deformedV)),
                   kTolerance);
        expectNear(carryTangent(gradient, tangentU), normalised(deformedU), kTolerance);
    }
}

TEST(Directions, ANormalIsTheCrossProductOfCarriedTangents) {
    std::mt19937 random(1);
    for (int i = 0; i < 100; ++i) {
        // About half of them mirror.
        const DeformationGradient gradient = randomGradient(random);
        const Point3 a = randomVector(random), b = randomVector(random);
        const Point3 expected = normalised(cross(times(gradient, a), times(gradient, b)));
        // The condition numbers of both products are at most a few hundred here.
        expectNear(carryNormal(gradient, normalised(cross(a, b))), expected, 1000 * kRounding);
    }
}

TEST(Directions, MirrorKeepsNormalsOnTheAnticlockwiseSide) {
    const DeformationGradient mirror = {-1, 0, 0, 0, 1, 0, 0, 0, 1};
    // y and z are not mirrored, so y × z stays x.
    EXPECT_EQ(carryNormal(mirror, {1, 0, 0}), (Point3{1, 0, 0}));
    // x is mirrored to -x, so z × x = y becomes -y.
    EXPECT_EQ(carryNormal(mirror, {0, 1, 0}), (Point3{0, -1, 0}));
    EXPECT_EQ(carryTangent(mirror, {1, 0, 0}), (Point3{-1, 0, 0}));
}

TEST(Directions, NormalExistsWhereSpaceIsFlattenedOntoTheSurface) {
    const DeformationGradient flat = {1, 0, 0, 0, 1, 0, 0, 0, 0};
    // Tangents (1, 0, -1) and (0, 1, 0) become x and y.
    const Point3 normal = carryNormal(flat, {1, 0, 1});
    expectNear(normal, {0, 0, std::sqrt(2)}, kRounding);
    // The same in a frame in which no number is exactly 0.
    const DeformationGradient a = rotation({1, 2, 3}, 0.7), b = rotation({-1, 1, 2}, 1.9);
    const DeformationGradient turned = product(a, product(flat, b));
    const DeformationGradient back = rotation({-1, 1, 2}, -1.9);
    expectNear(carryNormal(turned, times(back, {1, 0, 1})), times(a, {0, 0, std::sqrt(2)}),
               kRounding);
}

TEST(Directions, AreZeroWhereTheGradientMapsThemToZero) {
    const DeformationGradient flat = {1, 0, 0, 0, 1, 0, 0, 0, 0};
    EXPECT_EQ(carryNormal(flat, {1, 0, 0}), Point3{});  // The surface becomes a line.
    EXPECT_EQ(carryTangent(flat, {0, 0, 1}), Point3{});
    EXPECT_EQ(carryNormal(DeformationGradient{}, {1, 2, 3}), Point3{});
    EXPECT_EQ(carryTangent(DeformationGradient{}, {1, 2, 3}), Point3{});
    // Space shrinks to a line up to rounding: no cofactor is exactly 0.
    DeformationGradient line{};
    const Point3 to = {0.1, 0.7, -0.3}, from = {0.3, 1.1, 0.9};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) line[3 * i + j] = to[i] * from[j];
    EXPECT_EQ(carryNormal(line, {0.6, 0, 0.8}), Point3{});
    expectNear(carryTangent(line, {0.6, 0, 0.8}), normalised(to), kRounding);
}

TEST(Directions, StrongStretchesAreNotMistakenForRounding) {
    const DeformationGradient thread = {1, 0, 0, 0, 1e-12, 0, 0, 0, 1e-12};
    EXPECT_EQ(carryNormal(thread, {1, 0, 0}), (Point3{1, 0, 0}));
    EXPECT_EQ(carryTangent(thread, {0, 0, 1}), (Point3{0, 0, 1}));
    // A cofactor of 1e-320, whose inverse is beyond the largest double.
    expectNear(carryNormal({1, 0, 0, 0, 1e-160, 0, 0, 0, 1e-160}, {1, 0, 0}), {1, 0, 0}, kRounding);
}

TEST(Directions, KeepTheirLengthAtAnySize) {
    std::mt19937 random(2);
    const DeformationGradient gradient = randomGradient(random);
    const Point3 unit = normalised({1, -2, 0.5});
    for (const double size : {1e-300, 1.0, 3.0, 1e300}) {
        for (const double stretch : {1e-300, 1.0, 1e300}) {
            DeformationGradient stretched = gradient;
            for (double& entry : stretched) entry *= stretch;
            for (const auto carry : {carryNormal, carryTangent}) {
                const Point3 got = carry(stretched, scaled(unit, size));
                EXPECT_NEAR(length(got) / size, 1, kRounding);
                expectNear(scaled(got, 1 / size), carry(gradient, unit), kRounding);
            }
        }
    }
}

TEST(Directions, TheIdentityKeepsEveryBit) {
    constexpr double kTiny = std::numeric_limits<double>::denorm_min();
    for (const Point3& direction :
         {Point3{1, -2, 0.1}, Point3{1, -0.0, kTiny}, Point3{kTiny, 0, -kTiny},
          Point3{8e307, kTiny, 0}, Point3{0.577, 0.578, -0.579}}) {
        for (const auto carry : {carryNormal, carryTangent}) {
            const Point3 got = carry(kIdentity, direction);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                EXPECT_EQ(got[axis], direction[axis]);
                EXPECT_EQ(std::signbit(got[axis]), std::signbit(direction[axis]));
            }
        }
    }
}

TEST(Directions, ZeroStaysZero) {
    std::mt19937 random(3);
    const DeformationGradient gradient = randomGradient(random);
    for (const auto carry : {carryNormal, carryTangent}) {
        const Point3 got = carry(gradient, {0, -0.0, 0});
        EXPECT_EQ(got, Point3{});
        EXPECT_TRUE(std::signbit(got[1]));
    }
}

}  // namespace
}  // namespace espalier::io
