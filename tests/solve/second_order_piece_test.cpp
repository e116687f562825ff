// SPDX-License-Identifier: Apache-2.0
// Cells of second order: their maps against polynomials that are found from their monomials alone,
// and their checks.
#include <espalier/far/second_order_cells.h>
#include <espalier/solve/validity.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <bit>
#include <functional>
#include <numeric>

#include "poses.h"
#include "solve/second_order_piece.h"
#include "support/test.h"

namespace espalier::solve {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using far::StandardCell;

constexpr std::size_t kSizes[] = {10, 13, 14, 15, 18, 20, 27};

/// The corners of a cell in the coordinates of textbooks: r, s and t from 0 to 1; a triangle has
/// r + s ≤ 1, and the apex of a pyramid is over (½, ½).
std::vector<Vector3d> cornersOf(StandardCell kind) {
    switch (kind) {
        case StandardCell::Tetrahedron:
            return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        case StandardCell::Pyramid:
            return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}};
        case StandardCell::Wedge:  // VTK's first triangle is clockwise seen from the other one.
            return {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
        case StandardCell::Hexahedron:
            break;
    }
    return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
}

/// Returns the points of a straight cell: each is the mean of the corners of its place.
std::vector<Vector3d> nodesOf(std::size_t size) {
    const auto corners = cornersOf(*far::kindOfCell(size));
    std::vector<Vector3d> nodes;
    for (const far::CornerBits place : far::cellPoints(size)) {
        Vector3d sum = Vector3d::Zero();
        for (std::size_t i = 0; i < corners.size(); ++i)
            if (place >> i & 1) sum += corners[i];
        nodes.push_back(sum / std::popcount(place));
    }
    return nodes;
}

Positions toPositions(const std::vector<Vector3d>& points) {
    Positions result;
    for (const Vector3d& p : points) result.push_back({p[0], p[1], p[2]});
    return result;
}

/// Returns the monomials that span the maps of a cell, as textbooks list them, at a place.
VectorXd monomials(std::size_t size, const Vector3d& place) {
    const double r = place[0], s = place[1], t = place[2];
    std::vector<double> values;
    const auto power = [](double base, int exponent) { return std::pow(base, exponent); };
    for (int c = 0; c <= 2; ++c)
        for (int b = 0; b <= 2; ++b)
            for (int a = 0; a <= 2; ++a) {
                const double product = power(r, a) * power(s, b) * power(t, c);
                const int quadratic = (a == 2) * 2 + (b == 2) * 2 + (c == 2) * 2;
                switch (size) {
                    case 10:  // Degree 2.
                        if (a + b + c <= 2) values.push_back(product);
                        break;
                    case 15:  // Degree 2 over the triangle times 1 and t, and degree 1 times t².
                        if (a + b <= (c == 2 ? 1 : 2)) values.push_back(product);
                        break;
                    case 18:
                        if (a + b <= 2) values.push_back(product);
                        break;
                    case 20:  // At most 2 in factors that are not linear.
                        if (quadratic <= 2) values.push_back(product);
                        break;
                    case 27:
                        values.push_back(product);
                        break;
                    default: {  // xⁱ yʲ (1 − z)^max zᵏ in the collapsed cube, max + k ≤ 2.
                        const double height = 1 - t;
                        const double x = height > 0 ? (r - t / 2) / height : 0.5,
                                     y = height > 0 ? (s - t / 2) / height : 0.5;
                        const int larger = std::max(a, b);
                        if (larger + c > 2 || (size == 13 && a == 2 && b == 2)) break;
                        values.push_back(power(x, a) * power(y, b) * power(height, larger) *
                                         power(t, c));
                    }
                }
            }
    return Eigen::Map<VectorXd>(values.data(), Eigen::Index(values.size()));
}

/// The map of a cell, from the values at its points.
class ReferenceMap {
public:
    ReferenceMap(std::size_t size, const Positions& points) : size_(size) {
        const auto nodes = nodesOf(size);
        MatrixXd values(size, size), targets(size, 3);
        for (Eigen::Index i = 0; i < Eigen::Index(size); ++i) {
            values.row(i) = monomials(size, nodes[std::size_t(i)]).transpose();
            targets.row(i) = Vector3d(points[std::size_t(i)].data()).transpose();
        }
        coefficients_ = values.fullPivLu().solve(targets);
    }

    /// By central differences of fourth order, whose error is below 1e-9 at a step of 1e-3: the
    /// maps are of size 1, and their fifth derivatives below 100.
    double determinant(const Vector3d& place) const {
        Matrix3d jacobian;
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            const auto at = [&](double step) -> Vector3d {
                return coefficients_.transpose() *
                       monomials(size_, place + step * Vector3d::Unit(axis));
            };
            constexpr double h = 1e-3;
            jacobian.col(axis) = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
        }
        return jacobian.determinant();
    }

private:
    std::size_t size_;
    MatrixXd coefficients_;
};

/// Returns the place in a cell of a place in its collapsed cube.
Vector3d fromCube(StandardCell kind, const Vector3d& cube) {
    const double u = cube[0], v = cube[1], w = cube[2];
    switch (kind) {
        case StandardCell::Tetrahedron:
            return {u, v * (1 - u), w * (1 - u) * (1 - v)};
        case StandardCell::Wedge:
            return {u, v * (1 - u), w};
        case StandardCell::Pyramid:
            return {u * (1 - w) + w / 2, v * (1 - w) + w / 2, w};
        case StandardCell::Hexahedron:
            break;
    }
    return cube;
}

double valueAt(const Trivariate<5, 1>& polynomial, const Vector3d& place) {
    constexpr double kBinomial[] = {1, 5, 10, 10, 5, 1};
    double sum = 0;
    for (std::size_t i = 0; i < polynomial.size(); ++i) {
        double product = polynomial[i][0];
        std::size_t rest = i;
        for (Eigen::Index axis = 0; axis < 3; ++axis, rest /= 6) {
            const int k = int(rest % 6);
            product *= kBinomial[k] * std::pow(place[axis], k) * std::pow(1 - place[axis], 5 - k);
        }
        sum += product;
    }
    return sum;
}

std::vector<Index> numbersTo(std::size_t count) {
    std::vector<Index> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0);
    return numbers;
}

ValidityCheck checkOf(std::size_t size, const Positions& rest) {
    far::VolumeMeshBuilder builder(Index(rest.size()));
    builder.addCell(*far::kindOfCell(size), numbersTo(size));
    return {builder.build(), rest};
}

TEST(SecondOrderPiece, DeterminantsAreThoseOfTheMapThatTheMonomialsGive) {
    for (const std::size_t size : kSizes) {
        for (unsigned seed = 0; seed < 5; ++seed) {
            const Positions points = shaken(toPositions(nodesOf(size)), seed, 0.2);
            const ReferenceMap reference(size, points);
            const auto polynomial =
                determinant(secondOrderCell(numbersTo(size), points).derivatives);
            const auto values = randomValues(30, seed);
            for (std::size_t i = 0; i < values.size(); i += 3) {
                // Between 0.05 and 0.95: the reference divides by 1 − t in pyramids.
                Vector3d cube(values[i], values[i + 1], values[i + 2]);
                cube = 0.5 * Vector3d::Ones() + 0.45 * cube;
                EXPECT_NEAR(valueAt(polynomial, cube),
                            reference.determinant(fromCube(*far::kindOfCell(size), cube)), 1e-7)
                    << size << " points, seed " << seed;
            }
        }
    }
}

// The middle of the edge from corner 0 to corner 1 (0 to 2 in a wedge) moves to corner 0. Along
// this edge, from 0 to 1, the map is x + 4 d x (1 − x) with d from 0 to −½: its slope at 0 is
// 1 + 4 d, which is 0 at d = −¼. In the cell, the slope of the shape function is largest there.
TEST(SecondOrderPiece, AnEdgeFoldsWhenItsMiddleComesToAQuarter) {
    for (const std::size_t size : kSizes) {
        const Positions rest = toPositions(nodesOf(size));
        const auto places = far::cellPoints(size);
        const far::CornerBits edge = far::kindOfCell(size) == StandardCell::Wedge ? 0b101 : 0b11;
        Positions pose = rest;
        pose[std::size_t(std::ranges::find(places, edge) - places.begin())] = rest[0];
        const ValidityCheck check = checkOf(size, rest);
        EXPECT_THAT(check.badAtRest(), IsEmpty()) << size;
        EXPECT_THAT(check.check(pose).inverted, ElementsAre(0)) << size;
        const LargestStep step = check.largestStep(pose);
        EXPECT_LT(step.length, 0.5) << size;
        // Rounding that is allowed for: 3e-13 of the coordinates in each of the three derivatives,
        // whose lengths are up to 6, relative to the slope 2.
        EXPECT_NEAR(step.length, 0.5, 1e-9) << size;
        EXPECT_TRUE(step.isTight) << size;
    }
}

// The corners stay, so that a check of the straight cell would find nothing.
TEST(SecondOrderPiece, AgreesWithSampledDeterminants) {
    constexpr int kParts = 8;
    for (const std::size_t size : kSizes) {
        const StandardCell kind = *far::kindOfCell(size);
        const Positions rest = toPositions(nodesOf(size));
        const ValidityCheck check = checkOf(size, rest);
        int valid = 0, inverted = 0;
        for (unsigned seed = 0; seed < 40; ++seed) {
            const Positions pose = shaken(rest, seed, 0.02 + 0.006 * seed);
            const auto polynomial = determinant(secondOrderCell(numbersTo(size), pose).derivatives);
            double least = kInfinity;
            for (int i = 0; i <= kParts; ++i)
                for (int j = 0; j <= kParts; ++j)
                    for (int k = 0; k <= kParts; ++k)
                        least = std::min(least,
                                         valueAt(polynomial, Vector3d(i, j, k) / double(kParts)));
            const PoseValidity found = check.check(pose);
            if (least <= 0) {
                EXPECT_THAT(found.inverted, ElementsAre(0)) << size << " " << seed;
                const LargestStep step = check.largestStep(pose);
                EXPECT_LT(step.length, 1);
                EXPECT_THAT(check.check(moved(rest, pose, step.length)).inverted, IsEmpty());
                EXPECT_THAT(check.check(moved(rest, pose, step.length * (1 + 3e-6))).inverted,
                            ElementsAre(0));
            }
            if (least > 0.1) {
                EXPECT_THAT(found.inverted, IsEmpty()) << size << " " << seed;
            }
            (found.inverted.empty() ? valid : inverted)++;
        }
        EXPECT_GT(valid, 3) << int(kind);
        EXPECT_GT(inverted, 3) << int(kind);
    }
}

// A straight cell of second order is the cell of first order.
TEST(SecondOrderPiece, StraightCellsHaveTheStepOfTheCellOfFirstOrder) {
    for (const std::size_t size : {10, 14, 18, 27}) {
        const StandardCell kind = *far::kindOfCell(size);
        const auto straight = [&](const Positions& corners) {
            Positions points;
            for (const far::CornerBits place : far::cellPoints(size)) {
                Vector3d sum = Vector3d::Zero();
                for (std::size_t i = 0; i < corners.size(); ++i)
                    if (place >> i & 1) sum += Vector3d(corners[i].data());
                sum /= std::popcount(place);
                points.push_back({sum[0], sum[1], sum[2]});
            }
            return points;
        };
        const Positions corners = toPositions(cornersOf(kind));
        const ValidityCheck first = checkOf(std::size_t(far::vertexCount(kind)), corners),
                            second = checkOf(size, straight(corners));
        for (unsigned seed = 0; seed < 20; ++seed) {
            const Positions pose = shaken(corners, seed, 0.8);
            const double length = first.largestStep(pose).length;
            // A millionth is the precision of steps that end inside a cell.
            EXPECT_NEAR(second.largestStep(straight(pose)).length, length, 2e-6 * length) << size;
        }
    }
}

TEST(SecondOrderPiece, FarFromTheOriginRoundingIsAllowedFor) {
    for (const std::size_t size : kSizes) {
        Positions rest = toPositions(nodesOf(size));
        for (Point3& p : rest) p = {p[0] + 1e9, p[1] - 3e9, p[2]};
        const ValidityCheck check = checkOf(size, rest);
        EXPECT_THAT(check.badAtRest(), IsEmpty());
        EXPECT_THAT(check.check(rest).inverted, IsEmpty());
        EXPECT_NEAR(check.check(rest).smallest->value, 1, 1e-2);
    }
}

}  // namespace
}  // namespace espalier::solve
