// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/topology_match.h>
#include <espalier/stencils/binding.h>
#include <espalier/stencils/tensor_product.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <map>

#include "support/tables.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::stencils {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using far::CellComplex;
using test::asMatrix;
using test::largestDistance;
using test::Positions;
using test::shaken;
using test::tableOf;
using test::times;
using ::testing::HasSubstr;
using Cells = std::array<Index, 3>;

/// Where the grid points of a box lie: a skew parallelepiped, away from the origin.
struct Skew {
    Vector3d origin{4, -3, 2};
    Matrix3d axes{{1.1, 0.4, -0.2}, {0.1, 0.7, 0.3}, {-0.3, 0.2, 0.9}};

    Point3 operator()(const Point3& at) const {
        const Vector3d position = origin + axes * Vector3d(at.data());
        return {position[0], position[1], position[2]};
    }
    std::vector<Point3> operator()(const std::vector<Point3>& points) const {
        std::vector<Point3> moved;
        for (const Point3& point : points) moved.push_back((*this)(point));
        return moved;
    }
};

/// Random points whose coordinate along axis a is from low to cells[a] − low.
std::vector<Point3> randomPoints(const Cells& cells, double low, std::size_t count, unsigned seed) {
    const auto values = test::randomValues(3 * count, seed);
    std::vector<Point3> points(count);
    for (std::size_t i = 0; i < 3 * count; ++i) {
        const double half = cells[i % 3] / 2.0;
        points[i / 3][i % 3] = half + (half - low) * values[i];
    }
    return points;
}

/// The row of one point in a unit grid.
std::map<Index, double> rowOf(const Cells& cells, Basis basis, const Point3& point,
                              OutsidePolicy outside = OutsidePolicy::Error) {
    const TensorLattice lattice(test::grid(cells), test::gridPositions(cells), basis);
    const auto table = tableOf(lattice, {point}, {.outside = outside});
    std::map<Index, double> row;
    for (std::size_t i = 0; i < table.columns(0).size(); ++i)
        row[table.columns(0)[i]] = table.weights(0)[i];
    return row;
}

void expectRow(const std::map<Index, double>& row, const std::map<Index, double>& expected) {
    ASSERT_EQ(row.size(), expected.size());
    for (const auto& [column, weight] : expected) {
        ASSERT_EQ(row.count(column), 1u) << column;
        // Some ten operations on numbers up to 1.
        EXPECT_NEAR(row.at(column), weight, 1e-15) << column;
    }
}

// Degree 1 is trilinear: of the eight vertices of a cube, (x or 1 − x) (y or 1 − y) (z or 1 − z).
TEST(TensorProduct, BezierLatticeOfOneCellIsTrilinear) {
    const double x = 0.25, y = 0.5, z = 0.875;
    expectRow(rowOf({1, 1, 1}, Basis::Bezier, {x, y, z}), {{0, (1 - x) * (1 - y) * (1 - z)},
                                                           {1, x * (1 - y) * (1 - z)},
                                                           {2, (1 - x) * y * (1 - z)},
                                                           {3, x * y * (1 - z)},
                                                           {4, (1 - x) * (1 - y) * z},
                                                           {5, x * (1 - y) * z},
                                                           {6, (1 - x) * y * z},
                                                           {7, x * y * z}});
}

// Degree 2 along x, at its middle: (1/4, 1/2, 1/4), times 1/2 and 1/2. At an end of y and z, those
// are 1 and 0: outermost edges are curves of their own.
TEST(TensorProduct, BezierRowsByHand) {
    std::map<Index, double> expected;
    for (Index v = 0; v < 12; ++v) expected[v] = v % 3 == 1 ? 1. / 8 : 1. / 16;
    expectRow(rowOf({2, 1, 1}, Basis::Bezier, {1, 0.5, 0.5}), expected);
    expectRow(rowOf({2, 1, 1}, Basis::Bezier, {1, 0, 0}), {{0, 0.25}, {1, 0.5}, {2, 0.25}});
}

// Bézier lattices interpolate their corners.
TEST(TensorProduct, BezierLatticesInterpolateTheirCorners) {
    const Cells n = {3, 2, 4};
    for (const Index i : {0, n[0]})
        for (const Index j : {0, n[1]})
            for (const Index k : {0, n[2]})
                expectRow(rowOf(n, Basis::Bezier, {double(i), double(j), double(k)}),
                          {{test::gridVertex(n, i, j, k), 1}});
}

// At a knot a cubic B-spline weighs its neighbours 1/6, 4/6, 1/6.
TEST(TensorProduct, BSplineRowsByHand) {
    const Cells n = {4, 4, 4};
    const std::array<double, 3> knot = {1. / 6, 4. / 6, 1. / 6};
    std::map<Index, double> expected;
    for (Index i = 0; i < 3; ++i)
        for (Index j = 0; j < 3; ++j)
            for (Index k = 0; k < 3; ++k)
                expected[test::gridVertex(n, i + 1, j + 1, k)] = knot[static_cast<std::size_t>(i)] *
                                                                 knot[static_cast<std::size_t>(j)] *
                                                                 knot[static_cast<std::size_t>(k)];
    expectRow(rowOf(n, Basis::BSpline, {2, 2, 1}), expected);
}

// Rows are the products of the rows of the axes, which have tests of their own.
TEST(TensorProduct, RowsAreProductsOfTheAxes) {
    const Cells n = {3, 4, 5};
    for (const Basis basis : {Basis::Bezier, Basis::BSpline})
        for (const Point3& point : randomPoints(n, 1, 20, 3)) {
            std::map<Index, double> expected;
            const auto x = axisFunctions(basis, n[0], point[0]);
            const auto y = axisFunctions(basis, n[1], point[1]);
            const auto z = axisFunctions(basis, n[2], point[2]);
            for (std::size_t i = 0; i < x.values.size(); ++i)
                for (std::size_t j = 0; j < y.values.size(); ++j)
                    for (std::size_t k = 0; k < z.values.size(); ++k)
                        expected[test::gridVertex(n, x.first + static_cast<Index>(i),
                                                  y.first + static_cast<Index>(j),
                                                  z.first + static_cast<Index>(k))] =
                            x.values[i] * y.values[j] * z.values[k];
            expectRow(rowOf(n, basis, point), expected);
        }
}

TEST(TensorProduct, RowsSumToOne) {
    const Cells n = {4, 3, 6};
    for (const Basis basis : {Basis::Bezier, Basis::BSpline}) {
        const TensorLattice lattice(test::grid(n), Skew()(test::gridPositions(n)), basis);
        // Points up to 3 cells outside, too.
        const auto points = Skew()(randomPoints(n, -3, 300, 5));
        const auto table = tableOf(lattice, points, {.outside = OutsidePolicy::Nearest});
        for (Index row = 0; row < table.rowCount(); ++row) {
            double sum = 0, sizes = 0;
            for (const double weight : table.weights(row)) {
                sum += weight;
                sizes += std::abs(weight);
            }
            // 1e-14 of the sizes of the weights, as for D of subdivision.
            EXPECT_NEAR(sum, 1, 1e-14 * sizes);
            if (basis == Basis::BSpline) {
                EXPECT_LE(table.columns(row).size(), 64u);
            }
        }
    }
}

// Both bases have linear precision, and the tangent goes on with it: at rest every point stays.
TEST(TensorProduct, TheRestPoseGivesEveryPointBack) {
    for (const Cells& n : {Cells{3, 3, 3}, {4, 3, 7}, {12, 3, 3}})
        for (const Basis basis : {Basis::Bezier, Basis::BSpline}) {
            const auto rest = Skew()(test::gridPositions(n));
            const TensorLattice lattice(test::grid(n), rest, basis);
            const auto points = Skew()(randomPoints(n, -1, 500, 7));
            const auto embedding =
                embedPoints(lattice, points, {.outside = OutsidePolicy::Nearest});
            EXPECT_GT(embedding.count(PointStatus::Inside), 0);
            EXPECT_GT(embedding.count(PointStatus::Outside), 0);
            const auto table = buildDeformationTable(lattice, embedding);
            const double off = largestDistance(times(table, rest), asMatrix(points));
            // 1e-12 of the size of the lattice is what the project promises; it is 4 and more.
            EXPECT_LT(off, 4e-12);
            EXPECT_NEAR(embedding.largestResidual(), off, 1e-13);
        }
}

// A polynomial of the lattice's degrees in x, y and z is reproduced by its Bézier coefficients:
// those of xᵃ, for x from 0 to 1 and degree n, are C(i, a) / C(n, a).
TEST(TensorProduct, BezierLatticesHaveThePrecisionOfTheirDegrees) {
    const Cells n = {3, 2, 4};
    const auto choose = [](Index from, Index count) {
        double value = 1;
        for (Index k = 0; k < count; ++k) value *= double(from - k) / (k + 1);
        return value;
    };
    const auto factors = test::randomValues(4 * 3 * 5, 8);
    const auto points = randomPoints(n, 0, 100, 9);
    const TensorLattice lattice(test::grid(n), test::gridPositions(n), Basis::Bezier);
    std::vector<Point3> pose(4 * 3 * 5, Point3{});
    std::vector<double> expected(points.size(), 0);
    std::size_t next = 0;
    for (Index a = 0; a <= n[0]; ++a)
        for (Index b = 0; b <= n[1]; ++b)
            for (Index c = 0; c <= n[2]; ++c) {
                const double factor = factors[next++];
                for (Index k = 0; k <= n[2]; ++k)
                    for (Index j = 0; j <= n[1]; ++j)
                        for (Index i = 0; i <= n[0]; ++i)
                            pose[static_cast<std::size_t>(test::gridVertex(n, i, j, k))][0] +=
                                factor * choose(i, a) / choose(n[0], a) * choose(j, b) /
                                choose(n[1], b) * choose(k, c) / choose(n[2], c);
                for (std::size_t p = 0; p < points.size(); ++p)
                    expected[p] += factor * std::pow(points[p][0] / n[0], a) *
                                   std::pow(points[p][1] / n[1], b) *
                                   std::pow(points[p][2] / n[2], c);
            }
    const Positions got = times(tableOf(lattice, points), pose);
    for (std::size_t p = 0; p < points.size(); ++p)
        // Sums of sixty terms up to 1.
        EXPECT_NEAR(got(static_cast<Eigen::Index>(p), 0), expected[p], 1e-14);
}

// A product of cubics is reproduced by its B-spline coefficients: its polar forms at
// (x − 1, x, x + 1), which for 1, x, x² and x³ are 1, x, x² − 1/3 and x³ − x.
TEST(TensorProduct, BSplineLatticesHaveCubicPrecision) {
    const Cells n = {4, 3, 5};
    const std::array<std::array<double, 4>, 3> cubics = {
        {{0.3, -1.1, 0.7, 0.4}, {1.2, 0.5, -0.6, 0.2}, {-0.8, 0.9, 0.3, -0.1}}};
    const auto product = [&](const Point3& at, bool isCoefficient) {
        double value = 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto& [a, b, c, d] = cubics[axis];
            const double x = at[axis];
            value *= isCoefficient ? a + b * x + c * (x * x - 1. / 3) + d * (x * x * x - x)
                                   : a + x * (b + x * (c + x * d));
        }
        return value;
    };
    const auto rest = test::gridPositions(n);
    std::vector<Point3> pose;
    for (const Point3& at : rest) pose.push_back({product(at, true), 0, 0});
    const auto points = randomPoints(n, 1, 200, 10);
    const TensorLattice lattice(test::grid(n), rest, Basis::BSpline);
    const Positions got = times(tableOf(lattice, points), pose);
    for (std::size_t p = 0; p < points.size(); ++p)
        // 64 products of numbers that reach some 2000 at the far corner.
        EXPECT_NEAR(got(static_cast<Eigen::Index>(p), 0), product(points[p], false), 1e-11);
}

// The numbering of vertices and cells does not count: columns are renamed with the vertices.
TEST(TensorProduct, RelabellingRenamesTheColumns) {
    const Cells n = {3, 5, 4};
    const auto rest = Skew()(test::gridPositions(n));
    const auto pose = shaken(rest, 11);
    const auto points = Skew()(randomPoints(n, -1, 300, 12));
    const auto names = test::shuffledIndices(static_cast<Index>(rest.size()), 13);
    auto restThere = rest, poseThere = pose;
    for (std::size_t v = 0; v < names.size(); ++v) {
        restThere[static_cast<std::size_t>(names[v])] = rest[v];
        poseThere[static_cast<std::size_t>(names[v])] = pose[v];
    }
    const CellComplex there = test::relabelled(test::grid(n), names, 14);
    for (const Basis basis : {Basis::Bezier, Basis::BSpline}) {
        const EmbeddingOptions options = {.outside = OutsidePolicy::Nearest};
        const auto here = tableOf(TensorLattice(test::grid(n), rest, basis), points, options);
        const auto other = tableOf(TensorLattice(there, restThere, basis), points, options);
        // The fit adds up in another order; the map of the pose is a few times steeper than that
        // of the rest pose, outside too.
        EXPECT_LT(largestDistance(times(here, pose), times(other, poseThere)), 1e-12);
    }
}

// The row goes on along the tangent. Degree 2 in x at its end: values (0, 0, 1), and derivatives
// by the place (0, −1, 1), so half a cell beyond (0, −1/2, 3/2); y and z at 0.
TEST(TensorProduct, PointsOutsideGoOnAlongTheTangent) {
    expectRow(rowOf({2, 1, 1}, Basis::Bezier, {2.5, 0, 0}, OutsidePolicy::Nearest),
              {{1, -0.5}, {2, 1.5}});
    // By 1/2 along x, where (0, 1) has the derivatives (−1, 1), and by −1 along y likewise: the
    // tangent has no product of the two.
    expectRow(rowOf({1, 1, 1}, Basis::Bezier, {1.5, -1, 0}, OutsidePolicy::Nearest),
              {{0, -0.5}, {1, 1 + 0.5 + 1}, {3, -1}});
}

TEST(TensorProduct, PointsOutsideAreKeptCarriedOrRefused) {
    const Cells n = {4, 4, 4};
    const auto rest = test::gridPositions(n);
    const TensorLattice lattice(test::grid(n), rest, Basis::BSpline);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Point3> points = {{2, 2, 2}, {0.5, 2, 2}, {nan, 2, 2}, {1, 3, 3}};

    const auto kept = embedPoints(lattice, points);
    EXPECT_EQ(kept.count(PointStatus::Inside), 2);
    EXPECT_EQ(kept.points[1].status, PointStatus::Outside);
    EXPECT_FALSE(kept.points[1].place);
    EXPECT_EQ(kept.points[2].status, PointStatus::NotConverged);
    const auto binding = makeBinding<double>(lattice, kept, points);
    EXPECT_EQ(binding.kept, (std::vector<Index>{1, 2}));
    EXPECT_EQ(binding.keptAt[0], points[1]);
    EXPECT_TRUE(binding.table.columns(1).empty());
    EXPECT_EQ(binding.topologyHash, far::topologyHash(lattice.complex()));

    const auto carried = embedPoints(lattice, points, {.outside = OutsidePolicy::Nearest});
    EXPECT_EQ(carried.points[1].status, PointStatus::Outside);
    EXPECT_EQ(carried.points[1].distance, 0.5);
    EXPECT_FALSE(carried.points[2].place);
    EXPECT_EQ(makeBinding<float>(lattice, carried, points).kept, (std::vector<Index>{2}));

    try {
        embedPoints(lattice, points, {.outside = OutsidePolicy::Error});
        FAIL() << "accepted";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("point 1 at (0.5, 2, 2) is outside the lattice"));
    }
    EXPECT_THROW(makeBinding<double>(lattice, kept, std::span(points).first(2)), Error);
}

// The tolerance is a distance, here of 1e-6 × √48.
TEST(TensorProduct, PointsWithinTheToleranceAreInside) {
    const Cells n = {4, 4, 4};
    const TensorLattice lattice(test::grid(n), test::gridPositions(n), Basis::Bezier);
    const std::vector<Point3> points = {{-6.9e-6, 2, 2}, {-7e-6, 2, 2}, {-5e-6, -5e-6, 4}};
    const auto embedding = embedPoints(lattice, points);
    EXPECT_EQ(embedding.points[0].status, PointStatus::Inside);
    EXPECT_EQ(embedding.points[1].status, PointStatus::Outside);
    // √2 times 5e-6 is beyond.
    EXPECT_EQ(embedding.points[2].status, PointStatus::Outside);
    EXPECT_LT(embedding.points[0].residual, 1e-15);
    // Without tolerance, the boundary itself is inside.
    const auto exact = embedPoints(lattice, std::vector<Point3>{{0, 4, 2}}, {.tolerance = 0});
    EXPECT_EQ(exact.count(PointStatus::Inside), 1);
}

// In a skew lattice the nearest place is not where clamping leads.
TEST(TensorProduct, NearestPlaceMatchesBruteForce) {
    const Cells n = {2, 1, 1};
    const TensorLattice lattice(test::grid(n), Skew()(test::gridPositions(n)), Basis::Bezier);
    const Matrix3d& axes = Skew().axes;
    for (const Point3& local : randomPoints(n, -4, 200, 15)) {
        const Point3 point = Skew()(local);
        const auto located = lattice.locate(point, 0, true);
        ASSERT_TRUE(located.place);
        double sampled = std::numeric_limits<double>::infinity();
        for (int i = 0; i <= 40; ++i)
            for (int j = 0; j <= 20; ++j)
                for (int k = 0; k <= 20; ++k) {
                    const Vector3d off =
                        Vector3d(i / 20., j / 20., k / 20.) - Vector3d(local.data());
                    sampled = std::min(sampled, (axes * off).norm());
                }
        // Nothing sampled is nearer; and the nearest place is half a step at most from a sample
        // along each axis, which is 0.025 × √3 of the longest.
        EXPECT_LE(located.distance, sampled + 1e-12);
        EXPECT_GE(located.distance, sampled - 0.025 * axes.colwise().norm().sum());
        EXPECT_LT(located.residual, 1e-13);
    }
}

/// The message of what a lattice is refused with.
std::string refusalOf(const CellComplex& complex, const std::vector<Point3>& rest, Basis basis) {
    try {
        TensorLattice(complex, rest, basis);
    } catch (const Error& error) {
        return error.what();
    }
    ADD_FAILURE() << "accepted";
    return {};
}

TEST(TensorProduct, LatticesThatAreNoParallelepipedsAreRefused) {
    const Cells n = {3, 3, 3};
    const CellComplex complex = test::grid(n);
    const auto rest = test::gridPositions(n);
    auto moved = rest;
    moved[21][1] += 0.1;
    // Of a displacement of one vertex, the fit leaves all but a part of 1/64 for its place and one
    // a direction.
    EXPECT_THAT(refusalOf(complex, moved, Basis::Bezier), HasSubstr("vertex 21 is 0.09"));
    auto broken = rest;
    broken[5][2] = std::numeric_limits<double>::infinity();
    EXPECT_THAT(refusalOf(complex, broken, Basis::Bezier), HasSubstr("vertex 5 is not finite"));
    auto flat = rest;
    for (Point3& position : flat) position[2] = position[0] + 2 * position[1];
    EXPECT_THAT(refusalOf(complex, flat, Basis::Bezier), HasSubstr("no volume"));
    // Thin is not flat: that is a matter of angles. This one leans over by all but 1e-10.
    auto leaning = rest;
    for (Point3& position : leaning)
        position = {position[0] + position[2], position[1] + position[2], 1e-10 * position[2]};
    EXPECT_THAT(refusalOf(complex, leaning, Basis::Bezier), HasSubstr("no volume"));
    auto thin = rest;
    for (Point3& position : thin) position[2] *= 1e-10;
    EXPECT_NO_THROW(TensorLattice(complex, thin, Basis::Bezier));
    const std::vector<Point3> nowhere(rest.size(), Point3{1, 2, 3});
    EXPECT_THAT(refusalOf(complex, nowhere, Basis::Bezier), HasSubstr("no volume"));
    EXPECT_THAT(refusalOf(complex, {rest.begin(), rest.end() - 1}, Basis::Bezier),
                HasSubstr("63 positions for 64 vertices"));
    // Evenly divided: steps of different length are not.
    auto uneven = rest;
    for (Point3& position : uneven) position[0] *= position[0];
    EXPECT_THAT(refusalOf(complex, uneven, Basis::Bezier), HasSubstr("evenly divided"));
    const Lattice torus = shapes::torus();
    EXPECT_THROW(TensorLattice(torus.complex, torus.positions, Basis::Bezier), far::TopologyError);
}

TEST(TensorProduct, BSplineLatticesNeedThreeCellsAnAxis) {
    const Cells n = {3, 2, 4};
    EXPECT_THAT(refusalOf(test::grid(n), test::gridPositions(n), Basis::BSpline),
                HasSubstr("3 × 2 × 4"));
}

TEST(TensorProduct, ATableBelongsToItsLattice) {
    const Cells n = {3, 3, 3}, m = {3, 3, 4};
    const TensorLattice lattice(test::grid(n), test::gridPositions(n), Basis::Bezier);
    const TensorLattice other(test::grid(m), test::gridPositions(m), Basis::Bezier);
    const auto embedding = embedPoints(lattice, std::vector<Point3>{{1, 1, 1}});
    EXPECT_THROW(buildDeformationTable(other, embedding), Error);
    EXPECT_THROW(embedPoints(lattice, std::vector<Point3>{}, {.tolerance = -1}), Error);
}

// Rest files of floats, and of six digits, are taken, and what they are off is reported.
TEST(TensorProduct, RestPositionsMayBeRounded) {
    const Cells n = {7, 3, 6};
    Skew skew;
    skew.axes /= 7;
    const auto exact = skew(test::gridPositions(n));
    auto floats = exact, digits = exact;
    for (std::size_t v = 0; v < exact.size(); ++v)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            floats[v][axis] = static_cast<float>(exact[v][axis]);
            // Coordinates are under 10: six digits have five decimals.
            digits[v][axis] = std::round(exact[v][axis] * 1e5) / 1e5;
        }
    const auto points = skew(randomPoints(n, 1, 100, 16));
    for (const auto& [rest, off] : {std::pair{floats, 1e-6}, {digits, 1e-5}}) {
        const TensorLattice lattice(test::grid(n), rest, Basis::BSpline);
        const auto embedding = embedPoints(lattice, points);
        EXPECT_EQ(embedding.count(PointStatus::Inside), 100);
        EXPECT_GT(embedding.largestResidual(), 1e-9);
        EXPECT_LT(embedding.largestResidual(), off);
    }
}

TEST(TensorProduct, DoesNotDependOnTheNumberOfThreads) {
    const Cells n = {4, 4, 4};
    const TensorLattice lattice(test::grid(n), test::gridPositions(n), Basis::BSpline);
    const auto points = randomPoints(n, 0, 9000, 17);
    const auto bind = [&](int threads) {
        return test::withThreads(
            threads, [&] { return tableOf(lattice, points, {.outside = OutsidePolicy::Nearest}); });
    };
    const auto one = bind(1);
    EXPECT_EQ(one, bind(2));
    EXPECT_EQ(one, bind(8));
}

}  // namespace
}  // namespace espalier::stencils
