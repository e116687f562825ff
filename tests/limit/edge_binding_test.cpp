// SPDX-License-Identifier: Apache-2.0
#include <espalier/limit/limit_binding.h>
#include <espalier/limit/limit_stencils.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>

#include <Eigen/LU>

#include "limit/limit_search.h"
#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/threads.h"

// Tests bindLimit() for points on irregular edges, and beside them.
namespace espalier::limit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Bound = embed::BoundRows<>;

/// A lattice with bent irregular edges, and points on these.
class Scene {
public:
    explicit Scene(int sectors, Rules rules = Rules::Siggraph96)
        : Scene(shapes::cylinder({.sectors = sectors, .layers = 3}), {.rules = rules}) {}

    Scene(const Lattice& straight, const far::RefinerOptions& options)
        : lattice(straight), base(lattice.complex, options) {
        for (Point3& p : lattice.positions)
            p = {p[0] + 0.1 * p[2] * p[2] + 0.05 * p[1], p[1] - 0.1 * p[2] * p[0], p[2]};
        pose = shaken(lattice.positions, 3, 0.2);
    }

    /// Adds places on an edge of level 1 that has a given number of cells, along the edge.
    /// \param isInside whether both ends of the edge are inside the lattice
    void addPlaces(std::size_t cellCount, bool isInside, std::span<const double> along) {
        TopologyRefiner refiner = base;
        refiner.refineUniform(1);
        const far::Level& level = refiner.level(1);
        std::vector<LimitLocation> locations;
        for (Index e = 0; e < level.complex.count(1) && locations.empty(); ++e) {
            const auto cells = level.complex.relation(1, 3)[e];
            const auto ends = level.complex.relation(1, 0)[e];
            const auto isInner = [&](Index v) {
                return level.strata.of({0, v}) == 3 && !level.strata.isOpen({0, v});
            };
            if (cells.size() != cellCount || level.strata.of({1, e}) != 3 ||
                (isInner(ends[0]) && isInner(ends[1])) != isInside)
                continue;
            const auto frame = *embed::frameOf(level.complex, cells.front());
            const auto coordinate = [&](Index vertex, std::size_t axis) {
                const auto corner = std::find(frame.corners.begin(), frame.corners.end(), vertex) -
                                    frame.corners.begin();
                return double(embed::bitOf(std::size_t(corner), axis));
            };
            for (const double at : along) {
                locations.push_back({frame.cell, {}});
                for (std::size_t a = 0; a < 3; ++a)
                    locations.back().uvw[a] =
                        (1 - at) * coordinate(ends[0], a) + at * coordinate(ends[1], a);
            }
        }
        ASSERT_FALSE(locations.empty());
        // The reference blends cells of this size, which bend by a power of 1.6 of their size.
        const auto rows = buildLimitStencils(refiner, 1, locations, {.tolerance = 1e-10}).position;
        const auto rest = times(rows, lattice.positions), posed = times(rows, pose);
        for (Eigen::Index i = 0; i < rest.rows(); ++i) {
            points.push_back(toPoint(rest.row(i).transpose()));
            expected.push_back(toPoint(posed.row(i).transpose()));
        }
    }

    Bound bind(const LimitOptions& options = {}) const {
        return bindLimit({base, lattice.positions}, points, options);
    }

    /// Returns F at point i in the pose.
    Matrix3d gradient(const Bound& result, Index i) const {
        const auto tables =
            embed::gradientTables(*result.gradients, lattice.positions, result.table.rowCount());
        Matrix3d f;
        for (std::size_t axis = 0; axis < 3; ++axis)
            f.col(Eigen::Index(axis)) = times(tables[axis], pose).row(i).transpose();
        return f;
    }

    Lattice lattice;
    TopologyRefiner base;
    std::vector<Point3> pose;
    std::vector<Point3> points, expected;
};

const std::vector<double> kAlong = {0, 0.1, 0.25, 1.0 / 3, 0.5, 0.77, 1};

TEST(EdgeBinding, PointsOnIrregularEdgesMoveWithTheLimit) {
    for (const Rules rules : {Rules::Siggraph96, Rules::Cse96, Rules::Mlca})
        for (const int sectors : {3, 5, 7}) {
            if (sectors != 5 && (kIsSlow || rules != Rules::Siggraph96)) continue;
            Scene scene(sectors, rules);
            scene.addPlaces(std::size_t(sectors), true, kAlong);
            // The line through the middles of the wedges has three cells around it.
            scene.addPlaces(3, true, kAlong);
            // An edge that ends at the boundary: only parts of it have layers around them.
            scene.addPlaces(std::size_t(sectors), false, std::vector<double>{0.3, 0.45, 0.6});
            const Bound result = scene.bind();
            EXPECT_EQ(result.count(embed::PointStatus::Inside), std::ssize(scene.points));
            // Rounding of sums of terms below 1.
            EXPECT_LT(result.largestResidual, 1e-14);
            const auto& rows = result.table;
            EXPECT_LT(largestDistance(times(rows, scene.lattice.positions), asMatrix(scene.points)),
                      1e-14);
            // Far below the tolerance, 1e-6: the place on the edge is exact.
            EXPECT_LT(largestDistance(times(rows, scene.pose), asMatrix(scene.expected)), 1e-14)
                << sectors;
        }
}

// The core of a torus is a loop, here of three base cells. Without boundary control the outer cells
// vanish.
TEST(EdgeBinding, LoopsAndOpenBoundaries) {
    Scene loop(shapes::torus({.segments = 3, .section = shapes::TorusSection::Disk, .sides = 5}),
               {});
    loop.addPlaces(5, true, kAlong);
    Scene open(shapes::cylinder({.sectors = 5, .pattern = {.rings = 3}, .layers = 4}),
               {.boundary = Boundary::Open});
    open.addPlaces(5, true, kAlong);
    for (const Scene* scene : {&loop, &open}) {
        const Bound result = scene->bind();
        EXPECT_EQ(result.count(embed::PointStatus::Inside), std::ssize(scene->points));
        EXPECT_LT(largestDistance(times(result.table, scene->pose), asMatrix(scene->expected)),
                  1e-14);
    }
}

// A point within the tolerance of the edge follows the tangent there; the change of the gradient
// between the edge and the point, times the distance, is the error.
TEST(EdgeBinding, PointsBesideIrregularEdgesMoveWithTheLimit) {
    for (const double distance : {1e-14, 1e-9, 1e-7, 1e-5}) {
        Scene scene(7);
        scene.addPlaces(7, true, std::vector<double>{0.3, 0.5});
        for (Point3& point : scene.points)
            point = toPoint(vec(point) + distance * Vector3d(0.48, 0.6, 0.64));
        const Bound result = scene.bind();
        EXPECT_EQ(result.count(embed::PointStatus::Inside), 2);
        const auto& rows = result.table;
        EXPECT_LT(largestDistance(times(rows, scene.lattice.positions), asMatrix(scene.points)),
                  1e-14)
            << distance;
        // With this tolerance, points farther away than 5e-13 are not taken to the edge.
        const Bound exact = scene.bind({.tolerance = 1e-13});
        const double error =
            largestDistance(times(rows, scene.pose), times(exact.table, scene.pose));
        // In a distance of 1e-7, the gradient changes by 5e-5 here (see the next test). Added is
        // the rounding of sums of terms below 1.
        EXPECT_LT(error, 1e-4 * distance + 1e-15) << distance;
    }
}

// F maps the tangent of the edge at rest to its tangent in the pose, and F is continuous between
// the edge and the cells around it.
TEST(EdgeBinding, GradientsOnIrregularEdges) {
    for (const int sectors : {3, 5, 7}) {
        constexpr double kStep = 1e-6;
        Scene scene(sectors);
        for (const double at : {0.3, 0.6})
            scene.addPlaces(std::size_t(sectors), true,
                            std::vector<double>{at, at - kStep, at + kStep});
        const Bound result = scene.bind({.gradients = true});
        const auto& expected = scene.expected;
        const auto& rest = scene.points;
        for (std::size_t i = 0; i < rest.size(); i += 3) {
            const Vector3d tangent = (vec(rest[i + 2]) - vec(rest[i + 1])) / (2 * kStep);
            const Vector3d posed = (vec(expected[i + 2]) - vec(expected[i + 1])) / (2 * kStep);
            // The error of central differences grows like a power of the step, 0.6 for seven cells.
            EXPECT_LT((scene.gradient(result, Index(i)) * tangent - posed).norm(), 1e-6) << sectors;
        }
        const auto tables = embed::gradientTables(*result.gradients, scene.lattice.positions,
                                                  result.table.rowCount());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto column = times(tables[axis], scene.lattice.positions);
            for (Eigen::Index i = 0; i < column.rows(); ++i)
                EXPECT_LT((column.row(i).transpose() - Vector3d::Unit(Eigen::Index(axis))).norm(),
                          1e-12);
        }
        // Beside the edge, patches give F. Around seven cells the change is the square root of the
        // distance: a tenth at a hundredth of the distance.
        const Vector3d middle = vec(rest[0]);
        double before = kInfinity;
        for (const double step : {1e-3, 1e-5, 1e-7}) {
            Scene beside = scene;
            beside.points = {toPoint(middle + step * Vector3d(0.48, 0.6, 0.64))};
            const double change =
                (scene.gradient(beside.bind({.gradients = true}), 0) - scene.gradient(result, 0))
                    .norm();
            EXPECT_LT(change, before / 9) << sectors << " sectors, step " << step;
            before = change;
        }
    }
}

// A point has the same rows with any other points, and with any number of threads.
TEST(EdgeBinding, DoesNotDependOnOtherPointsOrThreads) {
    Scene scene(5);
    scene.addPlaces(5, true, kAlong);
    scene.addPlaces(5, false, std::vector<double>{0.3, 0.45, 0.6});
    const auto onEdges = scene.points;
    for (const Point3& point : onEdges)
        for (const double distance : {1e-7, 0.01, 0.1})
            scene.points.push_back(toPoint(vec(point) + distance * Vector3d(0.48, 0.6, 0.1)));
    const LimitOptions options{.gradients = true};
    const auto together = withThreads(1, [&] { return scene.bind(options); });
    EXPECT_TRUE(withThreads(5, [&] { return scene.bind(options); }) == together);
    const auto tables = embed::gradientTables(*together.gradients, scene.lattice.positions,
                                              together.table.rowCount());
    for (std::size_t i = 0; i < onEdges.size(); ++i) {
        scene.points = {onEdges[i]};
        const Bound alone = scene.bind(options);
        const std::vector<Index> row = {Index(i)};
        EXPECT_TRUE(stencils::selectRows(together.table, row) == alone.table) << i;
        const auto ofAlone = embed::gradientTables(*alone.gradients, scene.lattice.positions,
                                                   alone.table.rowCount());
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_TRUE(stencils::selectRows(tables[axis], row) == ofAlone[axis]) << i;
    }
}

// The search for a point on an irregular edge ends on the first level that has layers around it.
TEST(EdgeBinding, PointsOnLayeredEdgesNeedFewLevels) {
    Scene scene(5);
    scene.addPlaces(5, true, kAlong);
    const LimitSearch search({scene.base, scene.lattice.positions}, {});
    std::vector<Index> unsettled, deep;
    const FoundPoints found = search.findInside(scene.points, unsettled, deep);
    EXPECT_THAT(unsettled, IsEmpty());
    EXPECT_THAT(deep, IsEmpty());
    for (const LocatedInLimit& located : found.points) {
        ASSERT_TRUE(located.place);
        EXPECT_TRUE(std::holds_alternative<EdgePlace>(located.place->where));
        EXPECT_LE(located.place->level, 3);
    }
}

}  // namespace
}  // namespace espalier::limit
