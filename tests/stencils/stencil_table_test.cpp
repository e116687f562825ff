// SPDX-License-Identifier: Apache-2.0
#include <espalier/stencils/sparse_matrix.h>
#include <espalier/stencils/stencil_table.h>

#include "support/test.h"

namespace espalier::stencils {
namespace {

template <class Real>
class StencilTableTest : public ::testing::Test {};
TYPED_TEST_SUITE(StencilTableTest, Reals);

TYPED_TEST(StencilTableTest, ReturnsItsRows) {
    const StencilTable<TypeParam> table(4, {0, 2, 2, 3}, {1, 3, 0}, {.25, .75, 1});
    EXPECT_EQ(table.rowCount(), 3);
    EXPECT_EQ(table.columnCount(), 4);
    EXPECT_EQ(table.entryCount(), 3);
    EXPECT_THAT(table.columns(0), ElementsAre(1, 3));
    EXPECT_THAT(table.weights(0), ElementsAre(.25, .75));
    EXPECT_THAT(table.columns(1), IsEmpty());
    EXPECT_THAT(table.weights(2), ElementsAre(1));
    EXPECT_EQ(StencilTable<TypeParam>().rowCount(), 0);
}

TYPED_TEST(StencilTableTest, RefusesInvalidArrays) {
    const auto expectRefused = [](const char* why, Index columnCount, Array<Offset> offsets,
                                  Array<Index> columns, std::size_t weights) {
        EXPECT_REFUSED(
            Error, why,
            StencilTable<TypeParam>(columnCount, offsets, columns, Array<TypeParam>(weights, 1)));
    };
    expectRefused("0 offsets", 4, {}, {}, 0);
    expectRefused("compressed sparse rows", 4, {1, 2}, {0, 1}, 2);
    expectRefused("compressed sparse rows", 4, {0, 3}, {0, 1}, 2);
    expectRefused("2 columns and 3 weights", 4, {0, 2}, {0, 1}, 3);
    expectRefused("row 1 of the table has offsets out of order", 4, {0, 2, 1, 2}, {0, 1}, 2);
    expectRefused("row 0 of the table has offsets out of order", 4, {0, 9, 2}, {0, 1}, 2);
    expectRefused("row 0 of the table names a column that does not exist", 4, {0, 2}, {0, 4}, 2);
    expectRefused("row 0 of the table names a column that does not exist", 4, {0, 1}, {-1}, 1);
    expectRefused("row 1 of the table has columns that do not ascend", 4, {0, 1, 3}, {0, 2, 2}, 3);
}

// A 3 × 4 matrix with an empty row, by hand.
TYPED_TEST(StencilTableTest, EigenSeesTheMatrix) {
    const StencilTable<TypeParam> table(4, {0, 2, 2, 3}, {1, 3, 0}, {.25, .75, 1});
    const SparseView<TypeParam> view(table);
    EXPECT_EQ(view.matrix().rows(), 3);
    EXPECT_EQ(view.matrix().cols(), 4);
    const Eigen::Vector4<TypeParam> x(1, 2, 3, 4);
    EXPECT_EQ((view.matrix() * x).eval(), Eigen::Vector3<TypeParam>(.25 * 2 + .75 * 4, 0, 1));
    EXPECT_EQ(view.matrix().valuePtr(), table.weights().data()) << "not a copy";
    EXPECT_EQ(view.matrix().innerIndexPtr(), table.columns().data());
}

TYPED_TEST(StencilTableTest, RoundTripsThroughEigen) {
    const StencilTable<TypeParam> table(4, {0, 2, 2, 3}, {1, 3, 0}, {.25, .75, 1});
    EXPECT_EQ(fromEigen(SparseView<TypeParam>(table).matrix()), table);
    // From the other storage order, and from an expression.
    const Eigen::SparseMatrix<TypeParam> columnMajor = SparseView<TypeParam>(table).matrix();
    EXPECT_EQ(fromEigen(columnMajor), table);
    EXPECT_EQ(fromEigen(columnMajor * TypeParam{2}).weights(2)[0], 2);
}

TEST(StencilTable, ConvertsBetweenPrecisions) {
    const StencilTable<double> table(2, {0, 2}, {0, 1}, {1. / 3, 2. / 3});
    const auto rounded = convertTable<float>(table);
    EXPECT_THAT(rounded.weights(0), ElementsAre(float(1. / 3), float(2. / 3)));
    EXPECT_EQ(convertTable<float>(StencilTable<double>(table)), rounded);
    EXPECT_EQ(convertTable<double>(rounded).weights(0)[0], double(float(1. / 3)));
}

TEST(StencilTable, TransposeHasTheEntriesByColumns) {
    const StencilTable<double> table(4, {0, 3, 3, 5}, {0, 1, 3, 1, 3}, {1, 2, 3, 4, 5});
    const StencilTable<double> expected(3, {0, 1, 3, 3, 5}, {0, 0, 2, 0, 2}, {1, 2, 4, 3, 5});
    EXPECT_EQ(transposeTable(table), expected);
    EXPECT_EQ(transposeTable(expected), table);
    EXPECT_EQ(transposeTable(StencilTable<double>(2, {0}, {}, {})),
              StencilTable<double>(0, {0, 0, 0}, {}, {}));
}

TEST(StencilTable, SelectedRowsHaveTheGivenOrder) {
    const StencilTable<float> table(4, {0, 3, 3, 5}, {0, 1, 3, 1, 3}, {1, 2, 3, 4, 5});
    const std::vector<Index> rows = {2, 1, 2};
    EXPECT_EQ(selectRows<float>(table, rows),
              StencilTable<float>(4, {0, 2, 2, 4}, {1, 3, 1, 3}, {4, 5, 4, 5}));
}

// Two points, each with its position and a derivative.
TYPED_TEST(StencilTableTest, TablesInterleaveRowByRow) {
    using Table = StencilTable<TypeParam>;
    const Table position(3, {0, 2, 3}, {0, 1, 2}, {.5, .5, 1});
    const Table derivative(3, {0, 2, 2}, {0, 1}, {-1, 1});
    EXPECT_EQ(interleaveRows<TypeParam>({&position, &derivative}),
              Table(3, {0, 2, 4, 5, 5}, {0, 1, 0, 1, 2}, {.5, .5, -1, 1, 1}));
    EXPECT_EQ(interleaveRows<TypeParam>({&position}), position);
    const Table other(2, {0, 0, 0}, {}, {});
    EXPECT_REFUSED(Error, "table 1 is 2 × 2, but table 0 is 2 × 3",
                   interleaveRows<TypeParam>({&position, &other}));
    EXPECT_THROW(interleaveRows<TypeParam>({}), Error);
}

}  // namespace
}  // namespace espalier::stencils
