// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/local_binding.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/refined_lattice.h"
#include "support/threads.h"
#include "support/zoo.h"

// Tables as they come: the contract is tested in evaluator_test.cpp.
namespace espalier::osd {
namespace {

using stencils::Rules;
using stencils::StencilTable;

/// D of random points in a lattice at level 3: some thousand, so that most rows are in groups.
template <class Real>
StencilTable<Real> boundTable(const Lattice& lattice) {
    const test::Refined refined(lattice, 3);
    return stencils::bindPoints<Real>(far::TopologyRefiner(lattice.complex), lattice.positions, 3,
                                      Rules::Siggraph96, test::pointsIn(refined, 4000, 5))
        .binding.table;
}

template <class Real>
std::vector<Real> randomValues(Offset count, unsigned seed) {
    const auto values = test::randomValues(static_cast<std::size_t>(count), seed);
    return {values.begin(), values.end()};
}

template <class Real>
class CompiledAdjointTest : public ::testing::Test {};
using Reals = ::testing::Types<float, double>;
TYPED_TEST_SUITE(CompiledAdjointTest, Reals);

TYPED_TEST(CompiledAdjointTest, GivesTheSumsOfTheTranspose) {
    using Real = TypeParam;
    // Outer products and panels; panels and rows alone; a few groups of very many rows.
    for (const Lattice& lattice :
         {shapes::box({.cells = {4, 3, 3}}), shapes::cylinder({.sectors = 5}), shapes::box()}) {
        const auto table = boundTable<Real>(lattice);
        const auto transpose = stencils::transposeTable(table);
        const CompiledAdjoint<Real> adjoint(table);
        EXPECT_EQ(adjoint.rowCount(), table.columnCount());
        EXPECT_EQ(adjoint.columnCount(), table.rowCount());
        for (const Offset length : {1, 3, 5, 12}) {
            const auto source = randomValues<Real>(table.rowCount() * length, 6);
            std::vector<Real> result(static_cast<std::size_t>(table.columnCount() * length));
            const auto layout = BufferDescriptor::packed(length);
            const auto evaluate = [&] {
                adjoint.evaluate(source, layout, result, layout, {0, adjoint.rowCount()});
            };
            evaluate();
            for (Index row = 0; row < transpose.rowCount(); ++row)
                for (Offset c = 0; c < length; ++c) {
                    long double sum = 0, size = 0;
                    for (std::size_t k = 0; k < transpose.columns(row).size(); ++k) {
                        const long double product =
                            static_cast<long double>(transpose.weights(row)[k]) *
                            source[static_cast<std::size_t>(transpose.columns(row)[k] * length +
                                                            c)];
                        sum += product;
                        size += std::abs(product);
                    }
                    // Of sums of thousands in lanes and groups: some 4 ulp for weights, as
                    // CompiledTable's, and for sums the square root of their lengths at most.
                    ASSERT_LE(std::abs(result[static_cast<std::size_t>(row * length + c)] - sum),
                              20 * std::numeric_limits<Real>::epsilon() * size)
                        << row;
                }
            const std::vector<Real> expected = result;
            for (const int threads : {1, 2, 8}) {
                std::fill(result.begin(), result.end(), Real{99});
                test::withThreads(threads, evaluate);
                ASSERT_EQ(result, expected);
            }
        }
    }
}

// ⟨D x, g⟩ = ⟨x, Dᵀ g⟩.
TYPED_TEST(CompiledAdjointTest, IsTheAdjointOfTheCompiledTable) {
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

// What a regular region's numbers take, they take once.
TYPED_TEST(CompiledAdjointTest, TakesNoMoreThanTheCompiledTable) {
    const auto table = boundTable<TypeParam>(shapes::box({.cells = {4, 3, 3}}));
    // And eight bytes for each column of each group.
    EXPECT_LT(CompiledAdjoint<TypeParam>(table).byteCount(),
              CompiledTable<TypeParam>(table).byteCount() * 3 / 2);
}

}  // namespace
}  // namespace espalier::osd
