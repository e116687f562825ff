// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/standard_cells.h>
#include <espalier/shapes/inventory.h>
#include <espalier/solve/bernstein.h>
#include <espalier/solve/validity_pieces.h>
#include <espalier/stencils/trilinear.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "support/zoo.h"

namespace espalier::solve {
namespace {

using Eigen::Vector3d;

/// Coefficient a + 3 (b + 3 c) of each polynomial from what makes it up along each axis.
template <class Coefficient>
Triquadratics<1> polynomial(Coefficient coefficient) {
    Triquadratics<1> result;
    for (std::size_t i = 0; i < 27; ++i) result[i][0] = coefficient(i % 3, i / 3 % 3, i / 9);
    return result;
}

/// By the definition, to compare with.
template <std::size_t Lanes>
double valueAt(const Triquadratics<Lanes>& polynomials, std::size_t lane, const Vector3d& uvw) {
    const auto weight = [](std::size_t i, double t) {
        return i == 0 ? (1 - t) * (1 - t) : i == 1 ? 2 * t * (1 - t) : t * t;
    };
    double sum = 0;
    for (std::size_t i = 0; i < 27; ++i)
        sum += weight(i % 3, uvw[0]) * weight(i / 3 % 3, uvw[1]) * weight(i / 9, uvw[2]) *
               polynomials[i][lane];
    return sum;
}

template <class Visit>
void forGrid(int parts, Visit visit) {
    for (int i = 0; i <= parts; ++i)
        for (int j = 0; j <= parts; ++j)
            for (int k = 0; k <= parts; ++k) visit(Vector3d(Vector3d(i, j, k) / parts));
}

/// A cube whose vertices are moved at random.
struct RandomCell {
    Piece piece;
    stencils::Trilinear map;
};

RandomCell randomCell(unsigned seed) {
    Lattice cube = shapes::box();
    const auto moves = test::randomValues(24, seed);
    for (std::size_t i = 0; i < 24; ++i) cube.positions[i / 3][i % 3] += moves[i];
    const auto vertices = far::hexahedronVertices(cube.complex, far::CellId(0));
    stencils::Trilinear::Corners corners;
    for (std::size_t i = 0; i < 8; ++i)
        corners[i] = Vector3d(cube.positions[static_cast<std::size_t>((*vertices)[i])].data());
    return {CellPieces(cube.complex, 0).piece(0, cube.positions), stencils::Trilinear(corners)};
}

// A polynomial of degree 2 along each axis is known by its values at 3 places along each: 4 are
// more than enough. Off by rounding, as the floor has it.
TEST(Bernstein, DeterminantIsThatOfTheTrilinearMap) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        const RandomCell cell = randomCell(seed);
        const auto polynomial = determinant(cell.piece.derivatives);
        forGrid(3, [&](const Vector3d& uvw) {
            EXPECT_NEAR(valueAt(polynomial, 0, uvw), cell.map.jacobian(uvw).determinant(),
                        determinantFloor(cell.piece.lengths));
        });
    }
}

// A cubic is known by its values at 4 times.
TEST(Bernstein, DeterminantOnTheWayIsThatOfTheMapOnTheWay) {
    for (unsigned seed = 0; seed < 5; ++seed) {
        const RandomCell first = randomCell(seed), last = randomCell(seed + 100);
        const auto polynomials = determinant(first.piece.derivatives, last.piece.derivatives);
        std::array<double, 3> lengths;
        for (std::size_t axis = 0; axis < 3; ++axis)
            lengths[axis] = std::max(first.piece.lengths[axis], last.piece.lengths[axis]);
        for (const double t : {0.0, 0.3, 0.7, 1.0}) {
            const std::array<double, 4> weights = {(1 - t) * (1 - t) * (1 - t),
                                                   3 * t * (1 - t) * (1 - t), 3 * t * t * (1 - t),
                                                   t * t * t};
            forGrid(2, [&](const Vector3d& uvw) {
                double value = 0;
                for (std::size_t lane = 0; lane < 4; ++lane)
                    value += weights[lane] * valueAt(polynomials, lane, uvw);
                const Eigen::Matrix3d jacobian =
                    (1 - t) * first.map.jacobian(uvw) + t * last.map.jacobian(uvw);
                EXPECT_NEAR(value, jacobian.determinant(), determinantFloor(lengths));
            });
        }
    }
}

// A tetrahedron has the same determinant everywhere: all coefficients are that, exactly.
TEST(Bernstein, ConstantsStayConstant) {
    Derivatives derivatives;
    derivatives[0].fill({1, 2, 3});
    derivatives[1].fill({-1, 1, 0.5});
    derivatives[2].fill({0.25, 0, 2});
    // 1·(2) − 2·(−2 − 0.125) + 3·(−0.25) = 2 + 4.25 − 0.75
    for (const auto& lanes : determinant(derivatives)) EXPECT_EQ(lanes[0], 5.5);
}

TEST(Bernstein, HalvesAreTheSamePolynomials) {
    const auto values = test::randomValues(54, 3);
    Triquadratics<2> whole;
    for (std::size_t i = 0; i < 54; ++i) whole[i / 2][i % 2] = values[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto both = halves(whole, axis);
        for (std::size_t lane = 0; lane < 2; ++lane)
            forGrid(3, [&](const Vector3d& uvw) {
                Vector3d inLower = uvw, inUpper = uvw;
                inLower[static_cast<Eigen::Index>(axis)] /= 2;
                inUpper[static_cast<Eigen::Index>(axis)] =
                    (1 + uvw[static_cast<Eigen::Index>(axis)]) / 2;
                // Sums of 27 numbers of size 1.
                EXPECT_NEAR(valueAt(both.first, lane, uvw), valueAt(whole, lane, inLower), 1e-14);
                EXPECT_NEAR(valueAt(both.second, lane, uvw), valueAt(whole, lane, inUpper), 1e-14);
            });
    }
}

// (2u − 1)² has coefficients 1, −1, 1 and its least value, 0, in the middle.
constexpr std::array<double, 3> kSquare = {1, -1, 1};

TEST(Bernstein, TellsTheSignOfWhatIsLeastInside) {
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
        EXPECT_TRUE(isAbove(point(least), 0)) << least;
        EXPECT_TRUE(isAbove(plane(least), 0)) << least;
        EXPECT_TRUE(isAbove(plane(least + 7), 7)) << least;
        EXPECT_FALSE(isAbove(point(-least), 0)) << least;
        EXPECT_FALSE(isAbove(plane(-least), 0)) << least;
        EXPECT_FALSE(isAbove(plane(least), least * 1.01)) << least;
    }
    // What cannot be told counts as not above: no such thing is ever "proved".
    EXPECT_FALSE(isAbove(point(0), 0));
    EXPECT_FALSE(isAbove(plane(0), 0));
    EXPECT_FALSE(isAbove(plane(std::numeric_limits<double>::quiet_NaN()), 0));
}

// All of several polynomials, not some.
TEST(Bernstein, AllMustBeAbove) {
    Triquadratics<4> four;
    for (auto& lanes : four) lanes = {1, 2, 3, 4};
    EXPECT_TRUE(isAbove(four, 0.5));
    for (std::size_t lane = 0; lane < 4; ++lane) {
        auto one = four;
        // Its weight in the middle is 1/8; that of the others, lane + 1 each, 7/8.
        one[13][lane] = -8 * four[13][lane];
        EXPECT_FALSE(isAbove(one, 0)) << lane;
        one[13][lane] = -6 * four[13][lane];
        EXPECT_TRUE(isAbove(one, 0)) << lane;
    }
}

// Against the least of samples, which is no less than the least of all.
TEST(Bernstein, LeastQuotientIsBelowAllSamplesAndNotByMuch) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        const auto values = test::randomValues(54, seed);
        Triquadratics<2> quotient;
        for (std::size_t i = 0; i < 27; ++i)
            quotient[i] = {values[i] + (seed % 3 == 0 ? 0.8 : 0), 1.5 + values[27 + i]};
        double sampled = std::numeric_limits<double>::infinity();
        constexpr int kParts = 12;
        forGrid(kParts, [&](const Vector3d& uvw) {
            sampled = std::min(sampled, valueAt(quotient, 0, uvw) / valueAt(quotient, 1, uvw));
        });
        const double least = leastQuotient(quotient);
        EXPECT_LE(least, sampled + 1e-13) << seed;  // rounding of the sample
        // A thousandth, and what a sample may miss: at most 1/24 away along each axis from a least
        // value with curvatures of about 10 it is 3 · 10 / 2 / 24² above it.
        EXPECT_GE(least, sampled - 1e-3 * std::abs(sampled) - 0.026) << seed;
    }
}

// ((2u − 1)² + (2v − 1)² + (2w − 1)² + 0.3) / 2: 0.15 in the middle.
TEST(Bernstein, LeastQuotientIsWithinAThousandth) {
    Triquadratics<2> quotient;
    for (std::size_t i = 0; i < 27; ++i)
        quotient[i] = {kSquare[i % 3] + kSquare[i / 3 % 3] + kSquare[i / 9] + 0.3, 2};
    const double least = leastQuotient(quotient);
    EXPECT_LE(least, 0.15);
    EXPECT_GE(least, 0.15 * (1 - 1.1e-3));
    // One that is 1 everywhere, whatever the two are.
    for (auto& [upper, lower] : quotient) upper = lower = upper + 3;
    EXPECT_EQ(leastQuotient(quotient), 1);
    // Its least weight is negative, its least value positive: -1 + 1.01 in the middle.
    for (std::size_t i = 0; i < 27; ++i)
        quotient[i] = {3 * (kSquare[i % 3] + 0.01), kSquare[i % 3] + 0.01};
    EXPECT_NEAR(leastQuotient(quotient), 3, 3e-3);
}

}  // namespace
}  // namespace espalier::solve
