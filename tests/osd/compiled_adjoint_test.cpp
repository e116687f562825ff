// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>

#include <array>
#include <random>

#include "bound_table.h"
#include "sums.h"
#include "support/test.h"
#include "support/threads.h"

// Tests real tables. evaluator_test.cpp tests the contract.
namespace espalier::osd {
namespace {

template <class Real>
class CompiledAdjointTest : public ::testing::Test {};
TYPED_TEST_SUITE(CompiledAdjointTest, Reals);

TYPED_TEST(CompiledAdjointTest, EqualsProductsWithTheTranspose) {
    using Real = TypeParam;
    // Outer products and panels; panels and ungrouped rows; a few groups of very many rows.
    for (const Lattice& lattice :
         {shapes::box({.cells = {4, 3, 3}}), shapes::cylinder({.sectors = 5}), shapes::box()}) {
        const auto table = boundTable<Real>(lattice);
        const auto transpose = stencils::transposeTable(table);
        const CompiledAdjoint<Real> adjoint(table);
        EXPECT_EQ(adjoint.rowCount(), table.columnCount());
        EXPECT_EQ(adjoint.columnCount(), table.rowCount());
        for (const Offset length : {1, 3, 5, 12}) {
            const auto source = randomValues<Real>(table.rowCount() * length, 6);
            std::vector<Real> result(table.columnCount() * length);
            const auto layout = BufferDescriptor::packed(length);
            const auto evaluate = [&] {
                adjoint.evaluate(source, layout, result, layout, {0, adjoint.rowCount()});
            };
            evaluate();
            // Sums have thousands of terms, added in lanes and groups: some 4 ulp for the weights,
            // as in CompiledTable, and for the sums at most the square root of their lengths.
            ASSERT_LE(errorOfSums<Real>(transpose, source, length, result), 20);
            const std::vector<Real> expected = result;
            for (const int threads : {1, 2, 8}) {
                std::fill(result.begin(), result.end(), Real{99});
                withThreads(threads, evaluate);
                ASSERT_EQ(result, expected);
            }
        }
    }
}

/// Returns rows that are outer products with size n × m × l, n ≥ m ≥ l, for all n up to 5. Rows of
/// different sizes share no columns.
template <class Real>
StencilTable<Real> tableOfProducts(Index rowsPerSize) {
    std::mt19937 random(9);
    std::uniform_real_distribution<Real> factor(Real(0.1), 1);
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    Index firstColumn = 0;
    for (Index n = 2; n <= 5; ++n)
        for (Index m = 2; m <= n; ++m)
            for (Index l = 1; l <= m; ++l) {
                for (Index row = 0; row < rowsPerSize; ++row) {
                    std::array<std::array<Real, 5>, 3> factors;
                    for (auto& own : factors)
                        for (Real& each : own) each = factor(random);
                    for (Index place = 0; place < n * m * l; ++place) {
                        columns.push_back(firstColumn + place);
                        weights.push_back(factors[0][place % n] * factors[1][place / n % m] *
                                          factors[2][place / n / m]);
                    }
                    offsets.push_back(Offset(columns.size()));
                }
                firstColumn += n * m * l;
            }
    return {firstColumn, offsets, columns, weights};
}

// The kernels take some products as factors and some multiplied out; some sizes leave lanes empty.
TYPED_TEST(CompiledAdjointTest, TakesOuterProductsOfAllSizes) {
    using Real = TypeParam;
    // More rows than are summed at once.
    const auto table = tableOfProducts<Real>(70);
    ASSERT_EQ(CompiledTable<Real>(table).productRowCount(), table.rowCount());
    const auto transpose = stencils::transposeTable(table);
    for (const Simd simd : {Simd::Baseline, Simd::Avx2, Simd::Avx512}) {
        if (!hasSimd(simd)) continue;
        const CompiledAdjoint<Real> adjoint(table, simd);
        for (const Offset length : {1, 2, 3, 4, 5}) {
            const auto source = randomValues<Real>(table.rowCount() * length, 6);
            std::vector<Real> result(table.columnCount() * length);
            const auto layout = BufferDescriptor::packed(length);
            adjoint.evaluate(source, layout, result, layout, {0, adjoint.rowCount()});
            // At most 4 ulp for the weights, and at most the square root of 70 for the sums.
            EXPECT_LE(errorOfSums<Real>(transpose, source, length, result), 12);
        }
    }
}

// ⟨D x, g⟩ = ⟨x, Dᵀ g⟩.
TYPED_TEST(CompiledAdjointTest, IsAdjointToTheCompiledTable) {
    using Real = TypeParam;
    const auto table = boundTable<Real>(shapes::cylinder({.sectors = 5}));
    const auto x = randomValues<Real>(table.columnCount(), 7);
    const auto g = randomValues<Real>(table.rowCount(), 8);
    std::vector<Real> forward(g.size()), back(x.size());
    const auto layout = BufferDescriptor::packed(1);
    CompiledTable<Real>(table).evaluate(x, layout, forward, layout, {0, table.rowCount()});
    CompiledAdjoint<Real>(table).evaluate(g, layout, back, layout, {0, table.columnCount()});
    double left = 0, right = 0, size = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        left += double{forward[i]} * double{g[i]};
        size += std::abs(double{forward[i]} * double{g[i]});
    }
    for (std::size_t i = 0; i < x.size(); ++i) right += double{back[i]} * double{x[i]};
    EXPECT_NEAR(left, right, 20 * std::numeric_limits<Real>::epsilon() * size);
}

// The weights of a regular region are stored once, as in the compiled table.
TYPED_TEST(CompiledAdjointTest, TakesLittleMoreMemoryThanTheCompiledTable) {
    const auto table = boundTable<TypeParam>(shapes::box({.cells = {4, 3, 3}}));
    // The adjoint adds eight bytes for each column of each group.
    EXPECT_LT(CompiledAdjoint<TypeParam>(table).byteCount(),
              CompiledTable<TypeParam>(table).byteCount() * 3 / 2);
}

}  // namespace
}  // namespace espalier::osd
