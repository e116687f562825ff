// SPDX-License-Identifier: Apache-2.0
#include "osd/device/spline_rows.h"

#include <espalier/embed/tensor_product.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/shapes/inventory.h>

#include "bound_table.h"
#include "host_device.h"
#include "osd/device/spline_weights.h"
#include "sums.h"
#include "support/test.h"

// Tests rows without a table: the kernels of GPUs compute their weights from three parameters. The
// kernels run on the host; cuda_evaluator_test.cpp tests that a device gives the same bits.
namespace espalier::osd {
namespace {

using stencils::StencilTable;

/// Returns the weights of level-n vertices along one axis by subdivision: of all vertices of a
/// cell, with one more on each side.
/// \param size 4: inside; 3: a phantom 2P₀ − P₁ before the first column; 2: also after the last
std::vector<std::array<double, 4>> subdivided(Index size, int level) {
    using Weights = std::array<double, 4>;
    const auto sum = [](double p, const Weights& a, double q, const Weights& b) {
        Weights result;
        for (std::size_t k = 0; k < 4; ++k) result[k] = p * a[k] + q * b[k];
        return result;
    };
    std::vector<Weights> points;
    for (Index k = 0; k < size; ++k) {
        points.push_back({});
        points.back()[k] = 1;
    }
    if (size < 4) points.insert(points.begin(), sum(2, points[0], -1, points[1]));
    if (size < 3) points.push_back(sum(2, points[2], -1, points[1]));
    for (int n = 0; n < level; ++n) {
        std::vector<Weights> finer;
        for (std::size_t i = 0; i + 1 < points.size(); ++i) {
            if (i > 0)
                finer.push_back(
                    sum(0.75, points[i], 0.125, sum(1, points[i - 1], 1, points[i + 1])));
            finer.push_back(sum(0.5, points[i], 0.5, points[i + 1]));
        }
        points = finer;
    }
    return points;
}

template <class Real>
class SplineRows : public ::testing::Test {};
TYPED_TEST_SUITE(SplineRows, Reals);

// At level-n vertices, and halfway between them, the weights are those of subdivision; in the
// limit, those of the mask (1, 4, 1) / 6 of subdivided vertices.
TYPED_TEST(SplineRows, HaveTheWeightsOfSubdivision) {
    using Real = TypeParam;
    // Each weight is at most 1 and has at most 16 roundings.
    const double bound = 8 * std::numeric_limits<Real>::epsilon();
    for (const Index size : {4, 3, 2})
        for (const int level : {1, 2, 5, 10}) {
            const auto points = subdivided(size, level);
            const int segments = 1 << level;
            for (int j = 0; j <= segments; ++j) {
                const auto &before = points[j], &own = points[j + 1], &after = points[j + 2];
                const Real t = Real(j) / Real(segments) - Real(0.5);
                const Real middle = t + Real(0.5) / Real(segments);
                Real level_[4], limit[4], between[4];
                device::splineWeights(level, size, t, level_);
                device::splineWeights(device::kLimitSpline, size, t, limit);
                device::splineWeights(level, size, middle, between);
                for (std::size_t k = 0; k < 4; ++k) {
                    EXPECT_NEAR(level_[k], own[k], bound) << level << ' ' << j;
                    EXPECT_NEAR(limit[k], (before[k] + 4 * own[k] + after[k]) / 6, bound);
                    if (j < segments) {
                        EXPECT_NEAR(between[k], (own[k] + after[k]) / 2, bound) << level << j;
                    }
                }
            }
        }
}

/// Returns points in the unit box: random ones, and for each a point that is moved to a face, an
/// edge or a corner of its cell, where parameters are −½ or ½.
std::vector<Point3> pointsInCells(const std::array<int, 3>& cells, int count) {
    const auto random = randomValues(std::size_t(count) * 6, 7);
    std::vector<Point3> points;
    for (std::size_t i = 0; i < random.size(); i += 6) {
        Point3 point;
        for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = 0.5 + random[i + axis] / 2;
        points.push_back(point);
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (random[i + 3 + axis] > 0)
                point[axis] = std::round(point[axis] * cells[axis]) / cells[axis];
        points.push_back(point);
    }
    return points;
}

/// Returns D of such points, in the limit (level 0) or on a level.
template <class Real>
StencilTable<Real> splineTable(const std::array<int, 3>& cells, int level, int count) {
    const Lattice box = shapes::box({.cells = {cells[0], cells[1], cells[2]}});
    const TopologyRefiner base(box.complex, {.marks = box.marks});
    const auto points = pointsInCells(cells, count);
    const embed::RestLattice lattice = {base, box.positions};
    return stencils::convertTable<Real>(
        level == 0 ? limit::bindLimit(lattice, points).table
                   : embed::bindPoints(lattice, points, {.level = level}).table);
}

/// Returns the largest error of packed results of three components, relative to table · source in
/// long double, in units of ε · max |x| over the columns of the row; or of ε · Σ |x|, if `isSum`.
template <class Real>
double errorOf(const StencilTable<Real>& table, std::span<const Real> source,
               std::span<const Real> result, bool isSum) {
    long double largest = 0;
    for (Index row = 0; row < table.rowCount(); ++row)
        for (Index c = 0; c < 3; ++c) {
            long double sum = 0, size = 0;
            for (std::size_t k = 0; k < table.columns(row).size(); ++k) {
                const long double x = source[table.columns(row)[k] * 3 + c];
                sum += table.weights(row)[k] * x;
                size = isSum ? size + std::abs(x) : std::max(size, std::abs(x));
            }
            const long double error = std::abs(result[row * 3 + c] - sum);
            if (!(error <= 0)) largest = std::max(largest, error / size);
        }
    return double(largest / std::numeric_limits<Real>::epsilon());
}

/// Returns D of the uniform B-spline of a box of 4³ cells, whose region is its 2³ inner cells.
template <class Real>
StencilTable<Real> tensorTable(int count) {
    const Lattice box = shapes::box({.cells = {4, 4, 4}});
    const embed::TensorLattice lattice(box.complex, box.positions, embed::Basis::BSpline);
    auto points = pointsInCells({2, 2, 2}, count);
    for (Point3& point : points)
        for (double& x : point) x = 0.25 + x / 2;
    return stencils::convertTable<Real>(
        embed::buildDeformationTable(lattice, embed::embedPoints(lattice, points)));
}

/// Compares results and adjoints with the table.
/// \param spline the kind of its rows
template <class Real>
void expectTable(const StencilTable<Real>& table, Index spline) {
    const auto xyz = BufferDescriptor::packed(3);
    const HostDevice<Real> device(table, true, true);
    // Fewer rows than fill a panel keep their factors, as on some edges and corners.
    EXPECT_GT(device.arrays().parametricRowCount, 0.7 * table.rowCount());
    for (const auto& group : device.arrays().groups)
        EXPECT_TRUE(group.spline == device::kNoSpline || group.spline == spline);
    const auto pose = randomValues<Real>(table.columnCount() * 3, 1);
    std::vector<Real> points(table.rowCount() * 3);
    device.evaluate(pose, xyz, points, xyz, {0, table.rowCount()});
    // The guaranteed bound is 64; docs/gpu.md says that the tests stay below 4.
    EXPECT_LE(errorOf<Real>(table, pose, points, false), 4);
    EXPECT_GE(errorOf<Real>(table, pose, points, false), 0.1);
    // A part of the rows, to a destination with gaps.
    const RowRange some{table.rowCount() / 3, table.rowCount() / 2};
    std::vector<Real> part(some.last * 4, 99);
    device.evaluate(pose, xyz, part, {0, 3, 4}, some);
    for (Index row = 0; row < some.last; ++row)
        for (Index c = 0; c < 4; ++c)
            ASSERT_EQ(part[row * 4 + c],
                      row >= some.first && c < 3 ? points[row * 3 + c] : Real(99));

    const auto gradients = randomValues<Real>(table.rowCount() * 3, 2);
    std::vector<Real> back(table.columnCount() * 3);
    device.evaluateAdjoint(gradients, xyz, back, xyz, {0, table.columnCount()});
    // 8 for the weights; sums of a few hundred random terms are far below their bound.
    EXPECT_LE(errorOf<Real>(stencils::transposeTable(table), gradients, back, true), 14);
}

// Covers cells inside (4 columns along an axis), at a boundary (3) and at two (2).
TYPED_TEST(SplineRows, EqualTheTableUpToRounding) {
    using Real = TypeParam;
    for (const auto& [cells, level] : std::vector<std::pair<std::array<int, 3>, int>>{
             {{4, 3, 2}, 0}, {{4, 3, 2}, 1}, {{3, 2, 1}, 3}}) {
        SCOPED_TRACE(level);
        expectTable<Real>(splineTable<Real>(cells, level, 1500), level);
    }
    expectTable<Real>(tensorTable<Real>(1000), device::kLimitSpline);
}

// The rounding of a coefficient grows with the differences of columns, which are largest if their
// signs alternate.
TYPED_TEST(SplineRows, AreExactForAlternatingColumns) {
    using Real = TypeParam;
    const auto xyz = BufferDescriptor::packed(3);
    const std::array<int, 3> cells = {4, 4, 4};
    const Lattice box = shapes::box({.cells = {4, 4, 4}});
    for (const int level : {0, 1, 3}) {
        const auto table = splineTable<Real>(cells, level, 4000);
        std::vector<Real> pose;
        for (const Point3& p : box.positions) {
            const auto at = [&](std::size_t axis) { return std::lround(4 * p[axis]); };
            // All axes, two, and one; not exactly 1, so that sums are rounded.
            for (const long parity : {at(0) + at(1) + at(2), at(0) + at(1), at(0)})
                pose.push_back(Real(parity % 2 == 0 ? 1 : -1) *
                               (1 - Real(0.1) * std::abs(Real(std::sin(double(pose.size()))))));
        }
        const HostDevice<Real> device(table, true, true);
        std::vector<Real> points(table.rowCount() * 3);
        device.evaluate(pose, xyz, points, xyz, {0, table.rowCount()});
        EXPECT_LE(errorOf<Real>(table, pose, points, false), 4) << level;
    }
}

// Rows that are no spline keep their factors or weights, and give the same bits as before.
TYPED_TEST(SplineRows, LeaveOtherRowsAsTheyAre) {
    using Real = TypeParam;
    const auto cylinder = boundTable<Real>(shapes::cylinder({.sectors = 5}));
    const Lattice box = shapes::box({.cells = {3, 3, 3}});
    const TopologyRefiner base(box.complex, {.marks = box.marks});
    const auto bound =
        limit::bindLimit({base, box.positions}, pointsInCells({3, 3, 3}, 500), {.gradients = true});
    const auto gradients = stencils::convertTable<Real>(
        embed::gradientTables(*bound.gradients, box.positions, bound.table.rowCount())[0]);
    for (const StencilTable<Real>* table : {&cylinder, &gradients}) {
        const HostDevice<Real> device(*table, true, true), before(*table, true);
        EXPECT_EQ(device.arrays().parametricRowCount, 0);
        EXPECT_EQ(device.arrays().groupRows, before.arrays().groupRows);
        EXPECT_EQ(device.arrays().groupColumns, before.arrays().groupColumns);
        EXPECT_EQ(device.arrays().groupNumbers, before.arrays().groupNumbers);
    }
}

// Points outside have rows without entries, which form groups without numbers.
TYPED_TEST(SplineRows, FollowRowsWithoutEntries) {
    using Real = TypeParam;
    const auto xyz = BufferDescriptor::packed(3);
    const auto table = splineTable<Real>({3, 3, 3}, 0, 500);
    constexpr Index kEmpty = 40;
    Array<Offset> offsets(kEmpty, 0);
    offsets.insert(offsets.end(), table.offsets().begin(), table.offsets().end());
    const StencilTable<Real> longer(table.columnCount(), std::move(offsets),
                                    Array<Index>(table.columns().begin(), table.columns().end()),
                                    Array<Real>(table.weights().begin(), table.weights().end()));
    const HostDevice<Real> device(longer, true, true), shorter(table, true, true);
    EXPECT_EQ(device.arrays().parametricRowCount, shorter.arrays().parametricRowCount);
    const auto pose = randomValues<Real>(table.columnCount() * 3, 1);
    std::vector<Real> points(longer.rowCount() * 3, 99), expected(table.rowCount() * 3);
    device.evaluate(pose, xyz, points, xyz, {0, longer.rowCount()});
    shorter.evaluate(pose, xyz, expected, xyz, {0, table.rowCount()});
    expected.insert(expected.begin(), kEmpty * 3, 0);
    EXPECT_EQ(points, expected);

    const StencilTable<Real> empty(8, Array<Offset>(kEmpty + 1, 0), {}, {});
    const HostDevice<Real> none(empty, true, true);
    std::vector<Real> zeros(kEmpty * 3, 99);
    none.evaluate(randomValues<Real>(24, 1), xyz, zeros, xyz, {0, kEmpty});
    EXPECT_EQ(zeros, std::vector<Real>(kEmpty * 3, 0));
}

// In a group of splines, each seventh row has a weight that is off by 20 ε. It keeps its factors,
// and is as exact as they are.
TYPED_TEST(SplineRows, KeepFactorsOfRowsThatDiffer) {
    using Real = TypeParam;
    constexpr Index kRows = 210;
    constexpr Real epsilon = std::numeric_limits<Real>::epsilon();
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    for (Index row = 0; row < kRows; ++row) {
        double factors[3][4];
        for (int axis = 0; axis < 3; ++axis)
            device::splineWeights(device::kLimitSpline, 4,
                                  randomValues(1, unsigned(row * 3 + axis))[0] / 2, factors[axis]);
        if (row % 7 == 3) factors[0][1] += 20 * double(epsilon);
        for (Index k = 0; k < 64; ++k) {
            columns.push_back(k);
            weights.push_back(Real(factors[0][k % 4] * factors[1][k / 4 % 4] * factors[2][k / 16]));
        }
        offsets.push_back(Offset(columns.size()));
    }
    const StencilTable<Real> table(64, offsets, columns, weights);
    const HostDevice<Real> device(table, true, true);
    EXPECT_EQ(device.arrays().parametricRowCount, kRows - kRows / 7);
    EXPECT_EQ(std::ssize(device.arrays().groupRows), kRows);
    const auto pose = randomValues<Real>(64 * 3, 1);
    std::vector<Real> points(kRows * 3), factorized(points.size());
    const auto xyz = BufferDescriptor::packed(3);
    device.evaluate(pose, xyz, points, xyz, {0, kRows});
    HostDevice<Real>(table, true).evaluate(pose, xyz, factorized, xyz, {0, kRows});
    EXPECT_LE(errorOf<Real>(table, pose, points, false), 14);
    for (Index row = 3; row < kRows; row += 7)
        for (Index c = 0; c < 3; ++c)
            EXPECT_EQ(points[row * 3 + c], factorized[row * 3 + c]) << row;
}

}  // namespace
}  // namespace espalier::osd
