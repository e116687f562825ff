// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>

#include <tuple>

#include "bound_table.h"
#include "host_device.h"
#include "sums.h"
#include "support/sanitizers.h"
#include "support/test.h"

// Tests the kernels of GPUs on the host, with real tables. evaluator_test.cpp tests the contract,
// and cuda_evaluator_test.cpp that a device gives the same bits.
namespace espalier::osd {
namespace {

using stencils::StencilTable;

template <class Real>
class DeviceKernels : public ::testing::Test {
protected:
    static std::vector<Real> evaluated(const HostDevice<Real>& device, Index rowCount,
                                       std::span<const Real> source, Offset length) {
        std::vector<Real> result(rowCount * length, 99);
        const auto layout = BufferDescriptor::packed(length);
        device.evaluate(source, layout, result, layout, {0, rowCount});
        return result;
    }

    static std::vector<Real> adjointOf(const HostDevice<Real>& device, Index columnCount,
                                       std::span<const Real> source, Offset length) {
        std::vector<Real> result(columnCount * length, 99);
        const auto layout = BufferDescriptor::packed(length);
        device.evaluateAdjoint(source, layout, result, layout, {0, columnCount});
        return result;
    }
};
TYPED_TEST_SUITE(DeviceKernels, Reals);

// Covers outer products of 4 × 4 × 4 and, at boundaries, smaller ones; panels; and ungrouped rows.
// 7 components are split into 4 and 3; 12 go through panels in one pass; 26 are 12, 12 and 2.
TYPED_TEST(DeviceKernels, EvaluateTablesAndTheirTransposes) {
    using Real = TypeParam;
    for (const Lattice& lattice :
         {shapes::box({.cells = {4, 3, 3}}), shapes::cylinder({.sectors = 5}), shapes::box()}) {
        // Fewer points than by default: the kernels are not optimized here. The box of
        // one cell has groups with several tasks, also with these few points.
        const auto table = boundTable<Real>(lattice, 1500);
        const auto transpose = stencils::transposeTable(table);
        for (const bool isGrouped : {true, false}) {
            const HostDevice<Real> device(table, isGrouped);
            EXPECT_EQ(device.arrays().groups.empty(), !isGrouped);
            if (isGrouped && lattice.complex.count(3) == 1) {
                std::size_t tasks = device.arrays().panels.size();
                for (const auto& list : device.arrays().products) tasks += list.size();
                EXPECT_GT(tasks, device.arrays().groups.size());
            }
            for (const Offset length : someOf<Offset>({3, 1, 7, 12, 26})) {
                const auto poses = randomValues<Real>(table.columnCount() * length, 6);
                EXPECT_LE(
                    errorOfSums<Real>(table, poses, length,
                                      this->evaluated(device, table.rowCount(), poses, length)),
                    20);  // rows have about 64 entries, for which the promise is 68
                const auto gradients = randomValues<Real>(table.rowCount() * length, 7);
                EXPECT_LE(errorOfSums<Real>(
                              transpose, gradients, length,
                              this->adjointOf(device, table.columnCount(), gradients, length)),
                          20);
            }
        }
    }
}

/// Returns rows over all columns that are outer products of random factors.
template <class Real>
StencilTable<Real> productTable(const std::array<Index, 3>& size, Index rowCount) {
    const Index columnCount = size[0] * size[1] * size[2];
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    for (Index row = 0; row < rowCount; ++row) {
        std::array<std::vector<double>, 3> factors;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto seed = unsigned(row) * 3 + unsigned(axis);
            factors[axis] = randomValues(size[axis], seed);
            for (double& factor : factors[axis]) factor = 1 + factor / 2;
        }
        for (Index k = 0; k < columnCount; ++k) {
            columns.push_back(k);
            weights.push_back(Real(factors[0][k % size[0]] * factors[1][k / size[0] % size[1]] *
                                   factors[2][k / size[0] / size[1]]));
        }
        offsets.push_back(Offset(columns.size()));
    }
    return {columnCount, std::move(offsets), std::move(columns), std::move(weights)};
}

// Each size up to 4 has its own kernel. Larger sizes share a kernel, and their last tiles are
// partly empty.
TYPED_TEST(DeviceKernels, EvaluateOuterProductsOfAnySize) {
    using Real = TypeParam;
    for (const auto& [size, kernel] :
         std::vector<std::pair<std::array<Index, 3>, std::size_t>>{{{4, 4, 4}, 0},
                                                                   {{4, 3, 2}, 0},
                                                                   {{4, 4, 1}, 0},
                                                                   {{3, 3, 3}, 1},
                                                                   {{3, 2, 1}, 1},
                                                                   {{2, 2, 2}, 2},
                                                                   {{6, 5, 4}, 3},
                                                                   {{5, 2, 1}, 3},
                                                                   {{9, 3, 3}, 3}}) {
        const auto table = productTable<Real>(size, 300);
        const HostDevice<Real> device(table, true);
        // A task has 128 rows in float, and 64 in double.
        EXPECT_EQ(device.arrays().products[kernel].size(), sizeof(Real) == 4 ? 3U : 5U);
        const auto pose = randomValues<Real>(table.columnCount() * 3, 1);
        EXPECT_LE(
            errorOfSums<Real>(table, pose, 3, this->evaluated(device, table.rowCount(), pose, 3)),
            20);
        const auto gradients = randomValues<Real>(table.rowCount() * 3, 2);
        EXPECT_LE(errorOfSums<Real>(stencils::transposeTable(table), gradients, 3,
                                    this->adjointOf(device, table.columnCount(), gradients, 3)),
                  20);
    }
}

// Column 0 is in 1,100 groups of rows and in 3,000 ungrouped rows, so its sums need two steps.
TYPED_TEST(DeviceKernels, SumLongColumnsInSteps) {
    using Real = TypeParam;
    constexpr Index kGroups = 1100, kRowsPerGroup = 16, kUngrouped = 3000;
    Array<Offset> offsets = {0};
    Array<Index> columns;
    for (Index group = 0; group < kGroups; ++group)
        for (Index row = 0; row < kRowsPerGroup; ++row) {
            columns.insert(columns.end(), {0, 2 * group + 1, 2 * group + 2});
            offsets.push_back(Offset(columns.size()));
        }
    for (Index row = 0; row < kUngrouped; ++row) {
        columns.insert(columns.end(), {0, 2 * kGroups + row + 1});
        offsets.push_back(Offset(columns.size()));
    }
    const auto random = randomValues<Real>(Offset(columns.size()), 3);
    const StencilTable<Real> table(2 * kGroups + kUngrouped + 1, offsets, columns,
                                   {random.begin(), random.end()});
    const HostDevice<Real> device(table, true);
    EXPECT_EQ(device.arrays().groups.size(), std::size_t{kGroups});
    EXPECT_EQ(device.adjointArrays().segments.count(), 3 + kUngrouped);
    EXPECT_EQ(device.adjointArrays().steps.size(), 2U);
    const auto gradients = randomValues<Real>(table.rowCount(), 4);
    EXPECT_LE(errorOfSums<Real>(stencils::transposeTable(table), gradients, 1,
                                this->adjointOf(device, table.columnCount(), gradients, 1)),
              20);
}

// The warps of a block together have no more shared memory than any block may have. If they need
// little or none, a block has as many warps as it may have.
TEST(DeviceBlocks, FitTheSharedMemoryOfTheirWarps) {
    using device::blocksOf;
    device::ProductKernel<0, false, 4, double> largest = {};
    largest.maxColumns = kernels::kMaxProductColumns;
    largest.components.count = 1;
    for (const unsigned shared :
         {largest.sharedBytes(), device::ProductKernel<4, false, 3, float>{}.sharedBytes(),
          device::PanelKernel<12, double>{}.sharedBytes(), 0U}) {
        EXPECT_EQ(shared % 16, 0U);
        for (const Index warps : {1, 4, 5, 1'000'000}) {
            const device::Blocks blocks = blocksOf(warps, shared);
            EXPECT_LE(blocks.warps * shared, device::kMaxShared);
            EXPECT_GE(blocks.count * blocks.warps, unsigned(warps));
            EXPECT_LT((blocks.count - 1) * blocks.warps, unsigned(warps));
        }
    }
    EXPECT_EQ(blocksOf(10, 0).warps, 4U);
    EXPECT_EQ(blocksOf(10, 4000).warps, 4U);
    EXPECT_EQ(blocksOf(10, largest.sharedBytes()).warps, 2U);
}

// A row of a regular region stores 12 factors, or 3 parameters, and its row number on the device,
// plus a little for each group.
TYPED_TEST(DeviceKernels, StoreTwelveOrThreeNumbersForARegularRow) {
    using Real = TypeParam;
    const auto table = boundTable<Real>(shapes::box({.cells = {3, 3, 3}}), 20'000);
    for (const auto& [hasParameters, numbers, more] :
         {std::tuple{false, std::size_t{12}, 1.15}, std::tuple{true, std::size_t{3}, 1.25}}) {
        const device::TableArrays<Real> arrays(table, true, hasParameters);
        const std::size_t bytes = arrays.groupNumbers.size() * sizeof(Real) +
                                  arrays.groupRows.size() * sizeof(Index) +
                                  arrays.groupColumns.size() * sizeof(Index);
        EXPECT_LT(double(bytes), more * double(numbers * sizeof(Real) + sizeof(Index)) * 20'000);
    }
}

}  // namespace
}  // namespace espalier::osd
