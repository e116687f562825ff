// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/trilinear.h>
#include <espalier/far/standard_cells.h>
#include <espalier/shapes/inventory.h>

#include <Eigen/LU>
#include <cmath>

#include "polynomials.h"
#include "solve/bernstein.h"
#include "solve/validity_pieces.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::solve {
namespace {

using Eigen::Vector3d;

/// A cube with randomly moved vertices.
struct RandomCell {
    Piece<1> piece;
    embed::Trilinear map;
};

RandomCell randomCell(unsigned seed) {
    Lattice cube = shapes::box();
    const auto moves = randomValues(24, seed);
    for (std::size_t i = 0; i < 24; ++i) cube.positions[i / 3][i % 3] += moves[i];
    const auto vertices = far::hexahedronVertices(cube.complex, CellId(0));
    embed::Trilinear::Corners corners;
    for (std::size_t i = 0; i < 8; ++i)
        corners[i] = Vector3d(cube.positions[(*vertices)[i]].data());
    return {CellPieces(cube.complex, 0).hexahedron(cube.positions), embed::Trilinear(corners)};
}

// A polynomial of degree 2 along each axis is determined by its values at 3 places along each; the
// test uses 4. The tolerance is the floor, which bounds the rounding.
TEST(Bernstein, DeterminantEqualsTheTrilinearJacobian) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        const RandomCell cell = randomCell(seed);
        const auto polynomial = determinant(cell.piece.derivatives);
        forGrid(3, [&](const Vector3d& uvw) {
            EXPECT_NEAR(valueAt(polynomial, 0, uvw), cell.map.jacobian(uvw).determinant(),
                        determinantFloor(cell.piece.size));
        });
    }
}

// Sizes of 60 orders of magnitude, with uncertainties from far below the lengths up to the longest.
TEST(ValidityPieces, LargestFloorIsAboveAllFloors) {
    const auto values = randomValues(16 * 2000, 7);
    for (std::size_t i = 0; i < values.size(); i += 16) {
        PieceSize first, last;
        const double scale = std::pow(10.0, 30 * values[i]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            first.lengths[axis] = scale * std::pow(10.0, 2 * values[i + 1 + axis]);
            last.lengths[axis] = scale * std::pow(10.0, 2 * values[i + 4 + axis]);
        }
        first.uncertainty = scale * std::pow(10.0, 10 * values[i + 7] - 8);
        last.uncertainty = scale * std::pow(10.0, 10 * values[i + 8] - 8);
        for (const double floor : determinantFloor(first, last))
            EXPECT_GE(largestFloor(first, last), floor) << i;
        // Equal sizes are the closest case.
        for (const double floor : determinantFloor(first, first))
            EXPECT_GE(largestFloor(first, first), floor) << i;
    }
}

// A cubic is determined by its values at 4 times.
TEST(Bernstein, DeterminantOfMovingMapsEqualsTheirJacobian) {
    for (unsigned seed = 0; seed < 5; ++seed) {
        const RandomCell first = randomCell(seed), last = randomCell(seed + 100);
        const auto polynomials = determinant(first.piece.derivatives, last.piece.derivatives);
        const auto floor = determinantFloor(first.piece.size, last.piece.size);
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

/// A tricubic map of random points, and its derivatives by definition.
struct RandomPatch {
    limit::BezierPatch patch;
    Piece<3> piece;

    explicit RandomPatch(unsigned seed) {
        const auto values = randomValues(192, seed);
        for (std::size_t i = 0; i < 192; ++i) patch.points[i / 3][i % 3] = values[i];
        patch.largestCoordinate = 1;
        piece = pieceOf(patch);
    }
    Eigen::Matrix3d jacobian(const Vector3d& uvw) const {
        const auto basis = [](std::size_t i, double t) {
            const double s = 1 - t;
            return std::array{s * s * s, 3 * t * s * s, 3 * t * t * s, t * t * t}[i];
        };
        const auto slope = [](std::size_t i, double t) {
            const double s = 1 - t;
            return std::array{-3 * s * s, 3 * s * s - 6 * t * s, 6 * t * s - 3 * t * t,
                              3 * t * t}[i];
        };
        Eigen::Matrix3d result = Eigen::Matrix3d::Zero();
        for (std::size_t i = 0; i < 64; ++i)
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                double weight = 1;
                const std::array<std::size_t, 3> place = {i % 4, i / 4 % 4, i / 16};
                for (Eigen::Index along = 0; along < 3; ++along)
                    weight *= (along == axis ? slope(place[std::size_t(along)], uvw[along])
                                             : basis(place[std::size_t(along)], uvw[along]));
                result.col(axis) += weight * Vector3d(patch.points[i].data());
            }
        return result;
    }
};

// Degree 8 would need values at 9 places along each axis; the test uses some of them.
TEST(Bernstein, DeterminantEqualsTheTricubicJacobian) {
    for (unsigned seed = 0; seed < 3; ++seed) {
        const RandomPatch first(seed), last(seed + 10);
        const auto polynomial = determinant(first.piece.derivatives);
        const auto onTheWay = determinant(first.piece.derivatives, last.piece.derivatives);
        forGrid(5, [&](const Vector3d& uvw) {
            const double expected = first.jacobian(uvw).determinant();
            EXPECT_NEAR(valueAt(polynomial, 0, uvw), expected, determinantFloor(first.piece.size));
            EXPECT_NEAR(valueAt(onTheWay, 0, uvw), expected, determinantFloor(first.piece.size));
            EXPECT_NEAR(valueAt(onTheWay, 3, uvw), last.jacobian(uvw).determinant(),
                        determinantFloor(last.piece.size));
            // Half way in time: (c₀ + 3c₁ + 3c₂ + c₃) / 8.
            double half = 0;
            for (std::size_t lane = 0; lane < 4; ++lane)
                half += (lane % 3 == 0 ? 0.125 : 0.375) * valueAt(onTheWay, lane, uvw);
            const auto floor = determinantFloor(first.piece.size, last.piece.size);
            EXPECT_NEAR(half, ((first.jacobian(uvw) + last.jacobian(uvw)) / 2).determinant(),
                        *std::max_element(floor.begin(), floor.end()));
        });
    }
}

// A tetrahedron has a constant determinant: all coefficients equal it exactly.
TEST(Bernstein, ConstantsStayConstant) {
    Derivatives<1> derivatives;
    derivatives[0].fill({1, 2, 3});
    derivatives[1].fill({-1, 1, 0.5});
    derivatives[2].fill({0.25, 0, 2});
    // 1·(2) − 2·(−2 − 0.125) + 3·(−0.25) = 2 + 4.25 − 0.75
    for (const auto& lanes : determinant(derivatives)) EXPECT_EQ(lanes[0], 5.5);
}

template <std::size_t Degree>
void expectHalvesAreTheSame() {
    Trivariate<Degree, 2> whole;
    const auto values = randomValues(2 * whole.size(), 3);
    for (std::size_t i = 0; i < values.size(); ++i) whole[i / 2][i % 2] = values[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto both = halves(whole, axis);
        for (std::size_t lane = 0; lane < 2; ++lane)
            forGrid(3, [&](const Vector3d& uvw) {
                Vector3d inLower = uvw, inUpper = uvw;
                inLower[Eigen::Index(axis)] /= 2;
                inUpper[Eigen::Index(axis)] = (1 + uvw[Eigen::Index(axis)]) / 2;
                // Means of numbers of size 1.
                EXPECT_NEAR(valueAt(both.first, lane, uvw), valueAt(whole, lane, inLower), 1e-14);
                EXPECT_NEAR(valueAt(both.second, lane, uvw), valueAt(whole, lane, inUpper), 1e-14);
            });
    }
}

TEST(Bernstein, HalvesAreTheSamePolynomials) {
    expectHalvesAreTheSame<2>();
    expectHalvesAreTheSame<8>();
}

TEST(Bernstein, PartsInTimeAreTheSamePolynomial) {
    const auto values = randomValues(108, 5);
    Trivariate<2, 4> whole;
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
