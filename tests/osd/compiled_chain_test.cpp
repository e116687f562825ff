// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/zoo.h"

namespace espalier::osd {
namespace {

template <class Real, class Evaluator>
std::vector<Real> evaluate(const Evaluator& evaluator) {
    const auto random = randomValues(3 * std::size_t(evaluator.columnCount()), 6);
    std::vector<Real> result(3 * std::size_t(evaluator.rowCount()));
    const auto layout = BufferDescriptor::packed(3);
    evaluator.evaluate(std::vector<Real>(random.begin(), random.end()), layout, result, layout,
                       {0, evaluator.rowCount()});
    return result;
}

template <class Real>
void expectNear(const std::vector<Real>& a, const std::vector<Real>& b, Real bound) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], bound) << i;
}

template <class Real>
class CompiledChainTest : public ::testing::Test {};
TYPED_TEST_SUITE(CompiledChainTest, Reals);

// R_3 · R_2 · R_1 is S_3.
TYPED_TEST(CompiledChainTest, ChainOfLevelTablesEqualsTheirProduct) {
    constexpr auto kEpsilon = std::numeric_limits<TypeParam>::epsilon();
    for (const auto& [name, lattice] : zoo()) {
        SCOPED_TRACE(name);
        TopologyRefiner refiner = test::refined(lattice.complex, 2, {.marks = lattice.marks});
        std::vector<StencilTable<TypeParam>> levels;
        for (auto& level : stencils::buildLevelTables(refiner, 2))
            levels.push_back(convertTable<TypeParam>(std::move(level)));
        const CompiledChain<TypeParam> chain(levels);
        const CompiledTable<TypeParam> table(
            convertTable<TypeParam>(stencils::buildStencils(refiner, 2)));
        // Values are at most 1. Rows sum to 1, and nearly all weights have the same sign. So the
        // error is at most 4 ulp for each of the three tables, plus one for the weights of each.
        expectNear(evaluate<TypeParam>(chain), evaluate<TypeParam>(table), 30 * kEpsilon);
    }
}

TYPED_TEST(CompiledChainTest, ChainOfFactorsEqualsTheirProduct) {
    constexpr auto kEpsilon = std::numeric_limits<TypeParam>::epsilon();
    const Lattice lattice = shapes::cylinder({.sectors = 5, .pattern = {.rings = 2}, .layers = 3});
    const Refined refined(lattice, 2);
    const auto points = pointsIn(refined, 40'000, 3);
    const TopologyRefiner base(lattice.complex);
    const auto factored = embed::bindFactored({base, refined.base}, points, {.level = 2});
    const auto bound = embed::bindPoints({base, refined.base}, points, {.level = 2});
    EXPECT_EQ(factored.statuses, bound.statuses);
    const auto factors = convertTable<TypeParam>(factored.table);
    const CompiledChain<TypeParam> chain(factors);
    const CompiledTable<TypeParam> table(convertTable<TypeParam>(bound.table));
    EXPECT_EQ(chain.rowCount(), table.rowCount());
    EXPECT_EQ(chain.columnCount(), table.columnCount());
    expectNear(evaluate<TypeParam>(chain), evaluate<TypeParam>(table), 30 * kEpsilon);
    // With about twenty points in each cell, rows of the points have 8 entries and rows of D 24,
    // since most are near the boundary.
    EXPECT_LT(factored.table.entryCount(), bound.table.entryCount() / 2);
    EXPECT_LT(chain.byteCount(), table.byteCount());
}

// ⟨W S x, g⟩ = ⟨x, Sᵀ Wᵀ g⟩.
TYPED_TEST(CompiledChainTest, ChainOfFactorsHasAnAdjoint) {
    using Real = TypeParam;
    const Lattice lattice = shapes::cylinder({.sectors = 5});
    const Refined refined(lattice, 2);
    const auto factors =
        convertTable<Real>(embed::bindFactored({TopologyRefiner(lattice.complex), refined.base},
                                               pointsIn(refined, 3000, 3), {.level = 2})
                               .table);
    const CompiledAdjointChain<Real> adjoint(factors);
    EXPECT_EQ(adjoint.rowCount(), factors.columnCount());
    EXPECT_EQ(adjoint.columnCount(), factors.rowCount());
    EXPECT_GT(adjoint.byteCount(), 0U);
    const auto moved = evaluate<Real>(CompiledChain<Real>(factors));
    const auto gradients = evaluate<Real>(adjoint);
    const auto g = randomValues(moved.size(), 6), x = randomValues(gradients.size(), 6);
    double left = 0, right = 0, size = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        left += double{moved[i]} * g[i];
        size += std::abs(double{moved[i]} * g[i]);
    }
    for (std::size_t i = 0; i < x.size(); ++i) right += double{gradients[i]} * x[i];
    // A few ulp for each of the sums, and the rounding of the values to Real.
    EXPECT_NEAR(left, right, 20 * std::numeric_limits<Real>::epsilon() * size);
}

TEST(CompiledChain, RejectsTablesOfMismatchedSizes) {
    const StencilTable<double> two(3, {0, 1, 2}, {0, 2}, {1, 1});
    EXPECT_REFUSED(Error, "at least one",
                   CompiledChain<double>(std::span<const StencilTable<double>>()));
    EXPECT_REFUSED(Error, "table 2 of the chain has 3 columns; the one before has 2 rows",
                   CompiledChain<double>(std::array{two, two}));
    EXPECT_REFUSED(Error, "the table of points has 3 columns; the table of vertices has 2",
                   CompiledChain<double>(stencils::FactoredTable<double>{two, two}));
    EXPECT_REFUSED(Error, "table 2 of the chain has 3 columns",
                   CompiledAdjointChain<double>(std::array{two, two}));
    const CompiledChain<double> one(std::array{two});
    EXPECT_EQ(one.rowCount(), 2);
    EXPECT_EQ(one.columnCount(), 3);
}

}  // namespace
}  // namespace espalier::osd
