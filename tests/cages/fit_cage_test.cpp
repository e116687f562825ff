// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/vector3.h>
#include <espalier/shapes/inventory.h>
#include <gtest/gtest.h>

#include "cages/fit_cage.h"
#include "grid_cages.h"
#include "lattice_measures.h"
#include "support/test.h"
#include "support/threads.h"

namespace espalier::cages {
namespace {

/// Returns work without a bound.
Work& unbounded() {
    static Work work(kInfinity);
    return work;
}

Lattice fitTo(Lattice start, std::span<const Point3> points, const FitOptions& options = {}) {
    return fitCage(std::move(start), test::fitPoints(points), options, unbounded());
}

using test::badCells, test::limitVolume, test::outsideLevel, test::outsideLimit;

/// Returns every n-th point, about `count` of them.
std::vector<Point3> someOf(std::span<const Point3> points, std::size_t count) {
    std::vector<Point3> some;
    const std::size_t step = std::max<std::size_t>(1, points.size() / count);
    for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
    return some;
}

struct NamedSolid {
    const char* name;
    test::Solid (*make)();
};

class FitCageAround : public testing::TestWithParam<NamedSolid> {};

TEST_P(FitCageAround, holdsThePointsOfASolidTightly) {
    const test::Solid solid = GetParam().make();
    double edge = 0;
    const Lattice start = test::gridCageOf(solid, 500, edge);
    ASSERT_GE(start.complex.count(0), 400);
    const auto points = test::pointsOf(solid, edge / 8);
    ASSERT_GE(points.size(), 5000u);

    const Lattice cage = fitTo(start, points);

    EXPECT_THAT(badCells(cage), IsEmpty());
    EXPECT_EQ(outsideLevel(cage, points), 0);
    EXPECT_EQ(outsideLimit(cage, someOf(points, 120)), 0);
    EXPECT_GE(limitVolume(start), 1.6 * solid.volume);  // else there is nothing to fit
    EXPECT_LE(limitVolume(cage), 1.5 * solid.volume);
    EXPECT_GE(limitVolume(cage), solid.volume);
}

INSTANTIATE_TEST_SUITE_P(Solids, FitCageAround,
                         testing::Values(NamedSolid{"ball", test::ball},
                                         NamedSolid{"torus", test::torus},
                                         NamedSolid{"brick", test::brick},
                                         NamedSolid{"figure", test::figure}),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

/// A small cage of a torus, with 100 to 150 vertices, and points of the torus.
struct Small {
    double edge = 0;
    Lattice start = test::gridCageOf(test::torus(), 150, edge);
    std::vector<Point3> points = test::pointsOf(test::torus(), edge / 8);
};

TEST(FitCage, doesNotDependOnThreadsAndOrder) {
    Small small;
    const auto alone = withThreads(1, [&] { return fitTo(small.start, small.points); });
    std::mt19937 random(1);
    std::shuffle(small.points.begin(), small.points.end(), random);
    const auto shared = withThreads(4, [&] { return fitTo(small.start, small.points); });
    EXPECT_EQ(alone.positions, shared.positions);
    EXPECT_NE(alone.positions, small.start.positions);
}

TEST(FitCage, keepsAMargin) {
    const Small small;
    const double margin = 0.1;
    const Lattice cage = fitTo(small.start, small.points, {.margin = margin});
    // Points as far outside the torus as the margin, less a little for the spacing of the points.
    std::vector<Point3> moved;
    for (const Point3& p : someOf(small.points, 150)) {
        const double round = std::hypot(p[0], p[1]);
        const Point3 centre = {p[0] / round, p[1] / round, 0};
        moved.push_back(sum(p, scaled(normalised(difference(p, centre)), 0.95 * margin)));
    }
    EXPECT_EQ(outsideLimit(cage, moved), 0);
    EXPECT_GT(outsideLimit(fitTo(small.start, small.points), moved), 0);
}

TEST(FitCage, widensAStartThatIsTooSmall) {
    Small small;
    for (Point3& p : small.start.positions) p = scaled(p, 0.9);
    ASSERT_GT(outsideLevel(small.start, small.points), 0);
    const Lattice cage = fitTo(small.start, small.points);
    EXPECT_THAT(badCells(cage), IsEmpty());
    EXPECT_EQ(outsideLevel(cage, small.points), 0);
}

// A point and a margin of two edges need at least 33 times the volume of the start.
TEST(FitCage, saysThatTheStartIsTooSmall) {
    const std::vector<Point3> points = {{0.5, 0.5, 0.5}};
    EXPECT_REFUSED(FitError,
                   "fitting a cage of 8 vertices: it grows to more than 2 times its volume",
                   fitTo(shapes::box({.cells = {1, 1, 1}}), points, {.margin = 2}));
}

TEST(FitCage, refusesAStartThatIsInsideOut) {
    Lattice start = shapes::box({.cells = {1, 1, 1}});
    for (Point3& position : start.positions) position[0] *= -1;
    EXPECT_MESSAGE("fitting a cage: the start lattice is inside out",
                   fitTo(start, std::vector<Point3>{{-0.5, 0.5, 0.5}}));
}

TEST(FitCage, leavesTopologyAndMarks) {
    const Small small;
    Lattice start = small.start;
    const auto ends = start.complex.relation(1, 0)[0];
    start.marks.edges = {{{ends[0], ends[1]}, far::kInfinitelySharp}};
    const Lattice cage = fitTo(start, small.points);
    EXPECT_EQ(cage.marks, start.marks);
    EXPECT_EQ(cage.complex.count(3), start.complex.count(3));
    EXPECT_EQ(outsideLevel(cage, small.points), 0);
}

TEST(FitCage, fitsAwayFromTheOriginAndAtAnyScale) {
    const Small small;
    const double scale = 1e-6;
    const Point3 shift = {3e-3, -2e-3, 1e-3};
    Lattice start = small.start;
    std::vector<Point3> points = small.points;
    for (Point3& p : start.positions) p = sum(scaled(p, scale), shift);
    for (Point3& p : points) p = sum(scaled(p, scale), shift);
    const Lattice cage = fitTo(start, points);
    EXPECT_EQ(outsideLevel(cage, points), 0);
    const double volume = test::torus().volume * scale * scale * scale;
    const double fitted = limitVolume(fitTo(small.start, small.points)) / test::torus().volume;
    // Iterations magnify rounding, so that the two fits differ a little.
    EXPECT_NEAR(limitVolume(cage) / volume, fitted, 0.1 * fitted);
}

/// Points at random along a random walk: thin parts, contacts and cavities.
test::Solid randomWalk(unsigned seed, std::vector<Point3>& points) {
    std::mt19937 random(seed);
    std::normal_distribution<double> step(0, 0.3);
    Point3 place = {0, 0, 0};
    for (int i = 0; i < 8; ++i) {
        const Point3 next = sum(place, {step(random), step(random), step(random)});
        for (int k = 0; k < 30; ++k)
            points.push_back(sum(place, scaled(difference(next, place), k / 30.0)));
        place = next;
    }
    test::Solid solid{[points](const Point3& p) {
                          double least = 1e9;
                          for (const Point3& q : points)
                              least = std::min(least, length(difference(p, q)));
                          return least - 0.01;
                      },
                      points[0], points[0], 0};
    for (const Point3& p : points)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            solid.low[axis] = std::min(solid.low[axis], p[axis] - 0.01);
            solid.high[axis] = std::max(solid.high[axis], p[axis] + 0.01);
        }
    return solid;
}

TEST(FitCage, provesOrRefusesRandomWalks) {
    int proved = 0;
    constexpr int kWalks = 2;
    for (unsigned seed = 0; seed < kWalks; ++seed) {
        std::vector<Point3> points;
        const test::Solid solid = randomWalk(seed, points);
        const Lattice start = test::gridCage(solid, 0.25);
        SCOPED_TRACE("seed " + std::to_string(seed));
        try {
            const Lattice cage = fitTo(start, points);
            ++proved;
            EXPECT_THAT(badCells(cage), IsEmpty());
            EXPECT_EQ(outsideLevel(cage, points), 0);
        } catch (const Error& error) {
            EXPECT_THAT(error.what(), HasSubstr("is not proved"));
        }
    }
    EXPECT_EQ(proved, kWalks);
}

TEST(FitCage, refusesBadArguments) {
    const Small small;
    const auto fit = [&](std::span<const Point3> points, const FitOptions& options = {}) {
        return fitTo(small.start, points, options);
    };
    const std::vector<Point3> none;
    EXPECT_THAT([&] { fit(none); }, ThrowsMessage<Error>(HasSubstr("there are no points")));
    const std::vector<Point3> infinite = {{0, 0, 0}, {0, INFINITY, 0}};
    EXPECT_THAT([&] { fit(infinite); }, ThrowsMessage<Error>(HasSubstr("point 1 is not finite")));
    EXPECT_THAT([&] { fit(small.points, {.margin = -1}); },
                ThrowsMessage<Error>(HasSubstr("the margin is -1")));
    Lattice mesh;
    mesh.complex = far::buildMesh(3, std::vector<std::vector<Index>>{{0, 1, 2}});
    EXPECT_THAT([&] { fitTo(mesh, small.points); },
                ThrowsMessage<Error>(HasSubstr("not a lattice")));
    EXPECT_THAT([&] { fit(small.points, {.maxRounds = 0}); },
                ThrowsMessage<Error>(HasSubstr("maxRounds is 0")));
    EXPECT_THAT([&] { fit(small.points, {.maxAttempts = 5}); },
                ThrowsMessage<Error>(HasSubstr("maxAttempts is 5")));
    EXPECT_THAT([&] { fitCage(small.start, {FitPoint{.cell = 1000}}, {}, unbounded()); },
                ThrowsMessage<Error>(HasSubstr("point 0 belongs to cell 1000")));
    Lattice open = small.start;
    open.tags.boundary = far::Boundary::Open;
    EXPECT_THAT([&] { fitTo(open, small.points); },
                ThrowsMessage<Error>(HasSubstr("open boundary")));
    Lattice semiSharp = small.start;
    semiSharp.marks.vertices = {{0, 1.5}};
    EXPECT_THAT([&] { fitTo(semiSharp, small.points); },
                ThrowsMessage<Error>(HasSubstr("semi-sharp")));
    Lattice flat = small.start;
    for (Point3& p : flat.positions) p = {1, 2, 3};
    EXPECT_THAT([&] { fitTo(flat, small.points); },
                ThrowsMessage<Error>(HasSubstr("at one place")));
    Lattice short_ = small.start;
    short_.positions.pop_back();
    EXPECT_THAT([&] { fitTo(short_, small.points); },
                ThrowsMessage<Error>(HasSubstr("positions for")));
}

/// Returns the work of a fit.
double workOf(const Small& small, double limit) {
    Work work(limit);
    fitCage(small.start, test::fitPoints(small.points), {}, work);
    return work.done();
}

TEST(FitCage, endsWhenItsWorkIsDone) {
    Small small;
    const double whole = workOf(small, kInfinity);
    EXPECT_EQ(workOf(small, whole), whole);
    EXPECT_THROW(workOf(small, whole / 2), WorkError);
}

TEST(FitCage, namesAPointFarOutside) {
    Small small;
    small.points.push_back({50, 0, 0});
    EXPECT_THAT([&] { fitTo(small.start, small.points); },
                ThrowsMessage<Error>(AllOf(HasSubstr("the point (50, 0, 0) is 48."),
                                           HasSubstr("outside the start lattice"))));
}

}  // namespace
}  // namespace espalier::cages
