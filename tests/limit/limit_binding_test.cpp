// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/embed/basis_functions.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "support/random_lattices.h"
#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::limit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Bound = embed::BoundRows<>;

Bound bound(const Lattice& lattice, const std::vector<Point3>& points,
            const LimitOptions& options = {}) {
    return bindLimit({TopologyRefiner(lattice.complex, refinerOptions(lattice)), lattice.positions},
                     points, options);
}

/// Returns the limits of the vertices of a level in a pose.
std::vector<Point3> limitPoints(const Lattice& lattice, int level,
                                const std::vector<Point3>& pose) {
    TopologyRefiner refiner = test::refined(lattice.complex, level, refinerOptions(lattice));
    return stencils::applyLevelTable(buildVertexLimits(refiner, level), pose);
}

/// The tensor B-spline that a box lattice with phantom layers 2P₀ − P₁ is, evaluated by the formula
/// from the grid points.
class SplineBox {
public:
    SplineBox(const std::array<Index, 3>& cells, const std::vector<Point3>& points)
        : cells_(cells), points_(points) {}

    /// \param place in units of cells
    Vector3d at(const Vector3d& place) const {
        Vector3d sum = Vector3d::Zero();
        std::array<Index, 3> first;
        std::array<std::array<double, 4>, 3> weights;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double x = place[Eigen::Index(axis)];
            first[axis] = std::clamp(Index(x), 0, cells_[axis] - 1);
            weights[axis] = embed::cubicBSpline(x - first[axis], 0);
        }
        for (Index k = 0; k < 4; ++k)
            for (Index j = 0; j < 4; ++j)
                for (Index i = 0; i < 4; ++i)
                    sum += weights[0][i] * weights[1][j] * weights[2][k] *
                           control({first[0] + i - 1, first[1] + j - 1, first[2] + k - 1});
        return sum;
    }

private:
    Vector3d control(std::array<Index, 3> point) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Index end = cells_[axis];
            if (point[axis] >= 0 && point[axis] <= end) continue;
            const bool isLow = point[axis] < 0;
            auto edge = point, inner = point;
            edge[axis] = isLow ? 0 : end;
            inner[axis] = isLow ? 1 : end - 1;
            return 2 * control(edge) - control(inner);
        }
        return vec(points_[std::size_t(gridVertex(cells_, point[0], point[1], point[2]))]);
    }

    std::array<Index, 3> cells_;
    std::vector<Point3> points_;
};

// A box lattice under boundary control, one cell thick included, is the tensor B-spline.
TEST(LimitBinding, BoxEqualsTheTensorSpline) {
    std::mt19937 random(1);
    for (const std::array<Index, 3>& cells :
         {std::array<Index, 3>{1, 1, 1}, {3, 1, 2}, {4, 3, 5}}) {
        Lattice lattice = shapes::box({.cells = cells});
        const auto rest = gridPositions(cells);
        // The map must be bent little enough to be invertible, and enough to be far from affine.
        auto bent = rest;
        for (Point3& p : bent)
            p = {p[0] + 0.15 * p[1] * p[1], p[1] + 0.1 * std::sin(p[2]), p[2] + 0.1 * p[0] * p[0]};
        const auto pose = test::shaken(rest, 2);
        const SplineBox atRest(cells, bent), posed(cells, pose);
        lattice.positions = bent;
        std::vector<Point3> points;
        std::vector<Vector3d> expected;
        for (int i = 0; i < 200; ++i) {
            Vector3d place;
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                std::uniform_real_distribution<double> along(0, cells[axis]);
                // Include places on faces, edges and corners.
                place[axis] = i % 5 == 0 ? std::round(along(random)) : along(random);
            }
            points.push_back(toPoint(atRest.at(place)));
            expected.push_back(posed.at(place));
        }
        const Bound result = bound(lattice, points);
        EXPECT_EQ(result.count(embed::PointStatus::Inside), 200);
        // The bound that the project promises for the rest pose, relative to a size of a few units.
        EXPECT_LT(result.largestResidual, 1e-12);
        const auto moved = times(result.table, pose);
        for (std::size_t i = 0; i < points.size(); ++i)
            // The rounding of the place, 1e-16, is multiplied by the slopes of the pose divided by
            // the slopes of the rest pose. This factor is a few tens.
            EXPECT_LT((moved.row(Eigen::Index(i)).transpose() - expected[i]).norm(), 1e-13) << i;
    }
}

/// Returns points in the limit volume of a lattice: limits of level-2 vertices, and centroids of
/// the limits of a cell's vertices.
std::vector<Point3> pointsInside(const Lattice& lattice, unsigned seed) {
    TopologyRefiner refiner = test::refined(lattice.complex, 2, refinerOptions(lattice));
    const auto limits = limitPoints(lattice, 2, lattice.positions);
    std::mt19937 random(seed);
    std::vector<Point3> points;
    for (int i = 0; i < 10; ++i) points.push_back(limits[random() % limits.size()]);
    const auto& cells = refiner.level(2).complex.relation(3, 0);
    for (int i = 0; i < 10; ++i) {
        const auto corners = cells[Index(random() % unsigned(cells.rowCount()))];
        Vector3d sum = Vector3d::Zero();
        for (const Index corner : corners) sum += vec(limits[corner]);
        points.push_back(toPoint(sum / double(corners.size())));
    }
    return points;
}

// At rest each point stays where it is, and F is the identity.
TEST(LimitBinding, KeepsTheRestPose) {
    for (const auto& [name, lattice] : zoo()) {
        const auto points = pointsInside(lattice, 3);
        const Bound result = bound(lattice, points, {.gradients = true});
        EXPECT_EQ(result.count(embed::PointStatus::Inside), std::ssize(points)) << name;
        const auto moved = times(result.table, lattice.positions);
        EXPECT_LT(largestDistance(moved, asMatrix(points)), 1e-11) << name;
        const auto tables =
            embed::gradientTables(*result.gradients, lattice.positions, result.table.rowCount());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto& rows = tables[axis];
            const auto column = times(rows, lattice.positions);
            for (Index i = 0; i < rows.rowCount(); ++i) {
                if (rows.columns(i).empty()) continue;
                // The rounding of the directions at rest, divided by the thinness of the cells.
                EXPECT_LT((column.row(i).transpose() - Vector3d::Unit(Eigen::Index(axis))).norm(),
                          1e-12)
                    << name << ' ' << i;
            }
        }
    }
}

// Affine poses move the model by the affine map, which F reproduces.
TEST(LimitBinding, AffinePosesAreExact) {
    Matrix3d map;
    map << 1.2, 0.3, -0.1, 0.2, 0.8, 0.4, -0.3, 0.1, 1.1;
    const Vector3d shift(0.3, -0.7, 0.2);
    for (const auto& [name, lattice] : zoo()) {
        const auto points = pointsInside(lattice, 4);
        auto pose = lattice.positions;
        for (Point3& p : pose) p = toPoint(map * vec(p) + shift);
        const Bound result = bound(lattice, points, {.gradients = true});
        const auto moved = times(result.table, pose);
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_LT(
                (moved.row(Eigen::Index(i)).transpose() - (map * vec(points[i]) + shift)).norm(),
                1e-11)
                << name;
    }
}

// A point at the limit of a level-1 vertex moves to the limit of the vertex in the pose.
TEST(LimitBinding, MapsVertexLimitsAtRestToVertexLimitsInThePose) {
    for (const auto& [name, lattice] : zoo()) {
        // The limit volume of three bars that meet in a corner is folded there (the determinant of
        // its Jacobian is negative): a point near the corner is in two cells at once.
        if (name == "tripod") continue;
        const auto rest = limitPoints(lattice, 1, lattice.positions);
        auto pose = lattice.positions;
        for (Point3& p : pose)
            p = {p[0] + 0.2 * p[1] * p[1], p[1] - 0.1 * p[2] * p[0], p[2] + 0.3 * p[0]};
        const auto expected = limitPoints(lattice, 1, pose);
        std::vector<Point3> some, moved;
        for (std::size_t i = 0; i < rest.size(); i += 1 + rest.size() / 30) {
            some.push_back(rest[i]);
            moved.push_back(expected[i]);
        }
        const Bound result = bound(lattice, some);
        // A place in a blended cell is off by at most the size of the cell, which is below the
        // tolerance of 1e-6.
        EXPECT_LT(largestDistance(times(result.table, pose), asMatrix(moved)), 2e-6) << name;
    }
}

// The distance between a binding to a level and the binding to the limit falls to about a quarter
// with each level.
TEST(LimitBinding, LevelsConvergeToTheLimit) {
    const Lattice lattice = shapes::cylinder({.sectors = 5, .layers = 2});
    const auto points = pointsInside(lattice, 5);
    auto pose = lattice.positions;
    for (Point3& p : pose) p = {p[0] + 0.3 * p[2] * p[2], p[1] - 0.2 * p[0] * p[2], p[2]};
    const TopologyRefiner base(lattice.complex);
    const auto limit = times(bound(lattice, points).table, pose);
    double before = 0;
    for (int level = 2; level <= 5; ++level) {
        const auto model = embed::bindPoints(
            {base, lattice.positions}, points,
            {.level = level, .embedding = {.outside = embed::OutsidePolicy::Nearest}});
        const double distance = largestDistance(times(model.table, pose), limit);
        if (level > 3) {
            EXPECT_LT(distance, before / 3) << level;
        }
        before = distance;
    }
}

TEST(LimitBinding, GradientsAreTheDerivativeOfTheDeformation) {
    const Lattice lattice = shapes::cylinder({.sectors = 5, .layers = 2});
    auto pose = lattice.positions;
    for (Point3& p : pose) p = {p[0] + 0.3 * p[2] * p[2], p[1] - 0.2 * p[0] * p[2], p[2]};
    constexpr double kStep = 1e-5;
    std::vector<Point3> points;
    const auto centres = pointsInside(lattice, 6);
    for (std::size_t i = 10; i < centres.size(); ++i)
        for (int k = 0; k < 7; ++k) {
            Vector3d point = vec(centres[i]);
            if (k > 0) point[(k - 1) / 2] += k % 2 == 0 ? kStep : -kStep;
            points.push_back(toPoint(point));
        }
    const Bound result = bound(lattice, points, {.gradients = true});
    const auto moved = times(result.table, pose);
    const auto tables =
        embed::gradientTables(*result.gradients, lattice.positions, result.table.rowCount());
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto column = times(tables[axis], pose);
        for (Eigen::Index i = 0; i < moved.rows(); i += 7) {
            const Eigen::Index k = i + 1 + 2 * Eigen::Index(axis);
            // The error of central differences is the third derivative times 1e-10, plus rounding.
            EXPECT_LT((column.row(i) - (moved.row(k + 1) - moved.row(k)) / (2 * kStep)).norm(),
                      1e-7);
        }
    }
}

TEST(LimitBinding, StatusesOfPointsOutsideAndNotFinite) {
    const Lattice lattice = shapes::box({.cells = {2, 2, 2}});
    Eigen::AlignedBox3d box;
    for (const Point3& p : lattice.positions) box.extend(vec(p));
    const double size = box.diagonal().norm();
    const Vector3d side(box.max()[0], box.center()[1], box.center()[2]);
    const std::vector<Point3> points = {toPoint(side),
                                        toPoint(side + Vector3d(0.5e-6 * size, 0, 0)),
                                        toPoint(side + Vector3d(0.3 * size, 0, 0)),
                                        toPoint(box.max() + 0.1 * Vector3d::Ones()),
                                        {kNan, 0, 0},
                                        {1e99, 0, 0}};
    using enum embed::PointStatus;
    const Bound kept = bound(lattice, points);
    EXPECT_THAT(kept.statuses,
                ElementsAre(Inside, Inside, Outside, Outside, NotConverged, Outside));
    EXPECT_THAT(kept.table.emptyRows(), ElementsAre(2, 3, 4, 5));
    const LimitOptions nearest{.embedding = {.outside = embed::OutsidePolicy::Nearest}};
    const Bound carried = bound(lattice, points, nearest);
    EXPECT_THAT(carried.statuses,
                ElementsAre(Inside, Inside, Outside, Outside, NotConverged, Outside));
    EXPECT_THAT(carried.table.emptyRows(), ElementsAre(4, 5));
    const auto moved = times(carried.table, lattice.positions);
    for (Eigen::Index i = 0; i < 4; ++i)
        EXPECT_LT((moved.row(i).transpose() - vec(points[i])).norm(), 1e-12);
    EXPECT_THROW(bound(lattice, points, {.embedding = {.outside = embed::OutsidePolicy::Error}}),
                 Error);
}

/// Expects that the rest pose reproduces each point that has a row, and that a third of the points
/// have one: for the others the weights would be too large.
void expectCarried(const Bound& result, const Lattice& lattice, std::span<const Point3> points) {
    EXPECT_LE(3 * result.table.emptyRows().size(), 2 * points.size());
    const auto moved = times(result.table, lattice.positions);
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!result.table.columns(static_cast<Index>(i)).empty()) {
            EXPECT_LT((moved.row(Eigen::Index(i)).transpose() - vec(points[i])).norm(), 1e-11) << i;
        }
}

TEST(LimitBinding, PointsAroundIrregularLatticesAreCarried) {
    std::mt19937 random(7);
    std::normal_distribution<double> along;
    for (const auto& lattice : {shapes::star(), shapes::bipyramid({.sides = 6}), shapes::torus(),
                                shapes::cylinder({.sectors = 6})}) {
        std::vector<Point3> points;
        for (int i = 0; i < (kIsSlow ? 5 : 40); ++i)
            points.push_back(toPoint(Vector3d(along(random), along(random), along(random))));
        const Bound result =
            bound(lattice, points, {.embedding = {.outside = embed::OutsidePolicy::Nearest}});
        EXPECT_EQ(result.count(embed::PointStatus::NotConverged), 0);
        expectCarried(result, lattice, points);
    }
}

// Points outside are carried, wherever the nearest place is.
TEST(LimitBinding, PointsAroundRandomPolyhedraAreCarried) {
    std::mt19937 random(11);
    std::normal_distribution<double> along;
    for (const auto& [name, lattice] : zoo()) {
        std::vector<Point3> points;
        for (int i = 0; i < (kIsSlow ? 2 : 20); ++i)
            points.push_back(toPoint(Vector3d(along(random), along(random), along(random))));
        Lattice shaken = lattice;
        // Stronger displacements would turn cells inside out.
        const auto far = test::shaken(lattice.positions, 3);
        for (std::size_t v = 0; v < far.size(); ++v)
            shaken.positions[v] = toPoint(0.9 * vec(lattice.positions[v]) + 0.1 * vec(far[v]));
        const Bound result =
            bound(shaken, points, {.embedding = {.outside = embed::OutsidePolicy::Nearest}});
        EXPECT_EQ(result.count(embed::PointStatus::NotConverged), 0) << name;
        expectCarried(result, shaken, points);
    }
}

TEST(LimitBinding, ATightToleranceIsMet) {
    const Lattice lattice = shapes::star();
    const auto rest = limitPoints(lattice, 0, lattice.positions);
    const auto pose = test::shaken(lattice.positions, 8);
    const auto expected = limitPoints(lattice, 0, pose);
    const Bound result = bound(lattice, rest, {.tolerance = 1e-12});
    EXPECT_LT(largestDistance(times(result.table, pose), asMatrix(expected)), 2e-12);
}

// Points very near an irregular edge share no cells on fine levels, and each takes 15 MB there. So
// few of them are refined at once.
TEST(LimitBinding, PointsBesideAnIrregularEdgeTakeLittleMemory) {
    const Lattice lattice =
        shapes::cylinder({.sectors = 8, .layers = 2, .from = {0, 0, 0}, .to = {0, 0, 1}});
    std::vector<Point3> points;
    for (int i = 0; i < (kIsSlow ? 6 : 24); ++i) points.push_back({1e-5, 0, (i + 0.5) / 24});
    std::optional<MemoryLimit> limit;
    // The sanitizers hold memory that is free.
    if (!kIsSlow) limit.emplace(residentMemory() + 150'000'000);
    const Bound together = bound(lattice, points);
    EXPECT_EQ(together.count(embed::PointStatus::Inside), std::ssize(points));
    const auto& rows = together.table;
    for (const Index i : {0, 5}) {
        const auto alone = bound(lattice, {points[i]}).table;
        EXPECT_TRUE(stencils::selectRows(rows, std::vector<Index>{i}) == alone) << i;
    }
}

TEST(LimitBinding, RefusesCellsWithTooManyFaces) {
    const Lattice lattice = shapes::prism({.sides = 1200});
    EXPECT_MESSAGE(
        "cell 0 has 1202 faces; to bind points to the limit, at most 1000 are allowed: "
        "split it, or bind the points to a level",
        bound(lattice, {{0, 0, 0}}));
}

TEST(LimitBinding, DoesNotDependOnTheNumberOfThreads) {
    const Lattice lattice = shapes::cylinder({.sectors = 5});
    auto points = pointsInside(lattice, 9);
    std::mt19937 random(10);
    std::uniform_real_distribution<double> along(0.05, 0.6);
    while (points.size() < (kIsSlow ? 20U : 5000U))
        points.push_back({along(random), along(random), along(random)});
    const auto bind = [&] { return bound(lattice, points); };
    const auto one = withThreads(1, bind);
    EXPECT_TRUE(withThreads(5, bind) == one);
}

TEST(LimitBinding, WorksWithoutBoundaryControl) {
    const std::array<Index, 3> cells = {4, 4, 4};
    const auto rest = gridPositions(cells);
    const TopologyRefiner base(test::grid(cells), {.boundary = Boundary::Open});
    // The region that remains is the inner 2 × 2 × 2 cells.
    const std::vector<Point3> points = {{1.25, 2, 2.5}, {1, 1, 1}, {3, 3, 3}, {0.5, 2, 2}};
    const auto model = bindLimit({base, rest}, points);
    using enum embed::PointStatus;
    EXPECT_THAT(model.statuses, ElementsAre(Inside, Inside, Inside, Outside));
}

// In a lattice without volume ever more cells contain a point. The search must end, and give a
// status.
TEST(LimitBinding, LatticesWithoutVolumeGiveAStatus) {
    const std::vector<std::pair<Vector3d, Lattice>> cases = {
        {{0, 0, 0}, shapes::box({.cells = {2, 1, 2}})},
        {{1, 1, 0}, shapes::box({.cells = {2, 1, 2}})},
        {{1, 0, 0}, shapes::tetrahedron()}};
    for (auto [scale, lattice] : cases) {
        if (kIsSlow && scale[0] != 0) continue;
        for (Point3& p : lattice.positions) p = toPoint(vec(p).cwiseProduct(scale));
        const std::vector<Point3> points = {toPoint(scale * 0.3), {0.1, 0.2, 0.4}};
        for (const embed::OutsidePolicy outside :
             {embed::OutsidePolicy::Keep, embed::OutsidePolicy::Nearest}) {
            const Bound result = bound(lattice, points, {.embedding = {.outside = outside}});
            const auto moved = times(result.table, lattice.positions);
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (result.statuses[i] != embed::PointStatus::Inside) continue;
                EXPECT_LT((moved.row(Eigen::Index(i)).transpose() - vec(points[i])).norm(),
                          2 * result.largestResidual + 1e-12);
            }
            EXPECT_NE(result.statuses[1], embed::PointStatus::Inside);
        }
    }
}

TEST(LimitBinding, RefusesInvalidOptionsAndRefinedBases) {
    const Lattice lattice = shapes::box();
    EXPECT_THROW(bound(lattice, {}, {.tolerance = 0}), Error);
    EXPECT_THROW(bound(lattice, {}, {.tolerance = 0.2}), Error);
    EXPECT_THROW(bound(lattice, {}, {.tolerance = kNan}), Error);
    const TopologyRefiner rats(gridMesh(2, 2), {.rules = Rules::Rats});
    EXPECT_REFUSED(Error, "RATS", bindLimit({rats, std::vector<Point3>(9)}, {}));
    TopologyRefiner refined(lattice.complex);
    refined.refineUniform(1);
    EXPECT_THROW(bindLimit({refined, lattice.positions}, {}), Error);
}

}  // namespace
}  // namespace espalier::limit
