// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/embed/local_binding.h>
#include <espalier/embed/point_location.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/sparse_matrix.h>

#include <Eigen/Geometry>
#include <atomic>

#include "support/random_lattices.h"
#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::embed {
namespace {

using Eigen::Vector3d;

double diagonal(std::span<const Point3> positions) {
    Eigen::AlignedBox3d box;
    for (const Point3& position : positions) box.extend(vec(position));
    return box.diagonal().norm();
}

/// Bends positions, so that no cell is a box and faces are not flat.
std::vector<Point3> bent(std::span<const Point3> positions, double amount) {
    std::vector<Point3> result;
    const double size = diagonal(positions);
    for (const Point3& p : positions) {
        const auto wave = [&](double t) { return amount * size * std::sin(5 * t / size); };
        result.push_back({p[0] + wave(p[1] + 0.3 * p[2]), p[1] + wave(p[2]), p[2] + wave(p[0])});
    }
    return result;
}

/// The slow way: refines the whole level, and builds a tree over its cells.
struct WholeLevelBinding {
    TopologyRefiner refiner;
    std::vector<Point3> positions;
    Embedding embedding;
    StencilTable<double> table;

    WholeLevelBinding(const TopologyRefiner& base, std::span<const Point3> rest, int level,
                      std::span<const Point3> points, EmbeddingOptions options)
        : refiner(base) {
        refiner.refineUniform(level);
        positions = stencils::refinePositions(refiner, level, rest);
        // This tolerance is relative to the size of its own level.
        options.tolerance *= diagonal(rest) / diagonal(positions);
        embedding = embedPoints(refiner.level(level).complex, positions, points, options);
        table = buildDeformationTable(refiner, level, embedding);
    }

    /// The points without a row.
    std::vector<Index> kept() const {
        std::vector<Index> result;
        for (Index i = 0; i < table.rowCount(); ++i)
            if (table.columns(i).empty()) result.push_back(i);
        return result;
    }
};

/// Returns points in, on and near the lattice, and far from it.
std::vector<Point3> somePoints(std::span<const Point3> rest, const WholeLevelBinding& whole,
                               int level, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1), wide(-0.3, 1.3);
    const CellComplex& complex = whole.refiner.level(level).complex;
    const auto any = [&](int dimension) {
        return Index(random() % unsigned(complex.count(dimension)));
    };
    Eigen::AlignedBox3d box;
    for (const Point3& position : rest) box.extend(vec(position));
    std::vector<Point3> points;
    for (std::size_t i = 0; i < count; ++i) {
        Vector3d point = Vector3d::Zero();
        if (i % 8 == 7) {
            for (Eigen::Index c = 0; c < 3; ++c)
                point[c] = box.min()[c] + wide(random) * (box.max()[c] - box.min()[c]);
        } else {
            // In a cell; on a face, which may have a gap beside it; on an edge; on a vertex.
            const int dimension = i % 8 < 4 ? 3 : int(i % 8) - 4;
            const auto vertices = complex.relation(dimension, 0)[any(dimension)];
            double sum = 0;
            for (const Index vertex : vertices) {
                const double weight = unit(random);
                sum += weight;
                point += weight * vec(whole.positions[vertex]);
            }
            point /= sum;
        }
        points.push_back({point[0], point[1], point[2]});
    }
    const double size = diagonal(rest);
    points.push_back({100 * size, 3 * size, -20 * size});
    points.push_back({kNan, 0, 0});
    points.push_back({0, kInfinity, 0});
    return points;
}

/// Returns D, the product of its factors.
StencilTable<double> productOf(const stencils::FactoredTable<double>& table) {
    return stencils::multiply(table.points, table.vertices);
}

/// Returns the largest absolute difference of two weights.
double largestDifference(const StencilTable<double>& a, const StencilTable<double>& b) {
    const Eigen::SparseMatrix<double, Eigen::RowMajor, Index> difference =
        stencils::SparseView<double>(a).matrix() - stencils::SparseView<double>(b).matrix();
    double largest = 0;
    for (Eigen::Index i = 0; i < difference.nonZeros(); ++i)
        largest = std::max(largest, std::abs(difference.valuePtr()[i]));
    return largest;
}

bool hasRegularCells(const far::Level& base) {
    for (Index cell = 0; cell < base.complex.count(3); ++cell)
        if (isRegularCell(base, cell)) return true;
    return false;
}

/// Compares D and its factors with those of the whole level: to the last bit where points are found
/// by refinement, and up to rounding in regular cells, whose rows are made by formula.
void expectSameAsWholeLevel(const std::string& name, const TopologyRefiner& base,
                            std::span<const Point3> rest, int level, std::size_t pointCount,
                            unsigned seed) {
    const auto points =
        somePoints(rest, WholeLevelBinding(base, rest, level, {}, {}), level, pointCount, seed);
    for (const OutsidePolicy outside : {OutsidePolicy::Keep, OutsidePolicy::Nearest}) {
        const EmbeddingOptions options{.outside = outside};
        const WholeLevelBinding whole(base, rest, level, points, options);
        const BoundRows<> bound =
            bindPoints({base, rest}, points, {.level = level, .embedding = options});
        ASSERT_EQ(bound.statuses.size(), points.size());
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_EQ(bound.statuses[i], whole.embedding.points[i].status)
                << name << ", level " << level << ", point " << i << " of " << points.size();
        EXPECT_LE(bound.largestResidual,
                  std::max(1e-15 * diagonal(rest), whole.embedding.largestResidual()))
            << name;
        if (!hasRegularCells(base.level(0))) {
            EXPECT_TRUE(bound.table == whole.table) << name << ", level " << level;
        }
        // A place is off by the rounding of coordinates, 1e-15 of the lattice, which is at most
        // some ten cells wide.
        EXPECT_LE(largestDifference(bound.table, whole.table), 1e-13)
            << name << ", level " << level;
        EXPECT_EQ(bound.table.emptyRows(), whole.kept()) << name;
        const auto factored =
            bindFactored({base, rest}, points, {.level = level, .embedding = options});
        EXPECT_EQ(factored.statuses, bound.statuses) << name;
        EXPECT_EQ(factored.table.points.emptyRows(), bound.table.emptyRows()) << name;
        EXPECT_TRUE(productOf(factored.table) == whole.table) << name << ", level " << level;
    }
}

TEST(LocalBinding, EqualsBindingToTheWholeLevel) {
    for (const auto& [name, lattice] : zoo()) {
        for (const Boundary boundary : {Boundary::Sharp, Boundary::EdgeOnly, Boundary::Open}) {
            const auto rest = bent(lattice.positions, 0.02);
            for (const int level : {1, 2, 3}) {
                const TopologyRefiner base(lattice.complex, {.rules = kLatticeRules[level - 1],
                                                             .boundary = boundary,
                                                             .marks = lattice.marks});
                // Larger lattices and more modes test nothing new here, and take long.
                if (level == 3 && (lattice.complex.count(3) > 4 || boundary == Boundary::EdgeOnly))
                    continue;
                try {
                    TopologyRefiner(base).refineUniform(level);
                } catch (const far::TopologyError&) {
                    ASSERT_EQ(boundary, Boundary::Open) << name;
                    continue;
                }
                expectSameAsWholeLevel(name, base, rest, level, 40, unsigned(level));
            }
        }
    }
}

TEST(LocalBinding, SupportsFadingMarksInEveryMode) {
    for (unsigned seed = 0; seed < (kIsSlow ? 2 : 16); ++seed) {
        const Lattice lattice = randomLattice(seed);
        far::RefinerOptions options = refinerOptions(lattice);
        if (seed % 2 != 0) options.rules = Rules::Mlca;
        const TopologyRefiner base(lattice.complex, options);
        expectSameAsWholeLevel("seed " + std::to_string(seed), base, bent(lattice.positions, 0.01),
                               3, 60, seed);
    }
}

// Under Chaikin's rule, an edge that fades at one end only may have a sharpness above 1. Its point
// is then extrapolated: it is outside the box of the vertices that it depends on, where no bound
// would find it.
TEST(LocalBinding, FindsPointsExtrapolatedOutOfTheHull) {
    Lattice lattice = shapes::box();
    const auto& complex = lattice.complex;
    // 3/4 · 1.3 + 1/4 · 0.05 − 1 is negative at both ends, so 1.3 is used up in one step: the point
    // is 1.3 times the middle minus 0.3 times the smooth point.
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        const auto ends = complex.relation(1, 0)[edge];
        lattice.marks.edges.push_back({{ends[0], ends[1]}, edge == 0 ? 1.3 : 0.05});
    }
    for (Index vertex = 0; vertex < complex.count(0); ++vertex)
        lattice.marks.vertices.push_back({vertex, far::kSmooth});
    const TopologyRefiner base(complex,
                               {.creasing = far::Creasing::Chaikin, .marks = lattice.marks});
    constexpr int kLevel = 1;
    const WholeLevelBinding whole(base, lattice.positions, kLevel, {}, {});
    Eigen::AlignedBox3d box;
    for (const Point3& position : lattice.positions) box.extend(vec(position));
    std::vector<Point3> points;
    for (const Point3& position : whole.positions)
        if (box.exteriorDistance(vec(position)) > 0) points.push_back(position);
    ASSERT_GT(points.size(), 0U);
    ASSERT_LT(points.size(), 8U) << "else the whole level is taken";
    const auto bound = bindPoints({base, lattice.positions}, points, {.level = kLevel});
    EXPECT_EQ(bound.count(PointStatus::Inside), std::ssize(points));
}

// Several groups, and most cells contain points.
TEST(LocalBinding, SeveralGroupsEqualTheWholeLevel) {
    if (kIsSlow) GTEST_SKIP() << "takes minutes here; run without sanitizers";
    const Lattice lattice = shapes::cylinder({.sectors = 5, .pattern = {1}, .layers = 2});
    const TopologyRefiner base(lattice.complex);
    TopologyRefiner whole(base);
    whole.refineUniform(4);
    constexpr std::size_t kPoints = 17'000;
    ASSERT_GT(whole.level(4).complex.count(3), Index(kPoints)) << "else the whole level is taken";
    expectSameAsWholeLevel("cylinder", base, lattice.positions, 4, kPoints, 1);
}

// With as many points as cells, binding refines the whole level.
TEST(LocalBinding, ManyPointsInFewCells) {
    if (kIsSlow) GTEST_SKIP() << "takes minutes here; run without sanitizers";
    const Lattice lattice = shapes::star();
    expectSameAsWholeLevel("star", TopologyRefiner(lattice.complex), lattice.positions, 2, 17'000,
                           4);
}

// Points are processed along a curve, but an error names the first point outside.
TEST(LocalBinding, NamesTheFirstPointOutsideTheWholeLevel) {
    const Lattice lattice = shapes::box({.cells = {1, 1, 1}});
    std::vector<Point3> points;
    for (int i = 0; i < 100; ++i) points.push_back({0.99 - 0.009 * i, 0.5, 0.5});
    points[57] = {2, 2, 2};
    points[80] = {-1, -1, -1};
    BindingOptions options{.level = 1};
    options.embedding.outside = OutsidePolicy::Error;
    const TopologyRefiner base(lattice.complex);
    EXPECT_THAT(messageOf<Error>([&] {
                    bindPoints({base, lattice.positions}, points, options);
                }),
                HasSubstr("point 57 at (2, 2, 2) is outside"));
    options.embedding.outside = OutsidePolicy::Keep;
    EXPECT_THAT(bindPoints({base, lattice.positions}, points, options).table.emptyRows(),
                ElementsAre(57, 80));
}

TEST(LocalBinding, ReportsProgressOfEachPointOnce) {
    // 20,000 points are located in several chunks: in regular cells; by refinement; in both ways.
    std::vector<Point3> points(20'000, Point3{0.1, 0.2, 0.3});
    const auto expectAll = [&](const Lattice& lattice) {
        std::atomic<Offset> largest = 0;
        bindPoints({TopologyRefiner(lattice.complex), lattice.positions}, points,
                   {.level = 1, .progress = [&](Offset done) {
                        for (Offset before = largest; before < done;)
                            if (largest.compare_exchange_weak(before, done)) break;
                    }});
        EXPECT_EQ(largest, std::ssize(points));
    };
    expectAll(shapes::box({.cells = {2, 2, 2}}));
    expectAll(shapes::icosahedron());
    std::fill_n(points.begin(), 10'000, Point3{5, 5, 5});
    expectAll(shapes::box({.cells = {2, 2, 2}}));
}

TEST(LocalBinding, DoesNotDependOnTheNumberOfThreads) {
    if (kIsSlow) GTEST_SKIP() << "takes minutes here; run without sanitizers";
    const Lattice lattice = shapes::torus();
    const TopologyRefiner base(lattice.complex);
    const WholeLevelBinding whole(base, lattice.positions, 1, {}, {});
    // Level 4 has more cells than points.
    const auto points = somePoints(lattice.positions, whole, 1, 17'000, 2);
    const auto bind = [&] {
        return bindPoints({base, lattice.positions}, points,
                          {.level = 4, .embedding = {.outside = OutsidePolicy::Nearest}});
    };
    const auto one = withThreads(1, bind), three = withThreads(3, bind);
    EXPECT_EQ(one.statuses, three.statuses);
    EXPECT_TRUE(one.table == three.table);
    EXPECT_EQ(one.table.emptyRows(), three.table.emptyRows());
    const auto bindInFactors = [&] {
        return bindFactored({base, lattice.positions}, points,
                            {.level = 4, .embedding = {.outside = OutsidePolicy::Nearest}});
    };
    EXPECT_TRUE(withThreads(1, bindInFactors).table == withThreads(3, bindInFactors).table);
}

// The whole level would not fit in memory: 8⁸ · 20 cells. The levels of 600 points at once would
// take 300 MB.
TEST(LocalBinding, BindsAtLevelEight) {
    const Lattice lattice = shapes::icosahedron();
    const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    const auto rest = bent(lattice.positions, 0.02);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-0.4, 0.4);
    std::vector<Point3> points(kIsSlow ? 3 : 600);
    for (Point3& point : points) point = {unit(random), unit(random), unit(random)};
    std::optional<MemoryLimit> limit;
    if (!kIsSlow) limit.emplace(residentMemory() + 200'000'000);
    const auto bound = bindPoints({base, rest}, points, {.level = 8});
    EXPECT_EQ(bound.count(PointStatus::Inside), static_cast<Index>(points.size()));
    // At rest, D reproduces the points.
    const auto back = stencils::applyLevelTable(bound.table, rest);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            // The rounding of about a thousand products, and of the solve.
            EXPECT_NEAR(back[i][c], points[i][c], 1e-12);
}

// Squares and second differences may overflow or underflow.
TEST(LocalBinding, LatticesOfExtremeSize) {
    const Lattice lattice = shapes::box({.cells = {3, 2, 2}});
    const TopologyRefiner base(lattice.complex);
    for (const double size : {1e-200, 1e-20, 1e20, 1e200, 5e307}) {
        auto rest = bent(lattice.positions, 0.02);
        std::vector<Point3> points = {{0.3, 0.4, 0.5}, {0.9, 0.2, 0.7}, {0.5, 0.5, 2}};
        for (auto* all : {&rest, &points})
            for (Point3& point : *all)
                for (double& coordinate : point) coordinate *= size;
        for (const OutsidePolicy outside : {OutsidePolicy::Keep, OutsidePolicy::Nearest}) {
            const EmbeddingOptions options{.outside = outside};
            TopologyRefiner whole(base);
            whole.refineUniform(2);
            const PointLocator locator(whole.level(2).complex,
                                       stencils::refinePositions(whole, 2, rest),
                                       CellSolver::scaleOf(rest, options.tolerance));
            // By formula, and by refinement.
            const auto bound = bindPoints({base, rest}, points, {.level = 2, .embedding = options});
            const auto factored =
                bindFactored({base, rest}, points, {.level = 2, .embedding = options});
            for (std::size_t i = 0; i < points.size(); ++i) {
                const PointStatus expected =
                    locator.locate(points[i], outside == OutsidePolicy::Nearest).status;
                EXPECT_EQ(bound.statuses[i], expected) << size << " point " << i;
                EXPECT_EQ(factored.statuses[i], expected) << size << " point " << i;
            }
        }
    }
}

// Coordinates are rounded by more than any fraction of the size that could serve as a margin of
// boxes.
TEST(LocalBinding, FarFromTheOrigin) {
    const Lattice lattice = shapes::box({.cells = {2, 2, 2}});
    const TopologyRefiner base(lattice.complex);
    // Not bent: otherwise, the bounds of descendants would have larger margins than rounding needs.
    auto rest = lattice.positions;
    for (Point3& position : rest) position[0] = 1e9 + position[0] / 3;
    const WholeLevelBinding whole(base, rest, 2, {}, {.tolerance = 0});
    // Points on the vertices of the level, where boxes are tightest.
    const EmbeddingOptions options{.tolerance = 0};
    const WholeLevelBinding expected(base, rest, 2, whole.positions, options);
    // Fewer points than cells, so that binding refines parts of the level.
    for (std::size_t first = 0; first < whole.positions.size(); first += 100) {
        const auto some =
            std::span(whole.positions)
                .subspan(first, std::min<std::size_t>(100, whole.positions.size() - first));
        // By formula, and by refinement.
        const auto bound = bindPoints({base, rest}, some, {.level = 2, .embedding = options});
        const auto factored = bindFactored({base, rest}, some, {.level = 2, .embedding = options});
        for (std::size_t i = 0; i < some.size(); ++i) {
            EXPECT_EQ(bound.statuses[i], expected.embedding.points[first + i].status);
            EXPECT_EQ(factored.statuses[i], expected.embedding.points[first + i].status);
        }
    }
}

TEST(LocalBinding, ThrowsIfNoCellIsLeftWithoutBoundaryControl) {
    const Lattice lattice = shapes::box({.cells = {1, 3, 3}});
    const TopologyRefiner base(lattice.complex, {.boundary = Boundary::Open});
    const std::vector<Point3> points = {{0.5, 0.5, 0.5}, {2, 2, 2}};
    for (const OutsidePolicy outside : {OutsidePolicy::Keep, OutsidePolicy::Nearest})
        EXPECT_THROW(bindPoints({base, lattice.positions}, points,
                                {.level = 3, .embedding = {.outside = outside}}),
                     far::TopologyError);
}

TEST(LocalBinding, RefusesInvalidInput) {
    const Lattice lattice = shapes::box();
    TopologyRefiner base(lattice.complex);
    const std::vector<Point3> points = {{0.5, 0.5, 0.5}, {2, 0, 0}};
    const auto expectRefused = [&](const std::string& why, const TopologyRefiner& refiner,
                                   std::span<const Point3> rest, int level,
                                   OutsidePolicy outside = OutsidePolicy::Keep) {
        EXPECT_REFUSED(Error, why,
                       bindPoints({refiner, rest}, points,
                                  {.level = level, .embedding = {.outside = outside}}));
    };
    expectRefused("level: expected 1 to 20 to bind points, got 0", base, lattice.positions, 0);
    expectRefused("level: expected 1 to 20 to bind points, got 21", base, lattice.positions, 21);
    expectRefused("positions", base, std::span(lattice.positions).first(7), 1);
    expectRefused("point 1", base, lattice.positions, 1, OutsidePolicy::Error);
    auto bad = lattice.positions;
    bad[3][1] = kNan;
    expectRefused("vertex 3", base, bad, 1);
    base.refineUniform(1);
    expectRefused("has not been refined", base, lattice.positions, 1);
    expectRefused("dimension 2", TopologyRefiner(gridMesh(2, 2)), {}, 1);
    const auto none =
        bindPoints({TopologyRefiner(lattice.complex), lattice.positions}, {}, {.level = 1});
    EXPECT_EQ(none.table.rowCount(), 0);
    EXPECT_EQ(none.table.columnCount(), 8);
}

// Beside the middle of a face of a box, the tangent is u -> P0 + u (P1 - P0) on every level, and
// the weights along the face are positive. So the weights of a point k cells away sum to 1 + 2k in
// absolute value, and the bound of 8 is at 3.5 cells. A point farther away stays, up to the
// distance at which no cell is nearer than another, and beyond.
TEST(LocalBinding, CarriesPointsUpToTheBoundOfRows) {
    const Lattice lattice = shapes::box({.cells = {10, 10, 10}});
    const TopologyRefiner base(lattice.complex);
    for (const int level : {1, 5, 7}) {
        std::vector<Point3> points;
        const std::vector<double> distances = {0.5, 3.49, 3.51, 100, 1e5, 1e7, 2e8, 1e300};
        for (const double cells : distances) points.push_back({0.45, 0.52, 1 + cells / 10});
        const BindingOptions options = {.level = level,
                                        .embedding = {.outside = OutsidePolicy::Nearest}};
        const auto model = bindPoints({base, lattice.positions}, points, options);
        EXPECT_EQ(model.count(PointStatus::Outside), std::ssize(points)) << level;
        EXPECT_THAT(model.table.emptyRows(), testing::ElementsAre(2, 3, 4, 5, 6, 7)) << level;
        for (const Index point : {0, 1}) {
            double sum = 0;
            for (const double weight : model.table.weights(point)) sum += std::abs(weight);
            // The rounding of about a hundred weights.
            EXPECT_NEAR(sum, 1 + 2 * distances[point], 1e-13) << level;
        }
        EXPECT_LT(model.largestResidual, 1e-12) << level;
        const auto factored = bindFactored({base, lattice.positions}, points, options);
        EXPECT_EQ(factored.table.points.emptyRows(), model.table.emptyRows()) << level;
    }
}

}  // namespace
}  // namespace espalier::embed
