// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/embed/local_binding.h>
#include <espalier/shapes/inventory.h>
#include <espalier/solve/lattice_fit.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/refined_lattice.h"
#include "support/zoo.h"

namespace espalier::solve {
namespace {

using stencils::Rules;
using stencils::StencilTable;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Property;
using ::testing::Throws;
using ::testing::ThrowsMessage;

/// Points bound to a lattice at level 2.
struct Model {
    Lattice lattice;
    StencilTable<double> deformation;

    Model(const Lattice& chosen, std::size_t pointCount) : lattice(chosen) {
        const test::Refined refined(lattice, 2);
        deformation = embed::bindPoints({far::TopologyRefiner(lattice.complex), lattice.positions},
                                        test::pointsIn(refined, pointCount, 5), {.level = 2})
                          .binding.table;
    }

    std::vector<Point3> moved(const std::vector<Point3>& displacements) const {
        std::vector<Point3> result(deformation.rowCount(), Point3{});
        for (Index row = 0; row < deformation.rowCount(); ++row)
            for (std::size_t k = 0; k < deformation.columns(row).size(); ++k)
                for (std::size_t c = 0; c < 3; ++c)
                    result[row][c] +=
                        deformation.weights(row)[k] * displacements[deformation.columns(row)[k]][c];
        return result;
    }
    LatticeFit fit(const std::vector<Point3>& misses, const FitOptions& options = {}) const {
        return fitLattice(deformation, misses, lattice.complex, options);
    }
    std::vector<Point3> randomDisplacements() const {
        const auto values = test::randomValues(3 * lattice.positions.size(), 7);
        std::vector<Point3> result;
        for (std::size_t i = 0; i < values.size(); i += 3)
            result.push_back({values[i], values[i + 1], values[i + 2]});
        return result;
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

// What the project promises: the inverse of deform, within 1e-10.
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

// One point pulled: of all displacements that bring it there, those along the gradient of its
// position are the smallest, d = w · m / |w|².
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
    // Rounding of 1e-16 in open directions, over the part of 1e-10 below which they count as open,
    // twice, and times rounding again.
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

// Targets that contradict each other: the residual is orthogonal to all that the lattice can do.
TEST(LatticeFit, ContradictionsAreSharedByLeastSquares) {
    const Model model(shapes::box(), 40);
    const auto random = test::randomValues(120, 9);
    std::vector<Point3> misses;
    for (std::size_t i = 0; i < 120; i += 3)
        misses.push_back({random[i], random[i + 1], random[i + 2]});
    const LatticeFit fit = model.fit(misses);
    auto left = model.moved(fit.displacements);
    for (std::size_t i = 0; i < left.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) left[i][c] -= misses[i][c];
    EXPECT_NEAR(fit.meanMiss, std::sqrt(squareSum(left) / 40), 1e-14);
    std::vector<Point3> gradient(model.lattice.positions.size(), Point3{});
    for (Index row = 0; row < 40; ++row)
        for (std::size_t k = 0; k < model.deformation.columns(row).size(); ++k)
            for (std::size_t c = 0; c < 3; ++c)
                gradient[model.deformation.columns(row)[k]][c] +=
                    model.deformation.weights(row)[k] * left[row][c];
    EXPECT_LT(std::sqrt(squareSum(gradient)), 1e-12);
}

// The more smoothing, the smaller the displacements and the larger the misses.
TEST(LatticeFit, TikhonovMakesThemSmaller) {
    const Model model(shapes::box({.cells = {2, 2, 2}}), 200);
    const auto misses = model.moved(model.randomDisplacements());
    double size = std::numeric_limits<double>::infinity(), miss = -1;
    for (const double strength : {1e-3, 1e-1, 1.0, 10.0}) {
        const LatticeFit fit =
            model.fit(misses, {.smoothing = Smoothing::Tikhonov, .strength = strength});
        EXPECT_TRUE(std::isfinite(fit.condition));
        EXPECT_LT(squareSum(fit.displacements), size);
        EXPECT_GT(fit.meanMiss, miss);
        size = squareSum(fit.displacements);
        miss = fit.meanMiss;
    }
}

// At both ends of what strengths may be, a lattice that is moved as a whole goes along.
TEST(LatticeFit, HoldsTheTargetsAtEveryStrength) {
    const Model model(shapes::box(), 20);
    const std::vector<Point3> misses(20, Point3{0.1, 0.2, 0});
    for (const double strength : {1e-4, 1.0, 1e4}) {
        const LatticeFit fit =
            model.fit(misses, {.smoothing = Smoothing::Laplacian, .strength = strength});
        EXPECT_LT(fit.largestMiss, 1e-9) << strength;
    }
}

// Few points of a lattice that is moved as a whole: the Laplacian of that is 0, so all of it goes
// along, as neither the smallest displacements do nor Tikhonov's.
TEST(LatticeFit, LaplacianCarriesTheRestAlong) {
    const Model model(shapes::box({.cells = {4, 4, 4}}), 5);
    const Point3 miss = {1, 2, -3};
    const std::vector<Point3> misses(5, miss);
    const LatticeFit fit = model.fit(misses, {.smoothing = Smoothing::Laplacian});
    const std::vector<Point3> expected(model.lattice.positions.size(), miss);
    EXPECT_LT(largestDifference(fit.displacements, expected), 1e-9);
    EXPECT_GT(largestDifference(model.fit(misses).displacements, expected), 1);
}

TEST(LatticeFit, RefusesWhatIsNotDetermined) {
    const Model model(shapes::box({.cells = {3, 3, 3}}), 1);
    EXPECT_THAT(
        [&] {
            model.fit({{1, 0, 0}}, {.undetermined = Undetermined::Refuse});
        },
        ThrowsMessage<Error>(HasSubstr("the targets leave vertex ")));
}

TEST(LatticeFit, RefusesBadInputByName) {
    const Model model(shapes::box(), 3);
    const std::vector<Point3> misses(3, Point3{0.1, 0, 0});
    const auto expectRefused = [](const auto& call, const char* why) {
        EXPECT_THAT(call, ThrowsMessage<Error>(HasSubstr(why)));
    };
    expectRefused([&] { model.fit({{0, 0, 0}}); }, "got 1 targets for 3 points");
    expectRefused(
        [&] { fitLattice(StencilTable<double>(8, {0}, {}, {}), {}, model.lattice.complex); },
        "there are no targets");
    expectRefused(
        [&] {
            fitLattice(StencilTable<double>(8, {0, 0}, {}, {}), std::vector<Point3>(1),
                       model.lattice.complex);
        },
        "point 0 has a target, but lies outside the lattice");
    expectRefused([&] { fitLattice(model.deformation, misses, shapes::octahedron().complex); },
                  "the points are bound to 8 vertices; the lattice has 6");
    auto bad = misses;
    bad[1][2] = std::numeric_limits<double>::quiet_NaN();
    expectRefused([&] { model.fit(bad); }, "the target of point 1 is not finite");
    expectRefused([&] { model.fit(misses, {.frozen = {8}}); }, "vertex 8 cannot be frozen");
    expectRefused(
        [&] {
            model.fit(misses, {.frozen = {0, 1, 2, 3, 4, 5, 6, 7}});
        },
        "all vertices are frozen");
    EXPECT_THAT([&] { model.fit(bad); }, Throws<TargetError>(Property(&TargetError::row, 1)));
    EXPECT_THAT(
        [&] {
            model.fit({{1e200, 0, 0}, {0, 0, 0}, {0, 1.1e200, 0}});
        },
        AllOf(Throws<TargetError>(Property(&TargetError::row, 2)),
              ThrowsMessage<TargetError>(
                  HasSubstr("the target of point 2 is too far from the point"))));
    const StencilTable<double> broken(8, {0, 1}, {0}, {std::numeric_limits<double>::infinity()});
    expectRefused([&] { fitLattice(broken, std::vector<Point3>(1), model.lattice.complex); },
                  "point 0 has a weight that is not finite");
    for (const double strength : {0.0, -1.0, 1e-5, 1e5, std::numeric_limits<double>::quiet_NaN()})
        expectRefused([&] { model.fit(misses, {.strength = strength}); }, "a strength of");
}

}  // namespace
}  // namespace espalier::solve
