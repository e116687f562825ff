// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>

#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/test.h"
#include "support/zoo.h"

// Tests coordinates and cells that cause trouble in arithmetic: the status tells what happened to a
// point.

namespace espalier::embed {
namespace {

std::vector<Point3> scaled(std::vector<Point3> points, int exponent) {
    for (Point3& point : points)
        for (double& coordinate : point) coordinate = std::ldexp(coordinate, exponent);
    return points;
}

BoundRows<> bind(const Lattice& lattice, const std::vector<Point3>& points,
                 const EmbeddingOptions& options = {}, int level = 2) {
    const TopologyRefiner refiner(lattice.complex);
    return bindPoints({refiner, lattice.positions}, points, {.level = level, .embedding = options});
}

/// Returns the distance, at rest, between point `i` and its position by D.
double errorOf(const BoundRows<>& model, const Lattice& lattice, const std::vector<Point3>& points,
               std::size_t i) {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    const auto& table = model.table;
    const auto row = Index(i);
    for (std::size_t k = 0; k < table.weights(row).size(); ++k)
        position += table.weights(row)[k] * vec(lattice.positions[table.columns(row)[k]]);
    return (position - vec(points[i])).stableNorm();
}

class HostileNumbers : public testing::TestWithParam<OutsidePolicy> {};
INSTANTIATE_TEST_SUITE_P(, HostileNumbers,
                         testing::Values(OutsidePolicy::Keep, OutsidePolicy::Nearest),
                         [](const auto& policy) {
                             return policy.param == OutsidePolicy::Keep ? "Kept" : "Carried";
                         });

// A lattice of any size is bound as a lattice of size 1, to the last bit. Sizes are powers of two,
// so that the coordinates themselves are not rounded. 2^±960 is 1e±289; cells of level 2 are
// smaller.
TEST_P(HostileNumbers, SizeOfTheLatticeDoesNotMatter) {
    for (const Lattice& lattice : {mixedLattice(), shapes::torus()}) {
        const Refined refined(lattice, 2);
        std::vector<Point3> points = pointsIn(refined, 200, 1);
        points.push_back({7, -3, 2});
        points.push_back(lattice.positions[0]);
        const auto expected = bind(lattice, points, {.outside = GetParam()});
        const Embedding places = refined.embed(points, {.outside = GetParam()});
        for (const int exponent : {-960, -500, -30, 30, 500, 960}) {
            Lattice other = lattice;
            other.positions = scaled(other.positions, exponent);
            const std::vector<Point3> moved = scaled(points, exponent);
            const auto got = bind(other, moved, {.outside = GetParam()});
            EXPECT_EQ(got.table, expected.table) << exponent;
            EXPECT_EQ(got.statuses, expected.statuses) << exponent;
            EXPECT_EQ(got.largestResidual, std::ldexp(expected.largestResidual, exponent));

            const Embedding found =
                embedPoints(refined.complex(), scaled(refined.positions, exponent), moved,
                            {.outside = GetParam()});
            for (std::size_t i = 0; i < points.size(); ++i) {
                EXPECT_EQ(found.points[i].status, places.points[i].status) << i;
                EXPECT_EQ(found.points[i].distance,
                          std::ldexp(places.points[i].distance, exponent));
                ASSERT_EQ(found.points[i].place.has_value(), places.points[i].place.has_value());
                if (!places.points[i].place) continue;
                EXPECT_EQ(found.points[i].place->uvw, places.points[i].place->uvw) << i;
                EXPECT_EQ(found.points[i].place->offset, places.points[i].place->offset) << i;
            }
        }
    }
}

// A cube with sides of 1024 times the smallest double.
TEST_P(HostileNumbers, WorksWithDenormals) {
    Lattice cube = shapes::box();
    cube.positions = scaled(cube.positions, -1064);
    const std::vector<Point3> points = scaled({{0.5, 0.25, 0.75}, {0, 0, 0}, {2, 0, 0}}, -1064);
    const auto model = bind(cube, points, {.outside = GetParam()});
    EXPECT_EQ(model.statuses[0], PointStatus::Inside);
    EXPECT_EQ(model.statuses[1], PointStatus::Inside);
    EXPECT_EQ(model.statuses[2], PointStatus::Outside);
    for (std::size_t i = 0; i < 2; ++i)
        EXPECT_LE(errorOf(model, cube, points, i), 4 * std::numeric_limits<double>::denorm_min());
}

// All vertices are in one place, so the tolerance, a fraction of the size of the lattice, is 0. Any
// other point is outside, however near.
TEST_P(HostileNumbers, LatticeWithoutSize) {
    Lattice lattice = mixedLattice();
    for (Point3& position : lattice.positions) position = {0, 0, 0};
    const auto model =
        bind(lattice, {{0, 0, 0}, {7.9e-309, 0, 0}, {1, 2, 3}}, {.outside = GetParam()}, 1);
    using enum PointStatus;
    EXPECT_EQ(model.statuses, (std::vector{Inside, Outside, Outside}));
    EXPECT_EQ(model.table.emptyRows(), (std::vector<Index>{1, 2}));
}

TEST_P(HostileNumbers, PointsNotFiniteOrFarAway) {
    const Lattice cube = shapes::box();
    const std::vector<Point3> none = {{kNan, 0, 0}, {0, kInfinity, 0}, {0, 0, -kInfinity}};
    const std::vector<Point3> tooFar = {
        {1e308, 0, 0}, {1e200, -1e200, 0}, {0, 1e101, 0}, {0, 0, 1e20}};
    // The first point is 99 sizes away, the second one 3.4 cells from a face.
    const std::vector<Point3> far = {{171, 0.5, 0.5}, {0.5, -3.4, 0.5}};
    // Level 8 has 16 million cells; binding must visit only a few of them.
    for (const int level : {1, 2, kIsSlow ? 5 : 8}) {
        for (const auto status : bind(cube, none, {.outside = GetParam()}, level).statuses)
            EXPECT_EQ(status, PointStatus::NotConverged);
        for (const auto status : bind(cube, tooFar, {.outside = GetParam()}, level).statuses)
            EXPECT_EQ(status, PointStatus::Outside);
        const auto model = bind(cube, far, {.outside = GetParam()}, level);
        for (std::size_t i = 0; i < far.size(); ++i) {
            EXPECT_EQ(model.statuses[i], PointStatus::Outside) << i;
            const auto weights = model.table.weights(Index(i));
            const bool isCarried = i == 1 && GetParam() == OutsidePolicy::Nearest;
            ASSERT_EQ(weights.empty(), !isCarried) << i;
            if (isCarried) {
                EXPECT_LE(errorOf(model, cube, far, i), 1e-12 * vec(far[i]).norm()) << i;
            }
        }
    }
}

TEST_P(HostileNumbers, VerticesNotFiniteAreRefused) {
    for (const double bad : {kNan, kInfinity, -kInfinity}) {
        Lattice cube = shapes::box();
        cube.positions[5][1] = bad;
        EXPECT_THROW(bind(cube, {{0.5, 0.5, 0.5}}, {.outside = GetParam()}), Error);
    }
}

/// A way to degrade a lattice.
struct Deformity {
    const char* name;
    Point3 (*of)(const Point3&);
};

constexpr Deformity kDeformities[] = {
    {"as it was", [](const Point3& p) { return p; }},
    {"inside out",
     [](const Point3& p) {
         return Point3{p[0], p[1], -p[2]};
     }},
    {"flat",
     [](const Point3& p) {
         return Point3{p[0], p[1], 0};
     }},
    {"flat and aslant",
     [](const Point3& p) {
         return Point3{p[0], p[1], 0.3 * p[0] - 0.1 * p[1]};
     }},
    {"a line",
     [](const Point3& p) {
         return Point3{p[0], 0, 0};
     }},
    {"a point",
     [](const Point3&) {
         return Point3{1, 2, 3};
     }},
    {"folded",
     [](const Point3& p) {
         return Point3{std::abs(p[0] - 0.4), p[1], p[2]};
     }},
    {"thin",
     [](const Point3& p) {
         return Point3{p[0], p[1], 1e-9 * p[2]};
     }},
    {"thinner than rounding",
     [](const Point3& p) {
         return Point3{p[0], p[1], 1 + 1e-17 * p[2]};
     }},
    {"far away",
     [](const Point3& p) {
         return Point3{p[0] + 1e9, p[1], p[2]};
     }},
    {"twisted", [](const Point3& p) {
         const double angle = 3 * p[2];
         return Point3{std::cos(angle) * p[0] - std::sin(angle) * p[1],
                       std::sin(angle) * p[0] + std::cos(angle) * p[1], p[2]};
     }}};

// Points in the cells of a degraded lattice are found where they are, or have a status that says
// that they are not found.
TEST_P(HostileNumbers, CellsOfAnyVolume) {
    for (const Lattice& base : {mixedLattice(), shapes::icosahedron()})
        for (const Deformity& deformity :
             someOf(std::vector(std::begin(kDeformities), std::end(kDeformities)))) {
            Lattice lattice = base;
            for (Point3& position : lattice.positions) position = deformity.of(position);
            const Refined refined(lattice, 2);
            const std::vector<Point3> points = pointsIn(refined, 10, 3);
            const auto model = bind(lattice, points, {.outside = GetParam()});
            double size = 0;
            for (const Point3& position : lattice.positions)
                size = std::max(size, vec(position).norm());
            EXPECT_TRUE(std::isfinite(model.largestResidual)) << deformity.name;
            for (std::size_t i = 0; i < points.size(); ++i) {
                const auto weights = model.table.weights(Index(i));
                for (const double weight : weights) ASSERT_TRUE(std::isfinite(weight));
                if (weights.empty()) {
                    EXPECT_NE(model.statuses[i], PointStatus::Inside) << deformity.name;
                    continue;
                }
                // The rounding of the solution is 1e-12 of the size. The residual of a point that
                // got its nearest place is at most the tolerance, a millionth of the diagonal.
                EXPECT_LE(errorOf(model, lattice, points, i), model.largestResidual + 2e-12 * size)
                    << deformity.name << " " << i;
                EXPECT_LE(model.largestResidual, 4e-6 * size) << deformity.name;
            }
        }
}

}  // namespace
}  // namespace espalier::embed
