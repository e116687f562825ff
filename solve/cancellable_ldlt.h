// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/progress.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <utility>
#include <vector>

namespace espalier::solve {

/// Returns matrixᵀ · matrix, with the bits of Eigen's product, but a host may cancel between two
/// columns.
/// \throws as checkCancelled()
inline Eigen::SparseMatrix<double> squareOf(const Eigen::SparseMatrix<double>& matrix) {
    using Entries = Eigen::SparseMatrix<double>::InnerIterator;
    // Not by a constructor, because Eigen's constructors leak memory if an allocation throws.
    Eigen::SparseMatrix<double> rows;
    rows = matrix.transpose();  // Column k is row k of the matrix.
    Eigen::SparseMatrix<double> square(matrix.cols(), matrix.cols());
    std::vector<double> sums(matrix.cols());
    std::vector<char> isTouched(matrix.cols(), 0);
    std::vector<Eigen::Index> touched;
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
        checkCancelled();
        touched.clear();
        for (Entries row(matrix, column); row; ++row)
            for (Entries entry(rows, row.row()); entry; ++entry) {
                const Eigen::Index at = entry.row();
                const double product = entry.value() * row.value();
                if (isTouched[at] != 0) {
                    sums[at] += product;
                    continue;
                }
                isTouched[at] = 1;
                sums[at] = product;
                touched.push_back(at);
            }
        std::sort(touched.begin(), touched.end());
        square.startVec(column);
        for (const Eigen::Index at : touched) {
            square.insertBack(at, column) = sums[at];
            isTouched[at] = 0;
        }
    }
    square.finalize();
    return square;
}

/// Eigen's sparse factors L D Lᵀ of a symmetric matrix, but a host may cancel between two rows of
/// L. The factors have the same bits. Finding the order of the rows cannot be cancelled; it takes
/// a thirtieth of the time or less.
///
/// Thousands of vertices whose basis functions overlap take many seconds: about n² time for n
/// vertices of a lattice.
/// \cite Davis 2005, Algorithm 849: a concise sparse Cholesky factorization package
class CancellableLdlt : public Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> {
public:
    /// \param matrix its lower triangle is used
    /// \throws as checkCancelled(); then there are no factors
    void compute(const Eigen::SparseMatrix<double>& matrix) {
        analyzePattern(matrix);
        const auto size = static_cast<int>(matrix.cols());
        Eigen::SparseMatrix<double> upper(size, size);
        upper.selfadjointView<Eigen::Upper>() =
            matrix.selfadjointView<Eigen::Lower>().twistedBy(m_P);
        m_diag.resize(size);
        const int* const starts = m_matrix.outerIndexPtr();
        int* const rows = m_matrix.innerIndexPtr();
        double* const values = m_matrix.valuePtr();
        std::vector<double> sums(size, 0);    // of the row
        std::vector<int> seen(size, -1);      // per column: the last row that has an entry there
        std::vector<int> columns(size), way;  // of the row, columns before those that need them
        m_info = Eigen::Success;
        for (int row = 0; row < size && m_info == Eigen::Success; ++row) {
            checkCancelled();
            m_nonZerosPerCol[row] = 0;
            seen[row] = row;
            auto first = columns.end();
            for (Eigen::SparseMatrix<double>::InnerIterator entry(upper, row); entry; ++entry) {
                auto column = static_cast<int>(entry.row());
                sums[column] += entry.value();
                // An entry fills in all columns on the way up the elimination tree.
                way.clear();
                for (; seen[column] != row; column = m_parent[column]) {
                    way.push_back(column);
                    seen[column] = row;
                }
                first = std::copy_backward(way.begin(), way.end(), first);
            }
            double diagonal = std::exchange(sums[row], 0);
            for (auto at = first; at != columns.end(); ++at) {
                const double sum = std::exchange(sums[*at], 0);
                const double value = sum / m_diag[*at];
                const int begin = starts[*at], end = begin + m_nonZerosPerCol[*at]++;
                for (int i = begin; i < end; ++i) sums[rows[i]] -= values[i] * sum;
                diagonal -= value * sum;
                rows[end] = row;
                values[end] = value;
            }
            m_diag[row] = diagonal;
            if (diagonal == 0) m_info = Eigen::NumericalIssue;
        }
        m_factorizationIsOk = true;
    }
};

}  // namespace espalier::solve
