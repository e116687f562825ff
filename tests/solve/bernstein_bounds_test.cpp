// SPDX-License-Identifier: Apache-2.0
#include "solve/bernstein.h"

#include "polynomials.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::solve {
namespace {

using Eigen::Vector3d;

// Bernstein coefficients of (2u − 1)², whose minimum 0 is in the middle.
constexpr std::array<double, 3> kSquare = {1, -1, 1};

TEST(BernsteinBounds, DecidesTheSignOfAMinimumInside) {
    const auto point = [](double least) {
        return polynomial([&](std::size_t a, std::size_t b, std::size_t c) {
            return kSquare[a] + kSquare[b] + kSquare[c] + least;
        });
    };
    const auto plane = [](double least) {
        return polynomial(
            [&](std::size_t, std::size_t b, std::size_t) { return kSquare[b] + least; });
    };
    for (const double least : {1e-4, 1e-2, 0.5}) {
        EXPECT_TRUE(isPositive(point(least))) << least;
        EXPECT_TRUE(isPositive(plane(least))) << least;
        EXPECT_FALSE(isPositive(point(-least))) << least;
        EXPECT_FALSE(isPositive(plane(-least))) << least;
    }
    // A sign that cannot be decided counts as not positive: nothing is "proved" by default.
    EXPECT_FALSE(isPositive(point(0)));
    EXPECT_FALSE(isPositive(plane(0)));
    EXPECT_FALSE(isPositive(plane(kNan)));
}

// In degree 8, (2u − 1)² has the coefficients 1 − 4i/8 + 4i(i − 1)/(8 · 7).
TEST(BernsteinBounds, DecidesTheSignInDegreeEight) {
    const auto point = [](double least) {
        Trivariate<8, 1> result;
        const auto square = [](std::size_t i) {
            const auto x = double(i);
            return 1 - x / 2 + x * (x - 1) / 14;
        };
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i][0] = square(i % 9) + square(i / 9 % 9) + square(i / 81) + least;
        return result;
    };
    for (const double least : {1e-4, 1e-2, 0.5}) {
        EXPECT_TRUE(isPositive(point(least))) << least;
        EXPECT_FALSE(isPositive(point(-least))) << least;
    }
    EXPECT_FALSE(isPositive(point(0)));
}

// Compares with the smallest of samples, which is at least the true minimum.
TEST(BernsteinBounds, LeastQuotientIsATightLowerBound) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        const auto values = randomValues(54, seed);
        Trivariate<2, 2> quotient;
        for (std::size_t i = 0; i < 27; ++i)
            quotient[i] = {values[i] + (seed % 3 == 0 ? 0.8 : 0), 1.5 + values[27 + i]};
        double sampled = kInfinity;
        constexpr int kParts = 12;
        forGrid(kParts, [&](const Vector3d& uvw) {
            sampled = std::min(sampled, valueAt(quotient, 0, uvw) / valueAt(quotient, 1, uvw));
        });
        const double least = leastQuotient(quotient);
        EXPECT_LE(least, sampled + 1e-13) << seed;  // Rounding of the sample.
        // A thousandth, and the error of sampling: a sample is at most 1/24 away along each axis
        // from a minimum with curvatures of about 10, so it exceeds the minimum by at most 3 · 10 /
        // 2 / 24².
        EXPECT_GE(least, sampled - 1e-3 * std::abs(sampled) - 0.026) << seed;
    }
}

// The quotient ((2u − 1)² + (2v − 1)² + (2w − 1)² + 0.3) / 2 is 0.15 in the middle.
TEST(BernsteinBounds, LeastQuotientIsWithinAThousandth) {
    Trivariate<2, 2> quotient;
    for (std::size_t i = 0; i < 27; ++i)
        quotient[i] = {kSquare[i % 3] + kSquare[i / 3 % 3] + kSquare[i / 9] + 0.3, 2};
    const double least = leastQuotient(quotient);
    EXPECT_LE(least, 0.15);
    EXPECT_GE(least, 0.15 * (1 - 1.1e-3));
    // A quotient of equal polynomials is 1 everywhere.
    for (auto& [upper, lower] : quotient) upper = lower = upper + 3;
    EXPECT_EQ(leastQuotient(quotient), 1);
    // The smallest weight is negative, the smallest value positive: −1 + 1.01 in the middle.
    for (std::size_t i = 0; i < 27; ++i)
        quotient[i] = {3 * (kSquare[i % 3] + 0.01), kSquare[i % 3] + 0.01};
    EXPECT_NEAR(leastQuotient(quotient), 3, 3e-3);
}

/// A polynomial that is cubic in time at each coefficient: `ofTime` has its Bernstein coefficients,
/// to which `inSpace` is added.
Trivariate<2, 4> moving(const std::array<double, 4>& ofTime, const Trivariate<2, 1>& inSpace) {
    Trivariate<2, 4> result;
    for (std::size_t i = 0; i < 27; ++i)
        for (std::size_t lane = 0; lane < 4; ++lane) result[i][lane] = ofTime[lane] + inSpace[i][0];
    return result;
}

/// (2t − 1)², raised to degree 3: its coefficients 1, −1, 1 become 1, −1/3, −1/3, 1.
constexpr std::array<double, 4> kSquareInTime = {1, -1.0 / 3, -1.0 / 3, 1};

Trivariate<2, 1> nothing() {
    return polynomial([](std::size_t, std::size_t, std::size_t) { return 0; });
}

TEST(BernsteinBounds, FindsTheFirstTime) {
    // 1 − 4t plus three squares that are 0 in the middle: first 0 at t = 1/4.
    const Trivariate<2, 1> squares = polynomial([](std::size_t a, std::size_t b, std::size_t c) {
        return kSquare[a] + kSquare[b] + kSquare[c];
    });
    const Trivariate<2, 4> linear = moving({1, 1 - 4.0 / 3, 1 - 8.0 / 3, -3}, squares);
    EXPECT_LE(positiveUpTo(linear, 1).time, 0.25);
    EXPECT_GE(positiveUpTo(linear, 1).time, 0.25 * (1 - 2e-6));
    EXPECT_TRUE(positiveUpTo(linear, 1).isTight);
    // A limit below 1/4 is reached; a limit slightly above gives 1/4 again.
    EXPECT_EQ(positiveUpTo(linear, 0.2).time, 0.2);
    EXPECT_NEAR(positiveUpTo(linear, 0.2501).time, 0.25, 1e-6);
    // The polynomial (2t − 1)² − 1/4 is first 0 at 1/4, and positive again at the end.
    std::array<double, 4> lower = kSquareInTime;
    for (double& coefficient : lower) coefficient -= 0.25;
    EXPECT_NEAR(positiveUpTo(moving(lower, nothing()), 1).time, 0.25, 1e-6);
    // Not positive at the start; then NaN everywhere.
    EXPECT_EQ(positiveUpTo(moving({0, 1, 1, 1}, nothing()), 1).time, 0);
    lower.fill(kNan);
    EXPECT_EQ(positiveUpTo(moving(lower, nothing()), 1).time, 0);
    // Corners are solved exactly, also if the root is tiny. The polynomial is a − (1 + 3a) t + O(a
    // t²).
    for (const double a : {1e-13, 1e-9})
        EXPECT_NEAR(
            positiveUpTo(moving({a, -1.0 / 3, -2.0 / 3, -1}, nothing()), 1).time * (1 + 3 * a) / a,
            1, 3e-12);
}

// (2t − 1)² + (2u − 1)² + ε is almost 0 at one time, along a plane of the cube.
TEST(BernsteinBounds, NearMissesAreProved) {
    const Trivariate<2, 1> square =
        polynomial([](std::size_t a, std::size_t, std::size_t) { return kSquare[a]; });
    for (const double least : {1e-3, 1e-6, 1e-9, 1e-11}) {
        auto miss = moving(kSquareInTime, square);
        auto hit = miss;
        for (std::size_t i = 0; i < 27; ++i)
            for (std::size_t lane = 0; lane < 4; ++lane) {
                miss[i][lane] += least;
                hit[i][lane] -= least;
            }
        EXPECT_EQ(positiveUpTo(miss, 1).time, 1) << least;
        EXPECT_LE(positiveUpTo(hit, 1).time, 0.5 - std::sqrt(least) / 2) << least;
        EXPECT_GE(positiveUpTo(hit, 1).time, 0.5 - std::sqrt(least) / 2 - 1e-6) << least;
    }
}

// Squares of sums, which are 0 on whole surfaces in space and time, need more halvings than are
// allowed. The returned time is proved nevertheless.
TEST(BernsteinBounds, WorkIsBounded) {
    // (2t − 1 + (2u − 1))² + ε is almost 0 on a diagonal: this needs 1/√ε parts.
    Trivariate<2, 4> diagonal;
    // In monomials of a = 2u − 1 and b = 2t − 1: a² + 2ab + b². b has the coefficients −1, −1/3,
    // 1/3, 1, and a has −1, 0, 1.
    for (std::size_t i = 0; i < 27; ++i)
        for (std::size_t lane = 0; lane < 4; ++lane) {
            const double a = double(i % 3) - 1;
            const double b = double(lane) * 2 / 3 - 1;
            diagonal[i][lane] = kSquare[i % 3] + 2 * a * b + kSquareInTime[lane] + 1e-12;
        }
    const ProvedTime proved = positiveUpTo(diagonal, 1);
    EXPECT_GT(proved.time, 0);
    EXPECT_LT(proved.time, 1);
    EXPECT_FALSE(proved.isTight);
}

}  // namespace
}  // namespace espalier::solve
