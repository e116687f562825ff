// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>
#include <espalier/stencils/stencil_table.h>

#include <Eigen/SparseCore>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace espalier::stencils {

/// Shows a table to Eigen as a compressed row-major sparse matrix, rowCount() × columnCount(),
/// without copying columns and weights. The row offsets are copied, since Eigen needs them in the
/// integer type of the columns.
///
/// The table must outlive the view, and the view must outlive the result of matrix().
template <class Real>
class ESPALIER_API SparseView {
public:
    using Matrix = Eigen::SparseMatrix<Real, Eigen::RowMajor, Index>;
    using Map = Eigen::Map<const Matrix>;

    /// \throws Error if the table has more entries than an Index can count
    explicit SparseView(const StencilTable<Real>& table) : table_(&table) {
        if (table.entryCount() > kMaxIndex)
            throw Error("a table of " + std::to_string(table.entryCount()) +
                        " entries is too large for a view with 32-bit offsets");
        offsets_.assign(table.offsets().begin(), table.offsets().end());
    }

    Map matrix() const {
        return Map(table_->rowCount(), table_->columnCount(),
                   static_cast<Eigen::Index>(table_->entryCount()), offsets_.data(),
                   table_->columns().data(), table_->weights().data());
    }

private:
    const StencilTable<Real>* table_;
    std::vector<Index> offsets_;
};

/// Returns a table with the entries of any Eigen sparse expression; explicit zeros are kept.
/// \throws Error if it has more rows or columns than an Index can count
template <class Derived>
StencilTable<typename Derived::Scalar> fromEigen(const Eigen::SparseMatrixBase<Derived>& matrix) {
    using Real = typename Derived::Scalar;
    if (matrix.rows() > kMaxIndex || matrix.cols() > kMaxIndex)
        throw Error("a matrix of " + std::to_string(matrix.rows()) + " × " +
                    std::to_string(matrix.cols()) + " is too large for a table");
    Eigen::SparseMatrix<Real, Eigen::RowMajor, Eigen::Index> rows = matrix;
    rows.makeCompressed();
    const std::size_t entries = rows.nonZeros();
    const std::size_t rowCount = rows.rows();
    Array<Offset> offsets(rows.outerIndexPtr(), rows.outerIndexPtr() + rowCount + 1);
    Array<Index> columns(entries);
    for (std::size_t i = 0; i < entries; ++i)
        columns[i] = static_cast<Index>(rows.innerIndexPtr()[i]);
    return StencilTable<Real>(static_cast<Index>(rows.cols()), std::move(offsets),
                              std::move(columns),
                              Array<Real>(rows.valuePtr(), rows.valuePtr() + entries));
}

}  // namespace espalier::stencils
