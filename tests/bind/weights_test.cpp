// SPDX-License-Identifier: Apache-2.0
#include <espalier/bind/bind.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/shapes/solids.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

// Tests weights of points and falloffs.
namespace espalier::bind {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::vec;
using enum embed::PointStatus;

/// Returns points in a box.
std::vector<Point3> pointsInBox(std::size_t count, double low, double high, unsigned seed = 3) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> along(low, high);
    std::vector<Point3> points(count);
    for (Point3& p : points) p = {along(random), along(random), along(random)};
    return points;
}

/// A box of regular cells between irregular ones.
Lattice evenCube() {
    return shapes::box({.cells = {4, 4, 4}});
}

Binding boundTo(const Lattice& lattice, const std::vector<Point3>& points, const Target& target,
                const BindOptions& options) {
    const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    return bindPoints({base, lattice.positions}, points, target, options);
}

/// A weight that is 0 in a third of the cube and 1 in another, and its slope.
PointWeight weightAt(const Point3& p) {
    const Vector3d axis = Vector3d(1, 2, -0.5).normalized();
    const double t = (axis.dot(vec(p)) - 0.3) / 0.4;
    if (t <= 0) return {0, {}};
    if (t >= 1) return {};
    return {t * t * (3 - 2 * t), test::toPoint(6 * t * (1 - t) / 0.4 * axis)};
}

PointWeights weightsAt(const std::vector<Point3>& points) {
    PointWeights weights;
    for (const Point3& p : points) {
        weights.values.push_back(weightAt(p).value);
        weights.slopes.push_back(weightAt(p).slope);
    }
    return weights;
}

std::vector<Target> targets() {
    return {Level{1, true}, Level{3}, Limit{}, embed::Basis::Bezier, embed::Basis::BSpline};
}

// The displacement of each point is its weight times the displacement without weights. A point with
// the weight 0 has no row, and a point with the weight 1 has the same row as without weights.
TEST(Weights, MultiplyTheRowsOfEachTarget) {
    for (const Target& target : targets()) {
        const Lattice lattice = evenCube();
        const auto points = pointsInBox(300, -0.2, 1.2);
        BindOptions options{.embedding = {.outside = embed::OutsidePolicy::Nearest},
                            .gradients = true};
        const Binding without = boundTo(lattice, points, target, options);
        options.weights = weightsAt(points);
        const Binding binding = boundTo(lattice, points, target, options);
        binding.checkParts();
        const auto pose = test::bent(lattice);
        const auto full = osd::evaluateBinding(without, pose);
        const auto moved = osd::evaluateBinding(binding, pose);
        std::vector<Point3> byFactors;
        if (binding.factors) {
            const auto atVertices = stencils::applyLevelTable(binding.factors->vertices, pose);
            byFactors = stencils::applyLevelTable(binding.factors->points, atVertices);
        }
        std::array<int, 3> counts = {};
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto row = Index(i);
            const double weight = options.weights.values[i];
            ++counts[weight == 0 ? 0 : weight < 1 ? 1 : 2];
            if (weight == 0) {
                EXPECT_EQ(binding.statuses[i], NotBound);
                EXPECT_EQ(moved[i], points[i]);
                EXPECT_TRUE(binding.table.columns(row).empty());
                continue;
            }
            EXPECT_EQ(binding.statuses[i], without.statuses[i]);
            for (std::size_t c = 0; c < 3; ++c) {
                const double expected = points[i][c] + weight * (full[i][c] - points[i][c]);
                // The rounding of sums of 125 products of weights up to 8 and displacements of 0.6.
                EXPECT_NEAR(moved[i][c], expected, 1e-12);
            }
            if (weight == 1) {
                EXPECT_TRUE(
                    std::ranges::equal(binding.table.weights(row), without.table.weights(row)));
            }
            if (!byFactors.empty()) {
                // W · S times the pose, which is not relative to the rest.
                const auto rows = stencils::selectRows<double>(binding.table, std::span(&row, 1));
                const Point3 byTable = stencils::applyLevelTable(rows, pose)[0];
                for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(byFactors[i][c], byTable[c], 1e-12);
            }
        }
        for (const int count : counts) EXPECT_GE(count, 30);
    }
}

// F is the derivative of the deformation with its weights, by central differences, also by the
// tables for solvers.
TEST(Weights, GradientsAreTheDerivativeOfTheDeformation) {
    constexpr double kStep = 1e-6;
    std::vector<std::pair<Lattice, Target>> cases;
    for (const Target& target : targets()) cases.emplace_back(evenCube(), target);
    cases.emplace_back(shapes::cylinder({.sectors = 5}), Level{2});
    cases.emplace_back(shapes::cylinder({.sectors = 5}), Limit{});
    for (const auto& [lattice, target] : cases) {
        std::vector<Point3> points;
        for (const Point3& centre : pointsInBox(40, 0.27, 0.73))
            for (int k = 0; k < 7; ++k) {
                points.push_back(centre);
                if (k > 0) points.back()[std::size_t(k - 1) / 2] += k % 2 == 0 ? kStep : -kStep;
            }
        const Binding binding =
            boundTo(lattice, points, target, {.gradients = true, .weights = weightsAt(points)});
        const auto pose = test::bent(lattice);
        const auto moved = osd::evaluateBinding(binding, pose);
        const auto gradients = osd::evaluateGradients(binding, pose);
        const auto tables = gradientTables(binding);
        std::vector<Point3> displacements = pose;
        for (std::size_t v = 0; v < pose.size(); ++v)
            for (std::size_t c = 0; c < 3; ++c) displacements[v][c] -= lattice.positions[v][c];
        int between = 0;
        for (std::size_t i = 0; i < points.size(); i += 7) {
            const double weight = weightAt(points[i]).value;
            between += weight > 0 && weight < 1;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto column = stencils::applyLevelTable(tables[axis], displacements)[i];
                for (std::size_t c = 0; c < 3; ++c) {
                    const std::size_t k = i + 1 + 2 * axis;
                    const double difference = (moved[k + 1][c] - moved[k][c]) / (2 * kStep);
                    // The rounding of the points, 1e-15, divided by the step; and the step squared
                    // times third derivatives of some 100, beside 1e-8 where cells of a level meet.
                    EXPECT_NEAR(gradients[i][3 * c + axis], difference, 1e-7);
                    EXPECT_NEAR(gradients[i][3 * c + axis], (c == axis) + column[c], 1e-12);
                }
            }
        }
        EXPECT_GE(between, 10);
    }
}

// In the distance r of the radius R outside, a point follows with 1 − r² (3 − 2r). Under an affine
// pose a carried point would move by the pose; so the place and F are known.
TEST(Falloff, FadesOutWithTheDistance) {
    constexpr double kRadius = 0.4;
    Matrix3d map;
    map << 1.2, 0.3, -0.1, 0.2, 0.8, 0.4, -0.3, 0.1, 1.1;
    const Vector3d shift(0.3, -0.7, 0.2);
    std::vector<Target> all = targets();
    all.erase(all.begin() + 4);  // The region of B-splines is smaller than the box.
    // Few points are bound to the parts around them, and many to the whole level.
    for (const std::size_t count : {200, 2000})
        for (const Target& target : all) {
            const Lattice lattice = evenCube();
            auto points = pointsInBox(count, -0.6, 1.6);
            points.push_back({1000, 0, 0});  // too far away for a place
            const Binding binding =
                boundTo(lattice, points, target, {.gradients = true, .falloff = kRadius});
            auto pose = lattice.positions;
            for (Point3& p : pose) p = test::toPoint(map * vec(p) + shift);
            const auto moved = osd::evaluateBinding(binding, pose);
            const auto gradients = osd::evaluateGradients(binding, pose);
            std::array<int, 3> counts = {};
            for (std::size_t i = 0; i < points.size(); ++i) {
                const Vector3d point = vec(points[i]);
                const Vector3d away = point - point.cwiseMax(0).cwiseMin(1);
                const double r = away.norm() / kRadius;
                const double weight = r < 1 ? 1 - r * r * (3 - 2 * r) : 0;
                ++counts[r == 0 ? 0 : r < 1 ? 1 : 2];
                EXPECT_EQ(binding.statuses[i], r == 0 ? Inside : r < 1 ? Outside : NotBound);
                const Vector3d displacement = map * point + shift - point;
                Vector3d slope = Vector3d::Zero();
                if (r > 0 && r < 1) slope = -6 * r * (1 - r) / kRadius * away.normalized();
                const Matrix3d expected = Matrix3d::Identity() +
                                          weight * (map - Matrix3d::Identity()) +
                                          displacement * slope.transpose();
                if (r >= 1) {
                    EXPECT_EQ(moved[i], points[i]);
                }
                // The boundary of a box is flat at every level, so distances are exact but for the
                // tolerance of places, 1e-12 of the lattice.
                EXPECT_LT((vec(moved[i]) - point - weight * displacement).norm(), 1e-11);
                EXPECT_LT((Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
                               gradients[i].data()) -
                           expected)
                              .norm(),
                          1e-10);
            }
            for (const int each : counts) EXPECT_GE(each, 10);
        }
}

// A falloff and weights are multiplied. Both ends of the falloff are smooth: displacements and
// gradients have no jump there.
TEST(Falloff, MeetsTheLatticeAndTheRestSmoothly) {
    constexpr double kRadius = 0.5, kStep = 1e-7;
    for (const Target& target : {Target(Level{2}), Target(Limit{}), Target(embed::Basis::Bezier)}) {
        const Lattice lattice = evenCube();
        std::vector<Point3> points;
        for (const double x : {1.0, 1 + kRadius})
            for (const double step : {-kStep, kStep}) points.push_back({x + step, 0.4, 0.6});
        BindOptions options{.gradients = true, .falloff = kRadius};
        const auto pose = test::bent(lattice);
        const Binding binding = boundTo(lattice, points, target, options);
        const auto moved = osd::evaluateBinding(binding, pose);
        const auto gradients = osd::evaluateGradients(binding, pose);
        for (const std::size_t i : {0, 2}) {
            // Displacements are below 1, and their derivatives below 10.
            EXPECT_LT((vec(moved[i]) - vec(moved[i + 1])).norm(), 10 * kStep);
            for (std::size_t k = 0; k < 9; ++k)
                EXPECT_NEAR(gradients[i][k], gradients[i + 1][k], 100 * kStep);
        }
        options.weights.values = std::vector<double>(points.size(), 0.25);
        const auto quarter = osd::evaluateBinding(boundTo(lattice, points, target, options), pose);
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_LT(
                (vec(quarter[i]) - vec(points[i]) - (vec(moved[i]) - vec(points[i])) / 4).norm(),
                1e-15);
    }
}

TEST(Weights, OfABindingNeedItsGradients) {
    const std::vector<Point3> points = pointsInBox(10, 0.1, 0.9);
    Binding binding = boundTo(evenCube(), points, Level{2},
                              {.gradients = true, .weights = {std::vector<double>(10, 0.5), {}}});
    binding.checkParts();
    binding.gradients.reset();
    EXPECT_REFUSED(Error, "weights of gradients, and no gradients", binding.checkParts());
}

TEST(Weights, DoNotDependOnThreads) {
    const Lattice lattice = shapes::cylinder({.sectors = 5});
    const auto points = pointsInBox(500, -1, 1);
    const auto bind = [&] {
        return boundTo(lattice, points, Level{2},
                       {.gradients = true, .weights = weightsAt(points), .falloff = 0.3});
    };
    EXPECT_TRUE(test::withThreads(5, bind) == test::withThreads(1, bind));
}

// A point that does not follow need not be in the lattice.
TEST(Weights, OfZeroAllowPointsOutside) {
    const Lattice lattice = evenCube();
    const std::vector<Point3> points = {{5, 5, 5}, {0.5, 0.5, 0.5}, {0.5, 0.5, 3}};
    BindOptions options{.embedding = {.outside = embed::OutsidePolicy::Error}};
    options.weights.values = {0, 1, 0};
    const Binding binding = boundTo(lattice, points, Level{2}, options);
    EXPECT_EQ(binding.statuses, (std::vector{NotBound, Inside, NotBound}));
    options.weights.values = {0, 1, 0.5};
    EXPECT_REFUSED(Error, "point 2 at (0.5, 0.5, 3) is outside the lattice",
                   boundTo(lattice, points, Level{2}, options));
    for (const Target& target : targets())
        for (const bool gradients : {false, true}) {
            const Binding none = boundTo(lattice, points, target,
                                         {.gradients = gradients, .weights = {{0, 0, 0}, {}}});
            none.checkParts();
            EXPECT_EQ(none.statuses, std::vector(3, NotBound));
            EXPECT_EQ(osd::evaluateBinding(none, test::bent(lattice)), points);
        }
}

TEST(Weights, ThatAreWrongAreRefused) {
    const Lattice lattice = evenCube();
    const std::vector<Point3> points = pointsInBox(3, 0, 1);
    const auto refuse = [&](const std::string& message, const BindOptions& options) {
        EXPECT_REFUSED(Error, message, boundTo(lattice, points, Level{2}, options));
    };
    refuse("got 2 weights for 3 points", {.weights = {{1, 1}, {}}});
    refuse("got 1 slopes of weights for 3 points", {.weights = {{}, {{0, 0, 0}}}});
    refuse("the weight of point 1 is 1.5; expected 0 to 1", {.weights = {{1, 1.5, 1}, {}}});
    refuse("the weight of point 2 is -0.5; expected 0 to 1", {.weights = {{1, 1, -0.5}, {}}});
    refuse("the weight of point 0 is nan; expected 0 to 1", {.weights = {{kNan, 1, 1}, {}}});
    refuse("the slope of the weight of point 1 is not finite",
           {.weights = {{}, {{0, 0, 0}, {0, kInfinity, 0}, {0, 0, 0}}}});
    refuse("falloff: expected a finite distance of 0 or more, got -1", {.falloff = -1});
    refuse("falloff: expected a finite distance of 0 or more, got nan", {.falloff = kNan});
    refuse("leave out one of the two",
           {.embedding = {.outside = embed::OutsidePolicy::Error}, .falloff = 1});
}

// On a flat surface a linear weight has its slope at each point, whatever the faces are. On a
// sphere the slope is the part along the surface.
TEST(Slopes, AreTheOnesOfLinearWeights) {
    const Vector3d slope(0.3, -0.7, 0.2);
    const auto weightsOf = [&](const std::vector<Point3>& points) {
        std::vector<double> weights;
        for (const Point3& p : points) weights.push_back(slope.dot(vec(p)));
        return weights;
    };
    // A tilted plane with a triangle, a quadrilateral, a pentagon, and a point in no face.
    std::vector<Point3> points;
    for (const auto& [x, y] : {std::pair(0, 0), {2, 0}, {3, 2}, {1, 3}, {-1, 1}, {4, -1}, {5, 1}})
        points.push_back({double(x), double(y), 0.5 * x - 0.25 * y});
    points.push_back({9, 9, 9});
    const Vector3d normal = Vector3d(-0.5, 0.25, 1).normalized();
    const Vector3d along = slope - slope.dot(normal) * normal;
    const std::vector<Index> corners = {0, 1, 2, 3, 4, 1, 5, 6, 2, 5, 6, 1};
    const std::vector<std::size_t> ends = {5, 9, 12};
    const auto slopes = slopesOnSurface(points, corners, ends, weightsOf(points));
    for (std::size_t i = 0; i < 7; ++i)
        EXPECT_LT((vec(slopes[i]) - along).norm(), 1e-15) << i;  // The rounding of the sums.
    EXPECT_EQ(slopes[7], (Point3{}));

    // An icosahedron, whose vertices are symmetric: the mean over five triangles is along the
    // tangent plane.
    const double phi = std::numbers::phi;
    points.clear();
    for (const double a : {-1.0, 1.0})
        for (const double b : {-phi, phi}) {
            points.push_back({0, a, b});
            points.push_back({a, b, 0});
            points.push_back({b, 0, a});
        }
    std::vector<Index> triangles;
    std::vector<std::size_t> triangleEnds;
    for (Index a = 0; a < 12; ++a)
        for (Index b = a + 1; b < 12; ++b)
            for (Index c = b + 1; c < 12; ++c) {
                const auto isEdge = [&](Index p, Index q) {
                    return (vec(points[p]) - vec(points[q])).norm() < 2.1;
                };
                if (!isEdge(a, b) || !isEdge(b, c) || !isEdge(a, c)) continue;
                triangles.insert(triangles.end(), {a, b, c});
                triangleEnds.push_back(triangles.size());
            }
    ASSERT_EQ(triangleEnds.size(), 20U);
    const auto onSphere = slopesOnSurface(points, triangles, triangleEnds, weightsOf(points));
    for (std::size_t i = 0; i < points.size(); ++i) {
        // The five edges are symmetric about the normal: their parts along it are equal, and their
        // parts in the plane sum to 0, so that the slope across the plane has no effect.
        const Vector3d n = vec(points[i]).normalized();
        const Vector3d expected = slope - slope.dot(n) * n;
        EXPECT_LT((vec(onSphere[i]) - expected).norm(), 1e-14) << i;  // The rounding of the sums.
    }
}

// A point that is doubled, as at a seam, has the slope of the whole surface. A point beside an
// edge, whose weight is off by the step of a byte, changes no slope by more than the step makes of
// the other edges.
TEST(Slopes, AreEqualOnBothSidesOfASeamAndBoundedAtSlivers) {
    // Three columns of two squares; the middle points are doubled in `split`.
    std::vector<Point3> points;
    std::vector<double> weights;
    for (const double x : {0.0, 1.0, 2.0})
        for (const double y : {0.0, 1.0}) {
            points.push_back({x, y, 0});
            weights.push_back(x * x / 4);
        }
    const std::vector<std::size_t> ends = {4, 8};
    const auto welded =
        slopesOnSurface(points, std::vector<Index>{0, 2, 3, 1, 2, 4, 5, 3}, ends, weights);
    EXPECT_LT((vec(welded[2]) - Vector3d(0.5, 0, 0)).norm(), 1e-15);  // The rounding of sums.
    for (const std::size_t i : {2, 3}) {
        points.push_back(points[i]);
        weights.push_back(weights[i]);
    }
    const auto split =
        slopesOnSurface(points, std::vector<Index>{0, 2, 3, 1, 6, 4, 5, 7}, ends, weights);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(split[i], welded[i]) << i;
    EXPECT_EQ(split[6], welded[2]);

    const double near = 1e-9;
    const std::vector<Point3> sliver = {{0, 0, 0}, {2, 0, 0}, {1, near, 0}, {1, 1, 0}};
    const auto slopes = slopesOnSurface(sliver, std::vector<Index>{0, 1, 2, 0, 2, 3, 2, 1, 3},
                                        std::vector<std::size_t>{3, 6, 9},
                                        std::vector<double>{0.5, 0.5, 0.504, 0.5});
    for (const Point3& each : slopes) EXPECT_LT(vec(each).norm(), 0.01);
}

TEST(Slopes, RefuseFacesAndWeightsThatDoNotFit) {
    const std::vector<Point3> points(3);
    const std::vector<Index> corners = {0, 1, 3};
    const std::vector<std::size_t> ends = {3};
    EXPECT_REFUSED(Error, "a face has the point 3; there are 3 points",
                   slopesOnSurface(points, corners, ends, std::vector<double>(3)));
    EXPECT_REFUSED(Error, "got 2 weights for 3 points",
                   slopesOnSurface(points, {}, {}, std::vector<double>(2)));
    EXPECT_REFUSED(Error, "the weight of point 1 is not finite",
                   slopesOnSurface(points, {}, {}, std::vector<double>{0, kNan, 0}));
    EXPECT_REFUSED(Error, "got 1 shapes for 3 points",
                   slopesOnSurface(points, {}, {}, std::vector<double>(3), std::vector<Index>{0}));
}

}  // namespace
}  // namespace espalier::bind
