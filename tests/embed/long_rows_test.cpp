// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/embed/local_binding.h>
#include <espalier/shapes/inventory.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/sparse_matrix.h>

#include <Eigen/Core>
#include <atomic>

#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/test.h"
#include "support/zoo.h"

// Binds points in cells of very many faces, whose rows of D are very long.
namespace espalier::embed {
namespace {

// Around a cell with very many faces, rows of D are carried from the points to the base. Up to
// rounding, they are equal to the rows of the product of W and S. Rows that are computed from a
// part of a level are equal to the rows from the whole level, to the last bit.
TEST(LongRows, CellsWithManyFaces) {
    const Lattice lattice = shapes::prism({.sides = 300});
    const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    TopologyRefiner whole = base;
    whole.refineUniform(2);
    const auto positions = stencils::refinePositions(whole, 2, lattice.positions);
    std::vector<Point3> points;
    for (std::size_t i = 0; i < positions.size(); i += 400) points.push_back(positions[i]);
    const Embedding embedding = embedPoints(whole.level(2).complex, positions, points);
    const auto table = buildDeformationTable(whole, 2, embedding);
    const auto model = bindPoints({base, lattice.positions}, points, {.level = 2});
    EXPECT_TRUE(model.table == table);
    const auto product = stencils::multiply(buildEmbeddingTable(whole.level(2).complex, embedding),
                                            stencils::buildStencils(whole, 2));
    const Eigen::MatrixXd difference =
        Eigen::MatrixXd(stencils::SparseView<double>(table).matrix()) -
        Eigen::MatrixXd(stencils::SparseView<double>(product).matrix());
    EXPECT_LT(difference.lpNorm<Eigen::Infinity>(), 1e-15);
    EXPECT_GT(table.columns(table.rowCount() - 1).size(), 500U);
}

/// Returns points on a spiral in the prism of radius 1 and height 1 around the origin, scaled by
/// `scale`, 1 or less.
std::vector<Point3> spiral(int count, double scale) {
    std::vector<Point3> points;
    for (int i = 0; i < count; ++i) {
        const double part = (i + 0.5) / count;
        points.push_back({scale * 0.9 * part * std::cos(i), scale * 0.9 * part * std::sin(i),
                          scale * (0.9 * part - 0.45)});
    }
    return points;
}

// Each row of D contains all 600 vertices of the cell. D of 20,000 points takes 144 MB, and the
// same again while the rows of the groups are gathered.
TEST(LongRows, RefusesLongRowsBeforeTheyAreComputed) {
    const Lattice lattice = shapes::prism({.sides = 300});
    const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    const auto bind = [&](std::span<const Point3> points, std::atomic<int>& groups) {
        return bindPoints({base, lattice.positions}, points,
                          {.level = 2, .progress = [&](Offset) { ++groups; }});
    };
    const MemoryLimit limit(residentMemory() + 150'000'000);
    std::atomic<int> groups = 0;
    EXPECT_THAT(
        messageOf<MemoryError>([&] { bind(spiral(20'000, 1), groups); }),
        ::testing::MatchesRegex("binding 20000 points with some 600 weights each takes about "
                                "2[0-9][0-9]\\.. MB of memory; the limit is .* are in use"));
    EXPECT_EQ(groups, 0) << "points were bound before";
}

// Some three quarters of the points have rows, of all 600 vertices. The memory is estimated from a
// sample of 64 points, so low that it is too high only once in a million times: by Chernoff's
// bound, 64 · D(p ‖ q) = ln(10⁶) for the parts p of the sample and q of all points that have rows.
TEST(LongRows, EstimatesRowsFromASample) {
    const Lattice lattice = shapes::prism({.sides = 300});
    const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    std::vector<Point3> points = spiral(20'000, 1);
    for (std::size_t i = 0; i < points.size(); i += 4) points[i][2] += 5;  // outside
    const MemoryLimit limit(residentMemory() + 80'000'000);
    const std::string message = messageOf<MemoryError>([&] {
        bindPoints({base, lattice.positions}, points, {.level = 2});
    });
    int weights = 0;
    double megabytes = 0;
    ASSERT_EQ(std::sscanf(message.c_str(),
                          "binding 20000 points with some %d weights each takes about %lf MB",
                          &weights, &megabytes),
              2)
        << message;
    const double p = std::round(weights * 64 / 600.) / 64, q = megabytes / (20'000 * 600 * 24e-6);
    EXPECT_NEAR(p, 0.75, 0.15);
    // q is rounded by 2e-4, which changes the sum by 0.02.
    EXPECT_NEAR(64 * (p * std::log(p / q) + (1 - p) * std::log((1 - p) / (1 - q))), std::log(1e6),
                0.05);
}

// The upper bound from the lattice alone is far larger than D.
TEST(LongRows, AcceptsShortRowsBesideLongOnes) {
    if (kIsSlow) GTEST_SKIP() << "memory that is free is held by the sanitizer";
    const Lattice lattice = shapes::prism({.sides = 300});
    const TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    std::vector<Point3> points = spiral(20'000, 1);
    for (std::size_t i = 0; i < points.size(); ++i)
        if (i % 40 != 0) points[i][2] += 5;  // outside, without a row
    const auto bind = [&] { return bindPoints({base, lattice.positions}, points, {.level = 2}); };
    const auto without = bind();
    EXPECT_EQ(without.count(PointStatus::Inside), 500);
    const MemoryLimit limit(residentMemory() + 150'000'000);
    EXPECT_TRUE(bind() == without);
}

}  // namespace
}  // namespace espalier::embed
