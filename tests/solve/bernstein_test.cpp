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

#include "polynomials.h"
#include "support/zoo.h"

namespace espalier::solve {
namespace {

using Eigen::Vector3d;

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
                        determinantFloor(cell.piece));
        });
    }
}

// A cubic is known by its values at 4 times.
TEST(Bernstein, DeterminantOnTheWayIsThatOfTheMapOnTheWay) {
    for (unsigned seed = 0; seed < 5; ++seed) {
        const RandomCell first = randomCell(seed), last = randomCell(seed + 100);
        const auto polynomials = determinant(first.piece.derivatives, last.piece.derivatives);
        const auto floor = determinantFloor(first.piece, last.piece);
        for (const double t : {0.0, 0.3, 0.7, 1.0}) {
            const std::array<double, 4> weights = {(1 - t) * (1 - t) * (1 - t),
                                                   3 * t * (1 - t) * (1 - t), 3 * t * t * (1 - t),
                                                   t * t * t};
            forGrid(2, [&](const Vector3d& uvw) {
                double value = 0, rounding = 0;
                for (std::size_t lane = 0; lane < 4; ++lane) {
                    value += weights[lane] * valueAt(polynomials, lane, uvw);
                    rounding += weights[lane] * floor[lane];
                }
                const Eigen::Matrix3d jacobian =
                    (1 - t) * first.map.jacobian(uvw) + t * last.map.jacobian(uvw);
                EXPECT_NEAR(value, jacobian.determinant(), rounding);
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

TEST(Bernstein, PartsInTimeAreTheSamePolynomial) {
    const auto values = test::randomValues(108, 5);
    Triquadratics<4> whole;
    for (std::size_t i = 0; i < 108; ++i) whole[i / 4][i % 4] = values[i];
    const auto cubic = [](const std::array<double, 4>& c, double t) {
        const double s = 1 - t;
        return s * s * s * c[0] + 3 * t * s * s * c[1] + 3 * t * t * s * c[2] + t * t * t * c[3];
    };
    for (const double cut : {0.5, 0.2}) {
        const auto [before, after] = partsInTime(whole, cut);
        for (std::size_t i = 0; i < 27; ++i)
            for (const double t : {0.0, 0.3, 0.6, 1.0}) {
                // Sums of 4 numbers of size 1.
                EXPECT_NEAR(cubic(before[i], t), cubic(whole[i], cut * t), 1e-15);
                EXPECT_NEAR(cubic(after[i], t), cubic(whole[i], cut + (1 - cut) * t), 1e-15);
            }
    }
}

}  // namespace
}  // namespace espalier::solve
