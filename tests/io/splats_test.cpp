// SPDX-License-Identifier: Apache-2.0
#include "io/models/splats.h"

#include <io/gradient_samples.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <vector>

#include "support/test.h"

namespace espalier::io {
namespace {

using SplatNumbers = std::vector<double>;

/// Returns a splat with random numbers of usual sizes.
SplatNumbers randomSplat(std::size_t degree, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    SplatNumbers splat(kSplatAxes + harmonicCount(degree));
    for (double& number : splat) number = uniform(random);
    for (std::size_t i = 0; i < 3; ++i) splat[i] = 3 * splat[i] - 4;
    return splat;
}

SplatNumbers carried(const DeformationGradient& gradient, SplatNumbers splat) {
    carrySplat(gradient, splat);
    return splat;
}

DeformationGradient transposed(const DeformationGradient& f) {
    return {f[0], f[3], f[6], f[1], f[4], f[7], f[2], f[5], f[8]};
}

/// Returns the rotation of the quaternion of a splat. A vector v becomes v + 2 u × (u × v + w v),
/// where u is the vector part of the quaternion.
DeformationGradient rotationOf(const SplatNumbers& splat) {
    double size = 0;
    for (std::size_t i = 3; i < 7; ++i) size += splat[i] * splat[i];
    const double n = std::sqrt(size), w = splat[3] / n;
    const Point3 u = {splat[4] / n, splat[5] / n, splat[6] / n};
    const DeformationGradient skew = {0, -u[2], u[1], u[2], 0, -u[0], -u[1], u[0], 0};
    const DeformationGradient square = product(skew, skew);
    DeformationGradient result = kIdentity;
    for (std::size_t i = 0; i < 9; ++i) result[i] += 2 * (square[i] + w * skew[i]);
    return result;
}

/// Returns the covariance R diag(e^s)² Rᵀ of a splat.
DeformationGradient covarianceOf(const SplatNumbers& splat) {
    DeformationGradient squares{};
    for (std::size_t i = 0; i < 3; ++i) squares[4 * i] = std::exp(2 * splat[i]);
    const DeformationGradient r = rotationOf(splat);
    return product(product(r, squares), transposed(r));
}

double largestOf(const DeformationGradient& matrix) {
    double largest = 0;
    for (const double entry : matrix) largest = std::max(largest, std::abs(entry));
    return largest;
}

/// Expects that the covariance is F Σ Fᵀ, relative to its largest entry.
void expectCovariance(const DeformationGradient& f, const SplatNumbers& before,
                      const SplatNumbers& after, double tolerance = 1e-13) {
    const DeformationGradient want = product(product(f, covarianceOf(before)), transposed(f));
    const DeformationGradient got = covarianceOf(after);
    for (std::size_t i = 0; i < 9; ++i)
        // The square of the smallest normal float is 1.4e-76.
        EXPECT_NEAR(got[i], want[i], tolerance * largestOf(want) + 1e-75) << "entry " << i;
}

/// Returns the colour of a splat without its constant part: the sum of harmonics in a direction of
/// length 1, with the constants and signs that the authors' program has.
double colourOf(const SplatNumbers& splat, std::size_t colour, const Point3& direction) {
    const auto [x, y, z] = direction;
    const double basis[] = {-0.4886025119029199 * y,
                            0.4886025119029199 * z,
                            -0.4886025119029199 * x,
                            1.0925484305920792 * x * y,
                            -1.0925484305920792 * y * z,
                            0.31539156525252005 * (2 * z * z - x * x - y * y),
                            -1.0925484305920792 * x * z,
                            0.5462742152960396 * (x * x - y * y),
                            -0.5900435899266435 * y * (3 * x * x - y * y),
                            2.890611442640554 * x * y * z,
                            -0.4570457994644658 * y * (4 * z * z - x * x - y * y),
                            0.3731763325901154 * z * (2 * z * z - 3 * x * x - 3 * y * y),
                            -0.4570457994644658 * x * (4 * z * z - x * x - y * y),
                            1.445305721320277 * z * (x * x - y * y),
                            -0.5900435899266435 * x * (x * x - 3 * y * y)};
    const std::size_t count = (splat.size() - kSplatAxes) / 3;
    double result = 0;
    for (std::size_t k = 0; k < count; ++k)
        result += splat[kSplatAxes + colour * count + k] * basis[k];
    return result;
}

/// Expects that `after` has the colours of `before`, turned by a rotation.
void expectColours(const DeformationGradient& turn, const SplatNumbers& before,
                   const SplatNumbers& after) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 20; ++i) {
        Point3 d = {normal(random), normal(random), normal(random)};
        const double size = length(d);
        for (double& x : d) x /= size;
        for (std::size_t colour = 0; colour < 3; ++colour)
            // A few roundings of sums of up to 15 terms of size 1.
            EXPECT_NEAR(colourOf(after, colour, d),
                        colourOf(before, colour, test::times(transposed(turn), d)), 3e-14);
    }
}

TEST(Splats, HaveHarmonicsOfWholeDegrees) {
    for (const std::size_t count : {0, 9, 24, 45}) EXPECT_TRUE(isHarmonicCount(count));
    for (const std::size_t count : {1, 3, 8, 15, 27, 48, 72}) EXPECT_FALSE(isHarmonicCount(count));
}

TEST(Splats, CovariancesAreCarriedByAnyGradient) {
    std::mt19937 random(1);
    const DeformationGradient shear = {1, 0.7, -0.2, 0, 1, 0.4, 0, 0, 1};
    for (int i = 0; i < 8; ++i) {
        const SplatNumbers splat = randomSplat(0, random);
        expectCovariance(shear, splat, carried(shear, splat));
    }
    for (int i = 0; i < 200; ++i) {  // half of them mirror
        const SplatNumbers splat = randomSplat(i % 4, random);
        const DeformationGradient f = randomGradient(random);
        const SplatNumbers after = carried(f, splat);
        expectCovariance(f, splat, after);
        double before = 0, now = 0;
        for (std::size_t k = 3; k < 7; ++k)
            before += splat[k] * splat[k], now += after[k] * after[k];
        EXPECT_NEAR(now, before, 1e-14 * before);
    }
}

TEST(Splats, IdentityKeepsAllBits) {
    std::mt19937 random(2);
    for (const std::size_t degree : {0, 1, 2, 3}) {
        const SplatNumbers splat = randomSplat(degree, random);
        EXPECT_EQ(carried(kIdentity, splat), splat);
    }
}

TEST(Splats, RotationMultipliesTheQuaternion) {
    std::mt19937 random(3);
    for (int i = 0; i < 100; ++i) {
        const SplatNumbers splat = randomSplat(3, random);
        const Point3 axis = {1, 2, -0.5 * i};
        const double angle = 0.031 * i, n = length(axis);  // less than half a turn
        const Point3 v = {axis[0] / n * std::sin(angle / 2), axis[1] / n * std::sin(angle / 2),
                          axis[2] / n * std::sin(angle / 2)};
        const double w = std::cos(angle / 2);
        const SplatNumbers after = carried(rotation(axis, angle), splat);
        const double a = splat[3], b = splat[4], c = splat[5], d = splat[6];
        const SplatNumbers want = {splat[0],
                                   splat[1],
                                   splat[2],
                                   w * a - v[0] * b - v[1] * c - v[2] * d,
                                   w * b + v[0] * a + v[1] * d - v[2] * c,
                                   w * c + v[1] * a + v[2] * b - v[0] * d,
                                   w * d + v[2] * a + v[0] * c - v[1] * b};
        for (std::size_t k = 0; k < want.size(); ++k) EXPECT_NEAR(after[k], want[k], 1e-13);
    }
}

TEST(Splats, AxesKeepTheirOrderUnderSmallGradients) {
    const SplatNumbers splat = {-1, -3, -2, 1, 0, 0, 0};
    const SplatNumbers after = carried({1.01, 0.02, 0, -0.01, 0.99, 0.01, 0, 0, 1.02}, splat);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(after[i], splat[i], 0.03);
    EXPECT_NEAR(after[3], 1, 1e-3);
}

TEST(Splats, TinyAxesKeepTheirDigits) {
    // Columns of F R diag(e^s), which differ by 17 orders of magnitude. A stretch along the axes of
    // the splat multiplies each.
    const SplatNumbers after = carried({2, 0, 0, 0, 0.5, 0, 0, 0, 4}, {0, -40, -400, 0, 1, 0, 0});
    const double ln2 = std::log(2);
    EXPECT_NEAR(after[0], ln2, 1e-15);
    EXPECT_NEAR(after[1], -40 - ln2, 1e-14);
    EXPECT_NEAR(after[2], -400 + 2 * ln2, 1e-13);
    EXPECT_EQ(SplatNumbers(after.begin() + 3, after.end()), (SplatNumbers{0, 1, 0, 0}));
    // Under a shear, the volume stays, which is the product of the axes.
    const SplatNumbers sheared =
        carried({1, 0.5, 0.25, 0, 1, 0.5, 0, 0, 1}, {0, -20, -40, 1, 0, 0, 0});
    EXPECT_NEAR(sheared[0] + sheared[1] + sheared[2], -60, 1e-13);
}

TEST(Splats, ColoursTurnWithTheRotation) {
    std::mt19937 random(4);
    for (const std::size_t degree : {1, 2, 3})
        for (int i = 0; i < 20; ++i) {
            const SplatNumbers splat = randomSplat(degree, random);
            const DeformationGradient turn = rotation({1, 0.3 * i, -2}, 0.5 * i);
            expectColours(turn, splat, carried(turn, splat));
            // F = Q U, with a symmetric U whose axes are those of another rotation.
            const DeformationGradient axes = rotation({0.2 * i, 1, 3}, 2);
            const DeformationGradient stretch =
                product(product(axes, {2, 0, 0, 0, 0.3, 0, 0, 0, 1}), transposed(axes));
            expectColours(turn, splat, carried(product(turn, stretch), splat));
        }
}

TEST(Splats, ColoursOfMirrorsTurnByTheNearestRotation) {
    std::mt19937 random(5);
    const SplatNumbers splat = randomSplat(3, random);
    // The mirror of an axis is as near to no turn as to any other.
    for (std::size_t axis = 0; axis < 3; ++axis) {
        DeformationGradient mirror = kIdentity;
        mirror[4 * axis] = -1;
        const SplatNumbers after = carried(mirror, splat);
        expectColours(kIdentity, splat, after);
        expectCovariance(mirror, splat, after);
    }
    // Q diag(2, 3, -1): nearest is the rotation that maps the two longest axes as F does: Q.
    const DeformationGradient turn = rotation({1, 2, 3}, 1);
    expectColours(turn, splat, carried(product(turn, {2, 0, 0, 0, 3, 0, 0, 0, -1}), splat));
}

TEST(Splats, SingularGradientsGiveFiniteNumbers) {
    std::mt19937 random(6);
    const DeformationGradient flat = {1, 0, 0, 0, 1, 0, 0, 0, 0};
    const DeformationGradient line = {0, 0, 0, 0, 0, 2, 0, 0, 0};
    const DeformationGradient oblique = {1, 2, 3, 2, 4, 6, -1, -2, -3};
    for (const DeformationGradient& f : {flat, line, oblique, DeformationGradient{}})
        for (int i = 0; i < 20; ++i) {
            const SplatNumbers splat = randomSplat(3, random);
            const SplatNumbers after = carried(f, splat);
            for (const double number : after) EXPECT_TRUE(std::isfinite(number));
            expectCovariance(f, splat, after, 1e-12);
        }
    // An axis of length 0 gets the smallest normal float, unless it is smaller already.
    const SplatNumbers after = carried(flat, {-1, -2, -3, 2, 0, 0, 0});
    EXPECT_EQ(after, (SplatNumbers{-1, -2, std::log(double{std::numeric_limits<float>::min()}), 2,
                                   0, 0, 0}));
    EXPECT_EQ(carried(flat, {-1, -2, -100, 2, 0, 0, 0})[2], -100);
    EXPECT_EQ(carried(DeformationGradient{}, {-90, -2, -3, 2, 0, 0, 0})[0], -90);
}

TEST(Splats, GradientsMayHaveAnySize) {
    std::mt19937 random(7);
    const DeformationGradient shear = {1, 0.7, -0.2, 0, 1, 0.4, 0, 0, 1};
    for (const int exponent : {-900, -200, 200, 900}) {
        DeformationGradient f = shear;
        for (double& entry : f) entry = std::scalbn(entry, exponent);
        const SplatNumbers splat = randomSplat(2, random);
        const SplatNumbers got = carried(f, splat), want = carried(shear, splat);
        // At 900 · ln 2 = 624, the spacing of doubles is 1e-13. The floor keeps the smallest
        // scales.
        const double flat = std::log(double{std::numeric_limits<float>::min()});
        for (std::size_t i = 0; i < 3; ++i)
            EXPECT_NEAR(got[i], std::max(want[i] + exponent * std::log(2), flat), 1e-12);
        for (std::size_t i = 3; i < got.size(); ++i) EXPECT_NEAR(got[i], want[i], 1e-14);
    }
}

TEST(Splats, NumbersThatAreNoSplatStay) {
    const SplatNumbers splat = {-1, -2, -3, 0.5, 0.5, 0.5, 0.5, 1, 2, 3, 4, 5, 6, 7, 8, 9};
    const auto stays = [](const SplatNumbers& numbers) {
        const SplatNumbers after = carried(kQuarterTurn, numbers);
        for (std::size_t i = 0; i < numbers.size(); ++i)
            if (!(after[i] == numbers[i] || (std::isnan(after[i]) && std::isnan(numbers[i]))))
                return false;
        return true;
    };
    EXPECT_FALSE(stays(splat));
    for (std::size_t i = 0; i < splat.size(); ++i)
        for (const double bad : {kNan, kInfinity, -kInfinity, 1e300}) {
            SplatNumbers numbers = splat;
            numbers[i] = bad;
            EXPECT_TRUE(stays(numbers)) << "number " << i << " is " << bad;
        }
    SplatNumbers numbers = splat;
    for (std::size_t i = 3; i < 7; ++i) numbers[i] = i == 4 ? -0.0 : 0;
    EXPECT_TRUE(stays(numbers));
    // The largest harmonics would leave the range of floats.
    const double largest = std::numeric_limits<float>::max();
    std::fill(numbers.begin() + 7, numbers.end(), largest);
    std::fill(numbers.begin() + 3, numbers.begin() + 7, 1);
    carrySplat(rotation({1, 1, 0}, 0.5), numbers);
    for (std::size_t i = 7; i < numbers.size(); ++i) EXPECT_EQ(numbers[i], largest);
}

}  // namespace
}  // namespace espalier::io
