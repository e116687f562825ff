// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/rounded_product.h>

#include "support/test.h"

// Compiled for a processor that can fuse (CMakeLists.txt), where Eigen's operator * has other bits.

namespace espalier::embed {
namespace {

template <int rows, int columns>
void expectRoundedProducts(unsigned seed) {
    const auto values = randomValues(rows * columns + columns, seed);
    const Eigen::Matrix<double, rows, columns> matrix(values.data());
    const Eigen::Matrix<double, columns, 1> vector(values.data() + rows * columns);
    const Eigen::Matrix<double, rows, 1> result = roundedProduct(matrix, vector);
    for (Eigen::Index row = 0; row < rows; ++row) {
        double sum = 0;
        for (Eigen::Index column = 0; column < columns; ++column) {
            const volatile double product = matrix(row, column) * vector[column];
            sum += product;
        }
        EXPECT_EQ(result[row], sum) << row;
    }
}

TEST(RoundedProduct, RoundsEachProduct) {
#ifdef __FMA__
    if (!__builtin_cpu_supports("fma") || !__builtin_cpu_supports("avx"))
        GTEST_SKIP() << "this processor cannot fuse";
#endif
    for (unsigned seed = 0; seed < 20; ++seed) {
        expectRoundedProducts<3, 3>(seed);
        expectRoundedProducts<3, 4>(seed);
        expectRoundedProducts<12, 4>(seed);
    }
}

}  // namespace
}  // namespace espalier::embed
