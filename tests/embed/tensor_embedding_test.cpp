// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/tensor_product.h>
#include <espalier/far/topology_match.h>

#include "support/skew_boxes.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::embed {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(TensorEmbedding, PointsOutsideAreKeptCarriedOrRefused) {
    const Cells n = {4, 4, 4};
    const auto rest = gridPositions(n);
    const TensorLattice lattice(grid(n), rest, Basis::BSpline);
    const std::vector<Point3> points = {{2, 2, 2}, {0.5, 2, 2}, {kNan, 2, 2}, {1, 3, 3}};

    const auto kept = embedPoints(lattice, points);
    EXPECT_EQ(kept.count(PointStatus::Inside), 2);
    EXPECT_EQ(kept.points[1].status, PointStatus::Outside);
    EXPECT_FALSE(kept.points[1].place);
    EXPECT_EQ(kept.points[2].status, PointStatus::NotConverged);
    EXPECT_EQ(buildDeformationTable(lattice, kept).emptyRows(), (std::vector<Index>{1, 2}));

    const auto carried = embedPoints(lattice, points, {.outside = OutsidePolicy::Nearest});
    EXPECT_EQ(carried.points[1].status, PointStatus::Outside);
    EXPECT_EQ(carried.points[1].distance, 0.5);
    EXPECT_FALSE(carried.points[2].place);
    EXPECT_EQ(buildDeformationTable(lattice, carried).emptyRows(), (std::vector<Index>{2}));

    EXPECT_REFUSED(Error, "point 1 at (0.5, 2, 2) is outside the lattice",
                   embedPoints(lattice, points, {.outside = OutsidePolicy::Error}));
}

// The tolerance is a distance, here 1e-6 × √48.
TEST(TensorEmbedding, PointsWithinTheToleranceAreInside) {
    const Cells n = {4, 4, 4};
    const TensorLattice lattice(grid(n), gridPositions(n), Basis::Bezier);
    const std::vector<Point3> points = {{-6.9e-6, 2, 2}, {-7e-6, 2, 2}, {-5e-6, -5e-6, 4}};
    const auto embedding = embedPoints(lattice, points);
    EXPECT_EQ(embedding.points[0].status, PointStatus::Inside);
    EXPECT_EQ(embedding.points[1].status, PointStatus::Outside);
    // √2 times 5e-6 exceeds the tolerance.
    EXPECT_EQ(embedding.points[2].status, PointStatus::Outside);
    EXPECT_LT(embedding.points[0].residual, 1e-15);
    // Without tolerance, the boundary itself is inside.
    const auto exact = embedPoints(lattice, std::vector<Point3>{{0, 4, 2}}, {.tolerance = 0});
    EXPECT_EQ(exact.count(PointStatus::Inside), 1);
}

// In a skew lattice, clamping does not give the nearest place.
TEST(TensorEmbedding, NearestPlaceMatchesBruteForce) {
    const Cells n = {2, 1, 1};
    const TensorLattice lattice(grid(n), Skew()(gridPositions(n)), Basis::Bezier);
    const Matrix3d& axes = Skew().axes;
    for (const Point3& local : randomPoints(n, -4, 200, 15)) {
        const Point3 point = Skew()(local);
        const auto located = lattice.locate(point, 0, true);
        ASSERT_TRUE(located.place);
        double sampled = kInfinity;
        for (int i = 0; i <= 40; ++i)
            for (int j = 0; j <= 20; ++j)
                for (int k = 0; k <= 20; ++k) {
                    const Vector3d off =
                        Vector3d(i / 20., j / 20., k / 20.) - Vector3d(local.data());
                    sampled = std::min(sampled, (axes * off).norm());
                }
        // No sample is nearer. The nearest place is at most half a step from a sample along each
        // axis, which is 0.025 × √3 of the longest axis.
        EXPECT_LE(located.distance, sampled + 1e-12);
        EXPECT_GE(located.distance, sampled - 0.025 * axes.colwise().norm().sum());
        EXPECT_LT(located.residual, 1e-13);
    }
}

/// Returns the error message for a lattice that is refused.
std::string refusalOf(const CellComplex& complex, const std::vector<Point3>& rest, Basis basis) {
    return messageOf([&] { TensorLattice(complex, rest, basis); });
}

TEST(TensorEmbedding, LatticesOtherThanParallelepipedsAreRefused) {
    const Cells n = {3, 3, 3};
    const CellComplex complex = grid(n);
    const auto rest = gridPositions(n);
    auto moved = rest;
    moved[21][1] += 0.1;
    // The least-squares fit absorbs only a small part of the displacement of one vertex: 1/64 by
    // translation, and a part by each of the three axes.
    EXPECT_THAT(refusalOf(complex, moved, Basis::Bezier), HasSubstr("vertex 21 is 0.09"));
    auto broken = rest;
    broken[5][2] = kInfinity;
    EXPECT_THAT(refusalOf(complex, broken, Basis::Bezier), HasSubstr("vertex 5 is not finite"));
    auto flat = rest;
    for (Point3& position : flat) position[2] = position[0] + 2 * position[1];
    EXPECT_THAT(refusalOf(complex, flat, Basis::Bezier), HasSubstr("no volume"));
    // Thin is not the same as flat, which depends on angles. This lattice is sheared so that its
    // volume is almost 0.
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
    // Steps of different lengths are not an even division.
    auto uneven = rest;
    for (Point3& position : uneven) position[0] *= position[0];
    EXPECT_THAT(refusalOf(complex, uneven, Basis::Bezier), HasSubstr("evenly divided"));
    const Lattice torus = shapes::torus();
    EXPECT_THROW(TensorLattice(torus.complex, torus.positions, Basis::Bezier), far::TopologyError);
}

TEST(TensorEmbedding, BSplineLatticesNeedThreeCellsPerAxis) {
    const Cells n = {3, 2, 4};
    EXPECT_THAT(refusalOf(grid(n), gridPositions(n), Basis::BSpline), HasSubstr("3 × 2 × 4"));
}

TEST(TensorEmbedding, EmbeddingBelongsToItsLattice) {
    const Cells n = {3, 3, 3}, m = {3, 3, 4};
    const TensorLattice lattice(grid(n), gridPositions(n), Basis::Bezier);
    const TensorLattice other(grid(m), gridPositions(m), Basis::Bezier);
    const auto embedding = embedPoints(lattice, std::vector<Point3>{{1, 1, 1}});
    EXPECT_THROW(buildDeformationTable(other, embedding), Error);
    EXPECT_THROW(embedPoints(lattice, std::vector<Point3>{}, {.tolerance = -1}), Error);
}

// Rest positions from files of floats or of six digits are accepted, and their deviation is
// reported.
TEST(TensorEmbedding, RestPositionsMayBeRounded) {
    const Cells n = {7, 3, 6};
    Skew skew;
    skew.axes /= 7;
    const auto exact = skew(gridPositions(n));
    auto floats = exact, digits = exact;
    for (std::size_t v = 0; v < exact.size(); ++v)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            floats[v][axis] = float(exact[v][axis]);
            // Coordinates are below 10, so six digits have five decimals.
            digits[v][axis] = std::round(exact[v][axis] * 1e5) / 1e5;
        }
    const auto points = skew(randomPoints(n, 1, 100, 16));
    for (const auto& [rest, off] : {std::pair{floats, 1e-6}, {digits, 1e-5}}) {
        const TensorLattice lattice(grid(n), rest, Basis::BSpline);
        const auto embedding = embedPoints(lattice, points);
        EXPECT_EQ(embedding.count(PointStatus::Inside), 100);
        EXPECT_GT(embedding.largestResidual(), 1e-9);
        EXPECT_LT(embedding.largestResidual(), off);
    }
}

// A float of size 1000 is rounded by 3e-5, which exceeds the six-digit tolerance of a lattice of
// size 7.
TEST(TensorEmbedding, RestPositionsMayBeFloatsFarFromTheOrigin) {
    const Cells n = {7, 3, 6};
    Skew skew;
    skew.axes /= 7;
    skew.origin = {1000, -3000, 2000};
    auto rest = skew(gridPositions(n));
    for (Point3& position : rest)
        for (double& x : position) x = float(x);
    const TensorLattice lattice(grid(n), rest, Basis::BSpline);
    const auto embedding = embedPoints(lattice, skew(randomPoints(n, 1.1, 100, 18)));
    EXPECT_EQ(embedding.count(PointStatus::Inside), 100);
    rest[21][1] += 0.01;
    EXPECT_THAT(refusalOf(grid(n), rest, Basis::BSpline), HasSubstr("vertex 21 is 0.0"));
}

// Which points are inside, outside and nearest depends on shape, not on size.
TEST(TensorEmbedding, DoesNotDependOnTheSizeOfTheLattice) {
    const Cells n = {3, 4, 3};
    const auto at = randomPoints(n, -2, 200, 19);
    const auto pose = gridPositions(n);
    for (const Basis basis : {Basis::Bezier, Basis::BSpline})
        for (const double size : {1e-150, 1e-9, 1e150}) {
            Skew skew, scaled;
            scaled.axes *= size;
            scaled.origin *= size;
            const EmbeddingOptions nearest = {.outside = OutsidePolicy::Nearest};
            const TensorLattice here(grid(n), skew(pose), basis);
            const TensorLattice there(grid(n), scaled(pose), basis);
            const auto placed = embedPoints(here, skew(at), nearest);
            const auto placedThere = embedPoints(there, scaled(at), nearest);
            EXPECT_GT(placed.count(PointStatus::Outside), 50);
            for (std::size_t i = 0; i < at.size(); ++i) {
                EXPECT_EQ(placedThere.points[i].status, placed.points[i].status);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    // The rounding of the solve, in cells.
                    EXPECT_NEAR(placedThere.points[i].place->at[axis],
                                placed.points[i].place->at[axis], 1e-12);
            }
        }
}

TEST(TensorEmbedding, DoesNotDependOnTheNumberOfThreads) {
    const Cells n = {4, 4, 4};
    const TensorLattice lattice(grid(n), gridPositions(n), Basis::BSpline);
    const auto points = randomPoints(n, 0, 9000, 17);
    const auto bind = [&](int threads) {
        return withThreads(
            threads, [&] { return tableOf(lattice, points, {.outside = OutsidePolicy::Nearest}); });
    };
    const auto one = bind(1);
    EXPECT_EQ(one, bind(2));
    EXPECT_EQ(one, bind(8));
}

}  // namespace
}  // namespace espalier::embed
