// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace espalier::embed {

/// Returns matrix · vector, for 3 or 4 columns: an expression, which refers to the matrix. Each
/// product is rounded, and the columns are added in their order.
///
/// Eigen's operator * fuses products with sums on ARM, and on x86-64 if a compiler's flag allows
/// FMA. Places of points, and so weights, would depend on the processor and on flags.
template <class Matrix, class Vector>
auto roundedProduct(const Eigen::MatrixBase<Matrix>& matrix,
                    const Eigen::MatrixBase<Vector>& vector) {
    static_assert(Vector::RowsAtCompileTime == 3 || Vector::RowsAtCompileTime == 4);
    const auto three =
        matrix.col(0) * vector[0] + matrix.col(1) * vector[1] + matrix.col(2) * vector[2];
    if constexpr (Vector::RowsAtCompileTime == 4)
        return three + matrix.col(3) * vector[3];
    else
        return three;
}

}  // namespace espalier::embed
