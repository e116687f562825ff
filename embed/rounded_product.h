// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace espalier::embed {

/// Returns matrix · vector, for 3 or 4 columns. Each product is rounded, and the columns are added
/// in their order.
///
/// Eigen's operator * fuses products with sums on ARM, and on x86-64 if a compiler's flag allows
/// FMA. Places of points, and so weights, would depend on the processor and on flags.
template <class Matrix, class Vector>
Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1> roundedProduct(
    const Eigen::MatrixBase<Matrix>& matrix, const Eigen::MatrixBase<Vector>& vector) {
    constexpr int kColumns = Vector::RowsAtCompileTime;
    static_assert(kColumns == 3 || kColumns == 4);
    const Eigen::Matrix<double, kColumns, 1> factors = vector;
    Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1> result;
    for (Eigen::Index row = 0; row < Matrix::RowsAtCompileTime; ++row) {
        double sum =
            matrix(row, 0) * factors[0] + matrix(row, 1) * factors[1] + matrix(row, 2) * factors[2];
        if constexpr (kColumns == 4) sum += matrix(row, 3) * factors[3];
        result[row] = sum;
    }
    return result;
}

}  // namespace espalier::embed
