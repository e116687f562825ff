// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/compiled_table.h>

#include "support/mesh_shapes.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/threads.h"
#include "support/zoo.h"

// Supersets with the same weights are compiled once. Tables here have copies of a few rows, and
// copies that differ in one place.

namespace espalier::osd {
namespace {

template <class Real>
class SupersetFormTest : public ::testing::Test {};
TYPED_TEST_SUITE(SupersetFormTest, Reals);

/// A row: columns relative to the first column of its copy, and weights.
template <class Real>
struct Row {
    std::vector<Index> columns;
    std::vector<Real> weights;
};

/// Returns rows over all columns and rows over a part of them. The weights of the rows differ.
template <class Real>
std::vector<Row<Real>> someRows(bool areProducts) {
    constexpr Index kWidth = 12;
    std::mt19937 random(4);
    std::uniform_real_distribution<Real> weight(Real(0.1), 1);
    std::vector<Row<Real>> rows;
    for (int r = 0; r < 60; ++r) {
        std::array<Real, 4> a;
        std::array<Real, 3> b;
        for (Real& factor : a) factor = weight(random);
        for (Real& factor : b) factor = weight(random);
        rows.emplace_back();
        for (Index c = 0; c < kWidth; ++c) {
            if (r % 3 == 0 && c % 4 == 0) continue;
            rows.back().columns.push_back(c);
            rows.back().weights.push_back(areProducts ? a[c % 4] * b[c / 4] : weight(random));
        }
    }
    return rows;
}

/// Appends a copy of rows, with their first column at `from`.
template <class Real>
void append(const std::vector<Row<Real>>& rows, Index from, std::vector<Row<Real>>& all) {
    for (Row<Real> row : rows) {
        for (Index& column : row.columns) column += from;
        all.push_back(row);
    }
}

template <class Real>
StencilTable<Real> tableOf(const std::vector<Row<Real>>& rows, Index columnCount) {
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<Real> weights;
    for (const auto& row : rows) {
        columns.insert(columns.end(), row.columns.begin(), row.columns.end());
        weights.insert(weights.end(), row.weights.begin(), row.weights.end());
        offsets.push_back(Offset(columns.size()));
    }
    return {columnCount, offsets, columns, weights};
}

template <class Real>
std::vector<Real> resultOf(const CompiledTable<Real>& table) {
    const auto random = randomValues(std::size_t(table.columnCount()), 6);
    const std::vector<Real> source(random.begin(), random.end());
    std::vector<Real> result(std::size_t(table.rowCount()));
    table.evaluate(source, {0, 1, 1}, result, {0, 1, 1}, {0, table.rowCount()});
    return result;
}

/// Checks results against sums in long double. Each of a dozen terms is off by up to 3 ulp in an
/// outer product, and by half an ulp for each of the operations.
template <class Real>
void expectSums(const StencilTable<Real>& table, const CompiledTable<Real>& compiled) {
    const auto random = randomValues(std::size_t(table.columnCount()), 6);
    const std::vector<Real> source(random.begin(), random.end());
    const std::vector<Real> result = resultOf(compiled);
    for (Index row = 0; row < table.rowCount(); ++row) {
        long double sum = 0, size = 0;
        for (std::size_t k = 0; k < table.columns(row).size(); ++k) {
            const long double term = static_cast<long double>(table.weights(row)[k]) *
                                     source[std::size_t(table.columns(row)[k])];
            sum += term;
            size += std::abs(term);
        }
        ASSERT_LE(std::abs(result[std::size_t(row)] - sum),
                  8 * std::numeric_limits<Real>::epsilon() * size)
            << row;
    }
}

TYPED_TEST(SupersetFormTest, CopiesShareTheirNumbers) {
    constexpr Index kCopies = 400, kDistance = 7;
    for (const bool areProducts : {false, true}) {
        const auto rows = someRows<TypeParam>(areProducts);
        std::vector<Row<TypeParam>> all;
        std::mt19937 random(5);
        for (Index copy = 0; copy < kCopies; ++copy) {
            // In another order, outer products have another form, with the same numbers.
            auto own = rows;
            if (areProducts && copy % 10 == 0) std::shuffle(own.begin(), own.end(), random);
            append(own, copy * kDistance, all);
        }
        const Index columnCount = kCopies * kDistance + 12;
        const auto table = tableOf(all, columnCount);
        const CompiledTable<TypeParam> compiled(table);
        expectSums(table, compiled);
        // Half of the weights alone take more. Without sharing, the factors take more, too.
        EXPECT_LT(2 * compiled.byteCount(), std::size_t(table.entryCount()) * sizeof(TypeParam));
    }
}

// Copies differ in one weight, in the column of one row, or in the number of rows. Each difference
// is in a row that is not the first with its columns.
TYPED_TEST(SupersetFormTest, NearlyEqualCopiesHaveTheirOwnNumbers) {
    constexpr Index kCopies = 60, kDistance = 14;
    for (const bool areProducts : {false, true}) {
        const auto rows = someRows<TypeParam>(areProducts);
        std::vector<Row<TypeParam>> all;
        for (Index copy = 0; copy < kCopies; ++copy) {
            auto own = rows;
            switch (copy % 6) {
                case 1:
                    own[31].weights[4] *= 2;
                    break;
                case 2:
                    own[57].weights[7] = 0;
                    break;
                case 3:
                    own.resize(58);
                    break;
                case 4:
                    for (auto& row : own)
                        if (row.columns.size() < 12) row.columns[0] = 0;
                    break;
                case 5:
                    for (auto& row : own) row.columns.back() = 13;
                    break;
            }
            append(own, copy * kDistance, all);
        }
        const auto table = tableOf(all, kCopies * kDistance + 14);
        expectSums(table, CompiledTable<TypeParam>(table));
    }
}

// There are enough rows for two blocks of supersets.
TYPED_TEST(SupersetFormTest, DoNotDependOnTheNumberOfThreads) {
    const Lattice torus = surfaceOf(shapes::torus());
    TopologyRefiner refiner = refined(torus.complex, 5);
    const auto table = stencils::convertTable<TypeParam>(stencils::buildStencils(refiner, 5));
    ASSERT_GT(table.rowCount(), 1 << 14);
    const CompiledTable<TypeParam> once = withThreads(1, [&] { return CompiledTable(table); });
    const CompiledTable<TypeParam> twice = withThreads(7, [&] { return CompiledTable(table); });
    EXPECT_EQ(once.byteCount(), twice.byteCount());
    EXPECT_EQ(once.productRowCount(), twice.productRowCount());
    EXPECT_EQ(resultOf(once), resultOf(twice));
}

}  // namespace
}  // namespace espalier::osd
