// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/shapes/inventory.h>
#include <espalier/solve/lattice_fit.h>
#include <espalier/stencils/composition.h>

#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::solve {
namespace {

using ::testing::Property;

/// Points bound to a lattice on level 2.
struct Model {
    Lattice lattice;
    StencilTable<double> deformation;

    Model(const Lattice& chosen, std::size_t pointCount) : lattice(chosen) {
        const Refined refined(lattice, 2);
        deformation = embed::bindPoints({TopologyRefiner(lattice.complex), lattice.positions},
                                        pointsIn(refined, pointCount, 5), {.level = 2})
                          .table;
    }

    std::vector<Point3> moved(const std::vector<Point3>& displacements) const {
        return stencils::applyLevelTable(deformation, displacements);
    }
    LatticeFit fit(const std::vector<Point3>& misses, const FitOptions& options = {}) const {
        return fitLattice(deformation, misses, lattice.complex, options);
    }
    std::vector<Point3> randomDisplacements() const {
        return randomPoints(lattice.positions.size(), 7);
    }
};

double largestDifference(const std::vector<Point3>& a, const std::vector<Point3>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            largest = std::max(largest, std::abs(a[i][c] - b[i][c]));
    return largest;
}

double squareSum(const std::vector<Point3>& points) {
    double sum = 0;
    for (const Point3& p : points) sum += p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    return sum;
}

// The project promises the inverse of a deformation within 1e-10.
TEST(LatticeFit, RecoversAKnownPoseFromAWholeModel) {
    for (const Lattice& lattice : {shapes::box({.cells = {2, 2, 2}}),
                                   shapes::cylinder({.sectors = 5}), shapes::octahedron()}) {
        const Model model(lattice, 3000);
        const auto pose = model.randomDisplacements();
        const LatticeFit fit = model.fit(model.moved(pose), {.undetermined = Undetermined::Refuse});
        EXPECT_LT(largestDifference(fit.displacements, pose), 1e-10);
        EXPECT_LT(fit.largestMiss, 1e-12);
        EXPECT_GT(fit.condition, 1);
        EXPECT_LT(fit.condition, 1e4);
    }
}

// One target: of all displacements that move the point there, d = w · m / |w|², along the gradient
// of the point's position, is the smallest.
TEST(LatticeFit, OneTargetIsReachedByTheSmallestDisplacement) {
    const Model model(shapes::box({.cells = {3, 3, 3}}), 1);
    const Point3 miss = {0.1, -0.2, 0.3};
    const LatticeFit fit = model.fit({miss});
    EXPECT_LT(fit.largestMiss, 1e-12);
    EXPECT_TRUE(std::isinf(fit.condition));
    double square = 0;
    for (const double weight : model.deformation.weights(0)) square += weight * weight;
    std::vector<Point3> expected(model.lattice.positions.size(), Point3{});
    for (std::size_t k = 0; k < model.deformation.columns(0).size(); ++k)
        for (std::size_t c = 0; c < 3; ++c)
            expected[model.deformation.columns(0)[k]][c] =
                model.deformation.weights(0)[k] * miss[c] / square;
    // Rounding of 1e-16 in undetermined directions, divided twice by the threshold 1e-10 of these
    // directions, and multiplied by rounding again.
    EXPECT_LT(largestDifference(fit.displacements, expected), 1e-11);
}

TEST(LatticeFit, FrozenVerticesStay) {
    const Model model(shapes::box({.cells = {2, 2, 2}}), 3000);
    auto pose = model.randomDisplacements();
    const std::vector<Index> frozen = {0, 5, 13};
    for (const Index vertex : frozen) pose[vertex] = {};
    const LatticeFit fit = model.fit(model.moved(pose), {.frozen = frozen});
    for (const Index vertex : frozen) EXPECT_EQ(fit.displacements[vertex], (Point3{0, 0, 0}));
    EXPECT_LT(largestDifference(fit.displacements, pose), 1e-10);
}

// If targets contradict each other, the residual is orthogonal to all that the lattice can do.
TEST(LatticeFit, ContradictoryTargetsAreFittedByLeastSquares) {
    const Model model(shapes::box(), 40);
    const auto misses = randomPoints(40, 9);
    const LatticeFit fit = model.fit(misses);
    auto left = model.moved(fit.displacements);
    for (std::size_t i = 0; i < left.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) left[i][c] -= misses[i][c];
    EXPECT_NEAR(fit.rmsMiss, std::sqrt(squareSum(left) / 40), 1e-14);
    std::vector<Point3> gradient(model.lattice.positions.size(), Point3{});
    for (Index row = 0; row < 40; ++row)
        for (std::size_t k = 0; k < model.deformation.columns(row).size(); ++k)
            for (std::size_t c = 0; c < 3; ++c)
                gradient[model.deformation.columns(row)[k]][c] +=
                    model.deformation.weights(row)[k] * left[row][c];
    EXPECT_LT(std::sqrt(squareSum(gradient)), 1e-12);
}

// More smoothing makes the displacements smaller and the misses larger.
TEST(LatticeFit, TikhonovMakesDisplacementsSmaller) {
    const Model model(shapes::box({.cells = {2, 2, 2}}), 200);
    const auto misses = model.moved(model.randomDisplacements());
    double size = kInfinity, miss = -1;
    for (const double strength : {1e-3, 1e-1, 1.0, 10.0}) {
        const LatticeFit fit =
            model.fit(misses, {.smoothing = Smoothing::Tikhonov, .strength = strength});
        EXPECT_TRUE(std::isfinite(fit.condition));
        EXPECT_LT(squareSum(fit.displacements), size);
        EXPECT_GT(fit.rmsMiss, miss);
        size = squareSum(fit.displacements);
        miss = fit.rmsMiss;
    }
}

// At both ends of the range of strengths, targets that move the whole lattice are met.
TEST(LatticeFit, HoldsTheTargetsAtEveryStrength) {
    const Model model(shapes::box(), 20);
    const std::vector<Point3> misses(20, Point3{0.1, 0.2, 0});
    for (const double strength : {1e-4, 1.0, 1e4}) {
        const LatticeFit fit =
            model.fit(misses, {.smoothing = Smoothing::Laplacian, .strength = strength});
        EXPECT_LT(fit.largestMiss, 1e-9) << strength;
    }
}

// Few points are moved by a translation of the whole lattice. Its Laplacian is 0, so the whole
// lattice moves, which neither the smallest displacements nor Tikhonov's would do.
TEST(LatticeFit, LaplacianMovesTheWholeLattice) {
    const Model model(shapes::box({.cells = {4, 4, 4}}), 5);
    const Point3 miss = {1, 2, -3};
    const std::vector<Point3> misses(5, miss);
    const LatticeFit fit = model.fit(misses, {.smoothing = Smoothing::Laplacian});
    const std::vector<Point3> expected(model.lattice.positions.size(), miss);
    EXPECT_LT(largestDifference(fit.displacements, expected), 1e-9);
    EXPECT_GT(largestDifference(model.fit(misses).displacements, expected), 1);
}

TEST(LatticeFit, RefusesUndeterminedDisplacements) {
    const Model model(shapes::box({.cells = {3, 3, 3}}), 1);
    EXPECT_REFUSED(Error, "the targets leave vertex ",
                   model.fit({{1, 0, 0}}, {.undetermined = Undetermined::Refuse}));
}

TEST(LatticeFit, RefusesBadInputByName) {
    const Model model(shapes::box(), 3);
    const std::vector<Point3> misses(3, Point3{0.1, 0, 0});
    EXPECT_REFUSED(Error, "got 1 targets for 3 points", model.fit({{0, 0, 0}}));
    EXPECT_REFUSED(Error, "there are no targets",
                   fitLattice(StencilTable<double>(8, {0}, {}, {}), {}, model.lattice.complex));
    EXPECT_REFUSED(Error, "point 0 has a target, but lies outside the lattice",
                   fitLattice(StencilTable<double>(8, {0, 0}, {}, {}), std::vector<Point3>(1),
                              model.lattice.complex));
    EXPECT_REFUSED(Error, "the points are bound to 8 vertices; the lattice has 6",
                   fitLattice(model.deformation, misses, shapes::octahedron().complex));
    auto bad = misses;
    bad[1][2] = kNan;
    EXPECT_REFUSED(Error, "the target of point 1 is not finite", model.fit(bad));
    EXPECT_REFUSED(Error, "frozen[0]: expected a vertex, 0 to 7, got 8",
                   model.fit(misses, {.frozen = {8}}));
    EXPECT_REFUSED(Error, "all vertices are frozen",
                   model.fit(misses, {.frozen = {0, 1, 2, 3, 4, 5, 6, 7}}));
    EXPECT_THAT([&] { model.fit(bad); }, Throws<TargetError>(Property(&TargetError::row, 1)));
    EXPECT_THAT(
        [&] {
            model.fit({{1e200, 0, 0}, {0, 0, 0}, {0, 1.1e200, 0}});
        },
        AllOf(Throws<TargetError>(Property(&TargetError::row, 2)),
              ThrowsMessage<TargetError>(
                  HasSubstr("the target of point 2 is too far from the point"))));
    const StencilTable<double> broken(8, {0, 1}, {0}, {kInfinity});
    EXPECT_REFUSED(Error, "point 0 has a weight that is not finite",
                   fitLattice(broken, std::vector<Point3>(1), model.lattice.complex));
    for (const double strength : {0.0, -1.0, 1e-5, 1e5, kNan})
        EXPECT_REFUSED(Error, "strength: expected 0.0001 to 10000, got ",
                       model.fit(misses, {.strength = strength}));
}

}  // namespace
}  // namespace espalier::solve
