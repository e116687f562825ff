// SPDX-License-Identifier: Apache-2.0
#include <espalier/bind/bind.h>
#include <espalier/embed/tensor_product.h>
#include <espalier/far/topology_match.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/shapes/around.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <atomic>
#include <random>

#include "support/test.h"
#include "support/zoo.h"

namespace espalier::bind {
namespace {

/// Points in and around the unit cube; the last one is far outside.
std::vector<Point3> pointsAround(int count) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-0.2, 1.2);
    std::vector<Point3> points;
    for (int i = 1; i < count; ++i) points.push_back({place(random), place(random), place(random)});
    points.push_back({9, 9, 9});
    return points;
}

Lattice box() {
    return shapes::box({.cells = {4, 4, 4}});
}

Binding bindTo(const Lattice& lattice, const std::vector<Point3>& points, const Target& target,
               const BindOptions& options = {}) {
    const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    return bindPoints({base, lattice.positions}, points, target, options);
}

void expectSame(const Binding& binding, const embed::BoundRows<>& expected) {
    EXPECT_EQ(binding.table, expected.table);
    EXPECT_EQ(binding.statuses, expected.statuses);
    EXPECT_EQ(binding.largestResidual, expected.largestResidual);
}

// Each target against the function that does its work, called as a reader of its header would.
TEST(Binding, IsTheResultOfItsTarget) {
    const Lattice lattice = box();
    const std::vector<Point3> points = pointsAround(200);
    const TopologyRefiner base(lattice.complex);
    const embed::RestLattice rest{base, lattice.positions};
    const embed::EmbeddingOptions nearest{.outside = embed::OutsidePolicy::Nearest};
    for (const embed::EmbeddingOptions& options : {embed::EmbeddingOptions(), nearest}) {
        expectSame(bindTo(lattice, points, Level{2}, {options}),
                   embed::bindPoints(rest, points, {.level = 2, .embedding = options}));
        expectSame(bindTo(lattice, points, Limit{1e-7}, {options}),
                   limit::bindLimit(rest, points, {.embedding = options, .tolerance = 1e-7}));
        for (const embed::Basis basis : {embed::Basis::Bezier, embed::Basis::BSpline})
            expectSame(
                bindTo(lattice, points, basis, {options}),
                embed::bindPoints(embed::TensorLattice(lattice.complex, lattice.positions, basis),
                                  points, {.embedding = options}));
    }
}

TEST(Binding, KnowsTheRestAndTheHash) {
    const Lattice lattice = box();
    const std::vector<Point3> points = pointsAround(50);
    const auto targets = {Target(Level{2}), Target(Limit{}), Target(embed::Basis::Bezier)};
    for (const Target& target : targets) {
        const Binding binding = bindTo(lattice, points, target);
        EXPECT_EQ(binding.points, points);
        EXPECT_EQ(binding.rest, lattice.positions);
        EXPECT_EQ(binding.topologyHash, far::topologyHash(lattice.complex));
        using enum embed::PointStatus;
        EXPECT_EQ(binding.count(Inside) + binding.count(Outside) + binding.count(NotConverged), 50);
        EXPECT_GT(binding.count(Inside), 0);
        EXPECT_GT(binding.count(Outside), 0);
        EXPECT_FALSE(binding.gradients);
        // At rest, x + D · (p − p) is x, bit for bit, also where D is rounded.
        EXPECT_EQ(osd::evaluateBinding(binding, lattice.positions), points);
        // D · p gives x back, too. 1e-12: the placement of points is exact to their rounding times
        // the weights of a row.
        const auto product = stencils::applyLevelTable(binding.table, lattice.positions);
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t axis = 0; axis < 3 && !binding.table.columns(Index(i)).empty(); ++axis)
                EXPECT_NEAR(product[i][axis], points[i][axis], 1e-12);
    }
}

TEST(Binding, HasTheFactorsOfALevelOnRequest) {
    const Lattice lattice = box();
    const std::vector<Point3> points = pointsAround(50);
    EXPECT_FALSE(bindTo(lattice, points, Level{2}).factors);
    const Binding binding = bindTo(lattice, points, Level{.level = 2, .factors = true});
    ASSERT_TRUE(binding.factors);
    const auto product = stencils::multiply(binding.factors->points, binding.factors->vertices);
    // The same rows up to rounding; rows of the product may have further entries of about 0.
    auto pose = lattice.positions;
    for (Point3& p : pose) p = {p[1] * p[2], p[0] * p[0], p[2]};
    const auto moved = stencils::applyLevelTable(product, pose),
               expected = stencils::applyLevelTable(binding.table, pose);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(moved[i][axis], expected[i][axis], 1e-13);
}

// around() promises that binding finds all points inside, also a model whose size is near the
// rounding of its coordinates, for which it widens the margin.
TEST(Binding, FindsAllPointsInABoxAround) {
    static_assert(shapes::kAroundTolerance == embed::EmbeddingOptions().tolerance);
    for (const double away : {0.0, 1e7, 1e9}) {
        std::vector<Point3> points;
        for (int i = 0; i < 200; ++i)
            points.push_back({away + 0.1 * i, away + 0.3 * (i * i % 11), away + 0.3 * (i % 7)});
        shapes::AroundFacts facts{-1};
        const Lattice lattice = shapes::around(points, {.margin = 0, .oriented = true}, &facts);
        EXPECT_GE(facts.margin, 0);
        for (const Target& target : {Target(Level{2}), Target(Limit{})})
            EXPECT_EQ(bindTo(lattice, points, target).count(embed::PointStatus::Inside), 200)
                << away;
    }
}

TEST(Binding, RefusesMarksUnderABasis) {
    Lattice lattice = box();
    lattice.marks.vertices.push_back({0});
    EXPECT_REFUSED(Error, "which only subdivision applies",
                   bindTo(lattice, pointsAround(3), embed::Basis::BSpline));
    EXPECT_NO_THROW(bindTo(lattice, pointsAround(3), Level{1}));
}

TEST(Binding, ReportsProgressForEachTarget) {
    const auto targets = {Target(Level{2}), Target(Limit{}), Target(embed::Basis::BSpline)};
    for (const Target& target : targets) {
        std::atomic<Offset> most = 0;
        bindTo(box(), pointsAround(300), target, {.progress = [&](Offset done) {
                   Offset old = most;
                   while (old < done && !most.compare_exchange_weak(old, done)) {
                   }
               }});
        EXPECT_EQ(most, 300);
    }
}

}  // namespace
}  // namespace espalier::bind
