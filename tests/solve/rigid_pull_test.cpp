// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/embed/local_binding.h>
#include <espalier/shapes/cell_distances.h>
#include <espalier/shapes/solids.h>
#include <espalier/shapes/transform.h>
#include <espalier/solve/lattice_fit.h>
#include <espalier/solve/rigid_pull.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Dense>

#include "solve/rotation_fit.h"
#include "support/lattices_with_limbs.h"
#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/threads.h"

namespace espalier::solve {
namespace {

using ::testing::Property;

/// A lattice, and points that are bound to its level 2.
struct Handles {
    Lattice lattice;
    std::vector<Point3> points;
    StencilTable<double> deformation;

    Handles(const Lattice& chosen, std::vector<Point3> places)
        : lattice(chosen), points(std::move(places)) {
        if (points.empty())
            deformation = StencilTable<double>(lattice.complex.count(0), {0}, {}, {});
        else
            deformation = embed::bindPoints({TopologyRefiner(lattice.complex), lattice.positions},
                                            points, {.level = 2})
                              .table;
    }
    RigidPull pull(const RigidPullOptions& options = {}) const {
        return RigidPull(lattice.complex, lattice.positions, deformation, options);
    }
    std::vector<Point3> posed(const std::vector<Point3>& displacements) const {
        auto positions = lattice.positions;
        for (std::size_t v = 0; v < positions.size(); ++v)
            positions[v] = sum(positions[v], displacements[v]);
        return positions;
    }
};

double largestDistance(const std::vector<Point3>& a, const std::vector<Point3>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, length(difference(a[i], b[i])));
    return largest;
}

std::vector<Point3> misses(const std::vector<Point3>& points, const shapes::Affine& map) {
    std::vector<Point3> result;
    for (const Point3& point : points) result.push_back(difference(map(point), point));
    return result;
}

const Point3 kLeftHand = {0.3, 1.8, 5.1}, kRightHand = {13.7, 1.8, 5.1};

// The definition in rigid_pull.h: sums over all pairs of vertices of a cell, one dense matrix,
// rotations by singular values, in long double, because the large weight of the pulls costs digits.
std::vector<Point3> slowPull(const Handles& handles, const std::vector<Index>& fixed,
                             const std::vector<Point3>& wanted, int iterations) {
    using Real = long double;
    using Dense = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
    const auto& rest = handles.lattice.positions;
    const auto& verticesOf = handles.lattice.complex.relation(3, 0);
    const auto count = static_cast<Eigen::Index>(rest.size());
    const auto at = [](const std::vector<Point3>& points, Index v) {
        return Eigen::Vector3d(points[v][0], points[v][1], points[v][2]);
    };
    std::vector<double> weights;
    Dense matrix = Dense::Zero(count, count);
    for (Index cell = 0; cell < verticesOf.rowCount(); ++cell) {
        const auto vertices = verticesOf[cell];
        const auto n = static_cast<double>(vertices.size());
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        for (const Index v : vertices) middle += at(rest, v) / n;
        double square = 0;
        for (const Index v : vertices) square += (at(rest, v) - middle).squaredNorm() / n;
        weights.push_back(std::sqrt(square) / n);
        for (const Index a : vertices)
            for (const Index b : vertices)
                if (a < b) {
                    matrix(a, a) += weights.back();
                    matrix(b, b) += weights.back();
                    matrix(a, b) -= weights.back();
                    matrix(b, a) -= weights.back();
                }
    }
    std::vector<char> isFixed(rest.size(), 0);
    for (const Index v : fixed) isFixed[v] = 1;
    Real diagonal = 0;
    for (Eigen::Index v = 0; v < count; ++v)
        if (isFixed[v] == 0) diagonal += matrix(v, v);
    const Real strength = diagonal / Real(rest.size() - fixed.size()) * (1 + 1e8L);
    Dense pulls = Dense::Zero(handles.deformation.rowCount(), count);
    for (Index k = 0; k < handles.deformation.rowCount(); ++k)
        for (std::size_t a = 0; a < handles.deformation.columns(k).size(); ++a)
            pulls(k, handles.deformation.columns(k)[a]) = handles.deformation.weights(k)[a];
    matrix += strength * pulls.transpose() * pulls;
    for (const Index v : fixed) {
        matrix.row(v).setZero();
        matrix.col(v).setZero();
        matrix(v, v) = 1;
    }
    const Eigen::PartialPivLU<Dense> factors(matrix);
    std::vector<Point3> moved(rest.size(), Point3{});
    for (int step = 0; step < iterations; ++step) {
        Dense right = Dense::Zero(count, 3);
        for (Index cell = 0; cell < verticesOf.rowCount(); ++cell) {
            Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
            for (const Index a : verticesOf[cell])
                for (const Index b : verticesOf[cell]) {
                    const Eigen::Vector3d edge = at(rest, a) - at(rest, b);
                    moments += (edge + at(moved, a) - at(moved, b)) * edge.transpose();
                }
            const Eigen::Matrix3d rotation = rotationBySingularValues(moments);
            for (const Index a : verticesOf[cell])
                for (const Index b : verticesOf[cell]) {
                    const Eigen::Vector3d edge = at(rest, a) - at(rest, b);
                    right.row(a) += (weights[cell] * (rotation * edge - edge)).cast<Real>();
                }
        }
        for (std::size_t k = 0; k < wanted.size(); ++k)
            right += strength * pulls.row(static_cast<Eigen::Index>(k)).transpose() *
                     at(wanted, static_cast<Index>(k)).transpose().cast<Real>();
        for (const Index v : fixed) right.row(v).setZero();
        const Dense solution = factors.solve(right);
        for (Eigen::Index v = 0; v < count; ++v)
            for (Eigen::Index c = 0; c < 3; ++c) moved[v][c] = static_cast<double>(solution(v, c));
    }
    return moved;
}

TEST(RigidPull, IsTheSameAsItsDefinition) {
    for (const Lattice& lattice : {shapes::box({.cells = {2, 1, 4}, .max = {1, 0.7, 4}}),
                                   shapes::star(), twoLegs(), shapes::cylinder({.layers = 3})}) {
        const Index last = lattice.complex.count(3) - 1;
        const Handles handles(lattice,
                              {shapes::cellMiddle(lattice.complex, lattice.positions, last),
                               shapes::cellMiddle(lattice.complex, lattice.positions, 0)});
        const std::vector<Point3> wanted = {{0.5, -0.2, -0.4}, {0, 0, 0}};
        for (const int iterations : {1, 2, 10}) {
            const auto pull = handles.pull(
                {.pins = {1}, .tolerance = 0, .maxIterations = iterations, .preventsFolds = false});
            ASSERT_FALSE(pull.fixedVertices().empty());
            const auto pose = pull.solve(wanted);
            EXPECT_EQ(pose.iterations, iterations);
            // Rounding, times the stiffness of cells against bending of a rod.
            EXPECT_LT(largestDistance(pose.displacements,
                                      slowPull(handles, pull.fixedVertices(), wanted, iterations)),
                      1e-11);
        }
    }
}

TEST(RigidPull, RigidMotionsAreReproduced) {
    using shapes::rotation, shapes::translation;
    for (const Lattice& lattice : {figure(), shapes::icosahedron(), shapes::arm()}) {
        std::vector<Point3> places;
        for (Index cell = 0; cell < lattice.complex.count(3);
             cell += std::max(1, lattice.complex.count(3) / 4))
            places.push_back(shapes::cellMiddle(lattice.complex, lattice.positions, cell));
        for (const Point3& vertex : {lattice.positions[0], lattice.positions[7]})
            places.push_back(between(places[0], vertex, 0.5));
        const Handles handles(lattice, places);
        const shapes::Affine map = translation({3, -2, 1}) * rotation({1, 2, -1}, 2.0);
        const auto pose = handles.pull({.reach = 1}).solve(misses(handles.points, map));
        EXPECT_LT(largestDistance(pose.displacements, misses(lattice.positions, map)), 1e-9);
        EXPECT_LT(pose.largestMiss, 1e-9);
        EXPECT_LT(pose.energy, 1e-9);
        // One point carries the lattice along; two turn it by the smallest rotation.
        const Handles one(lattice, {places[0]});
        EXPECT_LT(largestDistance(
                      one.pull({.reach = 1}).solve(std::vector<Point3>{{1, 2, 3}}).displacements,
                      std::vector<Point3>(lattice.positions.size(), {1, 2, 3})),
                  1e-9);
        const Handles two(lattice, {places[0], places.back()});
        const Point3 way = difference(two.points[1], two.points[0]);
        const Point3 turned = {way[1], way[2], way[0]};
        const shapes::Affine smallest = translation(two.points[0]) *
                                        shapes::rotationBetween(way, turned) *
                                        translation(scaled(two.points[0], -1));
        EXPECT_LT(largestDistance(
                      two.pull({.reach = 1}).solve(misses(two.points, smallest)).displacements,
                      misses(lattice.positions, smallest)),
                  1e-9);
        // A frozen vertex is a pivot.
        const Point3 pivot = lattice.positions[3];
        const shapes::Affine about =
            translation(pivot) * rotation({0, 1, 3}, 0.7) * translation(scaled(pivot, -1));
        EXPECT_LT(largestDistance(handles.pull({.frozen = {3}, .reach = 1})
                                      .solve(misses(handles.points, about))
                                      .displacements,
                                  misses(lattice.positions, about)),
                  1e-9);
    }
}

TEST(RigidPull, WithoutPullsNothingMoves) {
    const std::vector<Point3> still(figure().positions.size(), Point3{});
    const Handles handles(figure(), {kLeftHand, kRightHand});
    EXPECT_EQ(handles.pull().solve(std::vector<Point3>(2)).displacements, still);
    EXPECT_EQ(handles.pull({.reach = 1}).solve(std::vector<Point3>(2)).displacements, still);
    const Handles none(figure(), {});
    EXPECT_EQ(none.pull().fixedVertices().size(), still.size());
    EXPECT_EQ(none.pull().solve({}).displacements, still);
}

// Each of the two steps minimises the energy over its part of the unknowns.
TEST(RigidPull, TheEnergyNeverIncreases) {
    const Handles handles(figure(), {kLeftHand, kRightHand, {7, 2, 0.2}});
    const std::vector<Point3> wanted = {{3, 1, -4}, {-2, 3, 2}, {0, 0, 0}};
    double before = kInfinity;
    for (int iterations = 1; iterations <= 40; ++iterations) {
        const auto pose = handles
                              .pull({.pins = {2},
                                     .reach = 0.9,
                                     .tolerance = 0,
                                     .maxIterations = iterations,
                                     .preventsFolds = false})
                              .solve(wanted);
        EXPECT_LE(pose.energy, before * (1 + 1e-12)) << iterations;  // rounding of the sums
        before = pose.energy;
    }
    EXPECT_GT(before, 1);  // The pulls stretch the figure.
}

TEST(RigidPull, SymmetricPullsGiveSymmetricPoses) {
    const Handles handles(figure(), {kLeftHand, kRightHand});
    const std::vector<Point3> wanted = {{2, -0.5, -3}, {-2, -0.5, -3}};
    const auto pose = handles.posed(handles.pull().solve(wanted).displacements);
    const auto& rest = handles.lattice.positions;
    for (std::size_t v = 0; v < rest.size(); ++v) {
        const Point3 image = {14 - rest[v][0], rest[v][1], rest[v][2]};
        const auto other = std::ranges::find_if(
            rest, [&](const Point3& p) { return length(difference(p, image)) < 1e-12; });
        ASSERT_NE(other, rest.end());
        const Point3& moved = pose[other - rest.begin()];
        EXPECT_LT(length(difference(pose[v], {14 - moved[0], moved[1], moved[2]})), 1e-9);
    }
}

/// Returns the number of cells of level 2 that a pose turns inside out.
std::size_t folds(const Handles& handles, const std::vector<Point3>& displacements) {
    const Refined refined(handles.lattice, 2);
    const ValidityCheck check(refined.complex(), refined.positions);
    return check.check(refined.pose(handles.posed(displacements))).inverted.size();
}

// A hand is pulled by a quarter of the width of the figure. Single vertices that move as little as
// possible make a needle.
TEST(RigidPull, APulledHandBendsTheArmWithoutFolds) {
    const Handles handles(figure(), {kLeftHand});
    for (const Point3& by : {Point3{0, 0, 3.5}, {0, 3.5, 0}, {0, 0, -3.5}, {1, 2, 2.5}}) {
        const auto pose = handles.pull().solve(std::vector<Point3>{by});
        EXPECT_EQ(folds(handles, pose.displacements), 0U);
        EXPECT_LT(pose.largestMiss, 1e-6);
        const auto least = fitLattice(handles.deformation, std::vector<Point3>{by},
                                      handles.lattice.complex, {.smoothing = Smoothing::Tikhonov});
        EXPECT_GT(folds(handles, least.displacements), 0U);
        // The hand turns with the arm: its edges keep their lengths. The body stays.
        double longest = 0;
        const auto moved = handles.posed(pose.displacements);
        for (Index edge = 0; edge < handles.lattice.complex.count(1); ++edge) {
            const auto ends = handles.lattice.complex.relation(1, 0)[edge];
            longest = std::max(longest, length(difference(moved[ends[0]], moved[ends[1]])));
        }
        EXPECT_LT(longest, 1.6);
        for (std::size_t v = 0; v < moved.size(); ++v)
            if (handles.lattice.positions[v][0] > 7.5) {
                EXPECT_EQ(moved[v], handles.lattice.positions[v]);
            }
    }
}

// Pulls that push limbs together, up to their length. Without the barrier, many fold cells.
TEST(RigidPull, PullsIntoTheBodyDoNotFold) {
    int foldedWithout = 0;
    for (const auto& [lattice, length] : {std::pair(figure(), 5.0), std::pair(twoLegs(), 2.0)})
        for (const double part : {0.6, 0.8, 1.0})
            for (const Point3& direction : {Point3{1, 0, 0}, {1, 0.5, -0.5}, {0, 0.1, -1}}) {
                const Handles handles(
                    lattice, {lattice.positions.size() < 100 ? Point3{0.4, 0.4, 3.6} : kLeftHand});
                const std::vector<Point3> wanted = {scaled(direction, part * length)};
                const RigidPull pull = handles.pull();
                const auto pose = pull.solve(wanted);
                EXPECT_EQ(folds(handles, pose.displacements), 0U) << direction[0] * part;
                for (const Index vertex : pull.fixedVertices())
                    EXPECT_EQ(pose.displacements[vertex], Point3{});
                const auto free = handles.pull({.preventsFolds = false}).solve(wanted);
                EXPECT_FALSE(free.meetsBarrier);
                if (folds(handles, free.displacements) == 0) continue;
                ++foldedWithout;
                EXPECT_TRUE(pose.meetsBarrier);
                EXPECT_LT(pose.largestMiss, 0.05 * length);
            }
    EXPECT_GT(foldedWithout, 4);
}

// Each frame of a drag against the barrier starts from the one before, and few iterations do.
TEST(RigidPull, NoFrameOfADragFolds) {
    const Handles handles(figure(), {kLeftHand});
    const RigidPull pull = handles.pull({.maxIterations = 10});
    std::vector<Point3> pose;
    bool meets = false;
    for (int frame = 1; frame <= 20; ++frame) {
        const auto next = pull.solve(std::vector<Point3>{{0.2 * frame, 0, 0}}, pose);
        EXPECT_EQ(folds(handles, next.displacements), 0U) << frame;
        meets = meets || next.meetsBarrier;
        pose = next.displacements;
    }
    EXPECT_TRUE(meets);
}

// The reach is the definition in the header, with distances from the pulls alone.
TEST(RigidPull, KeepsWhatIsBeyondTheReach) {
    const Handles handles(figure(), {kLeftHand, kRightHand});
    const auto& complex = handles.lattice.complex;
    const auto& rest = handles.lattice.positions;
    std::vector<shapes::WayStart> ways;
    for (const Index vertex : handles.deformation.columns(0))
        ways.push_back({vertex, length(difference(rest[vertex], kLeftHand))});
    const auto distances = shapes::distancesAlongCells(complex, rest, ways);
    for (const double reach : {0.2, 0.5, 0.8, 1.0}) {
        const auto fixed = handles.pull({.pins = {1}, .reach = reach}).fixedVertices();
        const double farthest = *std::ranges::max_element(distances);
        for (std::size_t v = 0; v < rest.size(); ++v)
            EXPECT_EQ(std::ranges::binary_search(fixed, static_cast<Index>(v)),
                      distances[v] > reach * farthest * (1 + 1e-12))
                << v;
    }
    // In a small lattice all vertices would stay; the point in the middle moves all.
    const Handles small(shapes::box(), {{0.5, 0.5, 0.5}});
    EXPECT_TRUE(small.pull().fixedVertices().empty());
    EXPECT_EQ(Handles(shapes::box(), {{0.1, 0.1, 0.1}}).pull().fixedVertices().size(), 7U);
    // A pin that stays does not matter; a pulled point does.
    EXPECT_REFUSED(
        Error, "point 1 is pulled, but all vertices that move it are frozen, such as vertex ",
        Handles(figure(), {kLeftHand, kRightHand})
            .pull({.frozen = Handles(figure(), {kLeftHand}).pull().fixedVertices(), .reach = 1}));
}

TEST(RigidPull, PinsStay) {
    const Handles handles(figure(), {kLeftHand, {2.5, 2, 5}});
    const auto pull = handles.pull({.pins = {1}, .reach = 1});
    const auto pose = pull.solve(std::vector<Point3>{{0.5, 0, 2}, {0, 0, 0}});
    const auto moved = stencils::applyLevelTable(handles.deformation, pose.displacements);
    EXPECT_LT(length(difference(moved[0], {0.5, 0, 2})), 1e-6);
    EXPECT_LT(length(moved[1]), 1e-6);
}

// The figure in other units and turned.
TEST(RigidPull, MovesWithTheLattice) {
    const Handles handles(figure(), {kLeftHand});
    const Point3 by = {1, 2, -3};
    // The box whose diagonal the tolerance refers to turns, too.
    const RigidPullOptions steps{.tolerance = 0, .maxIterations = 50};
    const auto expected = handles.pull(steps).solve(std::vector<Point3>{by}).displacements;
    for (const double size : {1e-20, 1.0, 1e20}) {
        const shapes::Affine turn =
            shapes::rotation({1, 2, 3}, 1.0) * shapes::scaling({size, size, size});
        Handles turned = handles;
        turned.lattice = shapes::transformed(handles.lattice, turn);
        turned.points = {turn(kLeftHand)};
        const auto pose = turned.pull(steps).solve(std::vector<Point3>{turn(by)}).displacements;
        double largest = 0;
        for (std::size_t v = 0; v < pose.size(); ++v)
            largest = std::max(largest, length(difference(pose[v], turn(expected[v]))) / size);
        EXPECT_LT(largest, 1e-9);
    }
}

// A drag, each frame of which starts from the one before, ends where one pull does.
TEST(RigidPull, DragsEndWhereThePullDoes) {
    const Handles handles(figure(), {kLeftHand});
    const RigidPullOptions exact{.tolerance = 1e-10, .maxIterations = 5000};
    const auto pull = handles.pull(exact);
    const auto whole = pull.solve(std::vector<Point3>{{0, 1, 3}});
    std::vector<Point3> pose;
    for (int frame = 1; frame <= 10; ++frame)
        pose = pull.solve(std::vector<Point3>{{0, 0.1 * frame, 0.3 * frame}}, pose).displacements;
    EXPECT_LT(largestDistance(pose, whole.displacements), 1e-6);
}

TEST(RigidPull, DoesNotDependOnTheNumberOfThreads) {
    const Handles handles(shapes::box({.cells = {9, 9, 9}}), {{0.95, 0.95, 0.9}});
    const auto run = [&] {
        return handles.pull({.maxIterations = 20})
            .solve(std::vector<Point3>{{0.3, -0.2, 0.4}})
            .displacements;
    };
    const auto one = withThreads(1, run);
    for (const int threads : {2, 5}) EXPECT_EQ(withThreads(threads, run), one);
}

// Targets that contradict each other, and a cell that is a point, leave finite poses.
TEST(RigidPull, DegenerateInputGivesFinitePoses) {
    const Handles twice(figure(), {kLeftHand, kLeftHand});
    const auto pose = twice.pull().solve(std::vector<Point3>{{1, 0, 0}, {0, 0, 1}});
    const auto moved = stencils::applyLevelTable(twice.deformation, pose.displacements);
    EXPECT_LT(length(difference(moved[0], {0.5, 0, 0.5})), 1e-6);
    Handles flat(figure(), {kLeftHand});
    for (const Index vertex : flat.lattice.complex.relation(3, 0)[20])
        flat.lattice.positions[vertex] = {4, 2, 5};
    for (const Point3& displacement :
         flat.pull().solve(std::vector<Point3>{{0, 0, 2}}).displacements)
        EXPECT_LT(length(displacement), 10);
}

TEST(RigidPull, RefusesBadInputByName) {
    const Handles handles(figure(), {kLeftHand});
    const std::vector<Point3> one(1, Point3{1, 0, 0});
    EXPECT_REFUSED(Error, "frozen[0]: expected a vertex, 0 to ", handles.pull({.frozen = {-1}}));
    EXPECT_REFUSED(Error, "pins[0]: expected a row, 0 to 0, got 1", handles.pull({.pins = {1}}));
    EXPECT_REFUSED(Error, "reach: expected 0 to 1, got 1.5", handles.pull({.reach = 1.5}));
    EXPECT_REFUSED(Error, "tolerance: expected a finite number of 0 or more, got -1",
                   handles.pull({.tolerance = -1}));
    EXPECT_REFUSED(Error, "maxIterations: expected 1 or more, got 0",
                   handles.pull({.maxIterations = 0}));
    EXPECT_REFUSED(Error, "got 2 targets for 1 points",
                   handles.pull().solve(std::vector<Point3>(2)));
    EXPECT_REFUSED(Error, "got 1 displacements to start from for ", handles.pull().solve(one, one));
    const std::vector<Point3> bad = {{0, kNan, 0}}, far = {{1e100, 0, 0}};
    EXPECT_REFUSED(TargetError, "the target of point 0 is not finite", handles.pull().solve(bad));
    EXPECT_REFUSED(TargetError, "the target of point 0 is more than 1e90 away",
                   handles.pull().solve(far));
    const auto& complex = handles.lattice.complex;
    auto rest = handles.lattice.positions;
    EXPECT_REFUSED(Error, "got 1 positions for the ", RigidPull(complex, one, handles.deformation));
    rest[2][1] = kInfinity;
    EXPECT_REFUSED(Error, "the position of vertex 2 is not finite",
                   RigidPull(complex, rest, handles.deformation));
    rest[2][1] = 1e95;
    EXPECT_REFUSED(Error, "more than 1e90 apart", RigidPull(complex, rest, handles.deformation));
    EXPECT_REFUSED(Error, "point 0 is pulled, but lies outside the lattice",
                   RigidPull(complex, handles.lattice.positions,
                             StencilTable<double>(complex.count(0), {0, 0}, {}, {})));
    EXPECT_REFUSED(
        Error, "the points are bound to 8 vertices",
        RigidPull(complex, handles.lattice.positions, StencilTable<double>(8, {0, 1}, {0}, {1})));
}

// Newton's iteration gives the rotation of the singular values.
TEST(RotationFit, IsTheRotationOfTheSingularValues) {
    const auto numbers = randomValues(4500, 3);
    for (std::size_t i = 0; i < 500; ++i) {
        Eigen::Matrix3d matrix = Eigen::Map<const Eigen::Matrix3d>(numbers.data() + 9 * i);
        if (i % 3 == 0) matrix *= 1e-60;
        if (i % 5 == 0) matrix.col(2) = matrix.col(0) + 1e-3 * matrix.col(1);  // nearly flat
        const Eigen::Matrix3d rotation = nearestRotation(matrix);
        EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-13);
        EXPECT_GT(rotation.determinant(), 0);
        const double trace = (rotation.transpose() * matrix).trace();
        const double best = (rotationBySingularValues(matrix).transpose() * matrix).trace();
        EXPECT_NEAR(trace, best, 1e-13 * matrix.norm());
    }
    EXPECT_EQ(nearestRotation(Eigen::Matrix3d::Zero()), Eigen::Matrix3d::Identity());
    const Eigen::Matrix3d mirror = Eigen::Vector3d(1, 2, -3).asDiagonal();
    EXPECT_NEAR(nearestRotation(mirror).determinant(), 1, 1e-14);
}

}  // namespace
}  // namespace espalier::solve
