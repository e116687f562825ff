// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/local_binding.h>
#include <espalier/osd/change_evaluator.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include "bound_table.h"
#include "support/mesh_shapes.h"
#include "support/refined_lattice.h"
#include "support/sanitizers.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

namespace espalier::osd {
namespace {

/// Returns the rows that have a weight other than 0 for one of some columns: a plain search.
template <class Real>
std::vector<Index> rowsWith(const StencilTable<Real>& table, const std::vector<Index>& changed) {
    std::vector<char> isChanged(table.columnCount(), 0);
    for (const Index column : changed) isChanged[column] = 1;
    std::vector<Index> rows;
    for (Index row = 0; row < table.rowCount(); ++row) {
        const auto columns = table.columns(row);
        const Real* weight = table.weights(row).data();
        for (const Index column : columns)
            if (*weight++ != 0 && isChanged[column] != 0) {
                rows.push_back(row);
                break;
            }
    }
    return rows;
}

/// Returns random columns of a table, unordered and with duplicates.
std::vector<Index> randomColumns(Index columnCount, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Index> columns;
    for (std::size_t i = 0; i < count; ++i)
        columns.push_back(Index(random() % unsigned(columnCount)));
    if (!columns.empty()) columns.push_back(columns.front());
    return columns;
}

/// Checks that after a change the destination equals a whole evaluation, bit for bit, and that only
/// dependent rows are written.
template <class Real>
void expectSame(const StencilTable<Real>& table, const CompiledTable<Real>& compiled, Offset length,
                const Addend<Real>& addend) {
    const ChangeEvaluator<Real> changes(compiled);
    EXPECT_EQ(changes.rowCount(), table.rowCount());
    EXPECT_EQ(changes.columnCount(), table.columnCount());
    const BufferDescriptor from{1, length, length + 2}, to{2, length, length + 1};
    auto source = randomValues<Real>(1 + table.columnCount() * from.stride, 6);
    std::vector<Real> result(2 + table.rowCount() * to.stride, 99);
    const RowRange all{0, table.rowCount()};
    compiled.evaluate(source, from, result, to, all, addend);
    Workspace workspace = changes.workspace(length);
    unsigned seed = 0;
    for (const std::size_t count : {0U, 1U, 3U, 20U, 1000U}) {
        const auto changed = randomColumns(table.columnCount(), count, ++seed);
        const auto values = randomValues<Real>(std::ssize(changed) * length, ++seed);
        for (std::size_t i = 0; i < changed.size(); ++i)
            std::copy_n(values.begin() + Offset(i) * length, length,
                        source.begin() + from.offset + changed[i] * from.stride);
        auto expected = result;
        compiled.evaluate(source, from, expected, to, all, addend);
        changes.evaluateChanged(source, from, result, to, changed, workspace, addend);
        ASSERT_EQ(result, expected);

        const auto rows = rowsWith(table, changed);
        ASSERT_EQ(changes.rowsOf(changed), rows);
        std::vector<Real> written(result.size(), 99);
        changes.evaluateChanged(source, from, written, to, changed, addend);
        std::vector<Real> few(result.size(), 99);
        for (const Index row : rows)
            std::copy_n(expected.begin() + to.offset + row * to.stride, length,
                        few.begin() + to.offset + row * to.stride);
        ASSERT_EQ(written, few);
    }
}

/// Does so without an addend and with one.
template <class Real>
void expectSame(const StencilTable<Real>& table, const CompiledTable<Real>& compiled,
                Offset length) {
    expectSame(table, compiled, length, {});
    const auto values = randomValues<Real>(table.rowCount() * length, 77);
    expectSame(table, compiled, length, Addend<Real>::packed(values, length));
}

template <class Real>
class ChangeEvaluatorTest : public ::testing::Test {};
TYPED_TEST_SUITE(ChangeEvaluatorTest, Reals);

TYPED_TEST(ChangeEvaluatorTest, EqualsAWholeEvaluationOnTheZoo) {
    for (const auto& [name, lattice] : zoo()) {
        SCOPED_TRACE(name);
        TopologyRefiner refiner = refined(lattice.complex, 2, {.marks = lattice.marks});
        const auto vertices =
            stencils::convertTable<TypeParam>(stencils::buildStencils(refiner, 2));
        expectSame(vertices, CompiledTable<TypeParam>(vertices), 3);
        if (lattice.complex.dimension() < 3) continue;
        const auto points = boundTable<TypeParam>(lattice, 300, 2);
        expectSame(points, CompiledTable<TypeParam>(points), 3);
    }
}

// Covers outer products, panels (also with zeros for columns that a row lacks), rows with their own
// columns, and all kernels.
TYPED_TEST(ChangeEvaluatorTest, EqualsAWholeEvaluationForEachFormOfRows) {
    const auto box = boundTable<TypeParam>(shapes::box({.cells = {5, 4, 4}}));
    const auto cylinder = boundTable<TypeParam>(shapes::cylinder({.sectors = 5}), 1000);
    const Lattice torus = surfaceOf(shapes::torus());
    TopologyRefiner refiner = refined(torus.complex, 3);
    const auto surface = stencils::convertTable<TypeParam>(stencils::buildStencils(refiner, 3));
    EXPECT_GT(CompiledTable<TypeParam>(box).productRowCount(), 100);
    for (const Simd simd : {Simd::Baseline, Simd::Avx2, Simd::Avx512}) {
        if (!hasSimd(simd)) continue;
        for (const auto* table : {&box, &cylinder, &surface})
            for (const Offset length : someOf<Offset>({3, 1, 5, 12}))
                expectSame(*table, CompiledTable<TypeParam>(*table, simd), length);
    }
}

// Rows so long that the buffer of a task does not fit on the stack.
TYPED_TEST(ChangeEvaluatorTest, LongRows) {
    const auto weights = randomValues(60 * 2500, 9);
    const auto table = tableOfLongRows<TypeParam>(60, 2500, [&](std::size_t entry) {
        return entry % 3 == 0 ? 0 : weights[entry];  // some entries are 0
    });
    expectSame(table, CompiledTable<TypeParam>(table), 3);
}

TYPED_TEST(ChangeEvaluatorTest, DoesNotDependOnThreads) {
    const auto table = boundTable<TypeParam>(shapes::box({.cells = {4, 4, 4}}));
    for (const int threads : {1, 2, 8})
        withThreads(threads, [&] { expectSame(table, CompiledTable<TypeParam>(table), 3); });
}

TYPED_TEST(ChangeEvaluatorTest, OutlivesTheCompiledTable) {
    const StencilTable<TypeParam> table(2, {0, 1, 2}, {1, 0}, {2, 3});
    const auto changes = [&] {
        const CompiledTable<TypeParam> compiled(table);
        return ChangeEvaluator<TypeParam>(compiled);
    }();
    std::vector<TypeParam> result(2, 99);
    changes.evaluateChanged(std::vector<TypeParam>{5, 7}, {0, 1, 1}, result, {0, 1, 1},
                            std::vector<Index>{0});
    EXPECT_EQ(result, (std::vector<TypeParam>{99, 15}));
    const ChangeEvaluator<TypeParam> none{CompiledTable<TypeParam>(StencilTable<TypeParam>())};
    none.evaluateChanged({}, {0, 1, 1}, {}, {0, 1, 1}, {});
    EXPECT_TRUE(none.rowsOf({}).empty());
}

TYPED_TEST(ChangeEvaluatorTest, RejectsBadArgumentsBeforeWriting) {
    const StencilTable<TypeParam> table(2, {0, 1, 2}, {1, 0}, {2, 3});
    const ChangeEvaluator<TypeParam> changes{CompiledTable<TypeParam>(table)};
    const std::vector<TypeParam> source = {5, 7};
    std::vector<TypeParam> result(2, 99);
    const auto expectRefused = [&](const char* why, std::size_t size,
                                   const std::vector<Index>& changed) {
        EXPECT_REFUSED(Error, why,
                       changes.evaluateChanged(source, {0, 1, 1}, std::span(result).first(size),
                                               {0, 1, 1}, changed));
        EXPECT_THAT(result, Each(99));
    };
    expectRefused("column 2 is not in a table of 2 columns", 2, {0, 2});
    expectRefused("column -1 is not", 2, {-1, 0});
    expectRefused("destination buffer holds 1", 1, {0});
    EXPECT_THROW(changes.rowsOf(std::vector<Index>{2}), Error);
}

}  // namespace
}  // namespace espalier::osd
