// SPDX-License-Identifier: Apache-2.0
#include "solve/cancellable_ldlt.h"

#include <chrono>
#include <vector>

#include "support/test.h"

namespace espalier::solve {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// Returns a symmetric matrix with random entries at random places, and a diagonal that makes it
/// definite: its rows have about 10 entries of at most 1.
Matrix randomMatrix(int size) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> numbers(-1, 1);
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < size; ++i) {
        entries.emplace_back(i, i, 30);
        for (int k = 0; k < 5; ++k) {
            const int j = static_cast<int>(random() % static_cast<unsigned>(size));
            const double number = numbers(random);
            entries.emplace_back(i, j, number);
            entries.emplace_back(j, i, number);
        }
    }
    Matrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

TEST(CancellableLdlt, HasTheBitsOfEigensFactors) {
    const Matrix matrix = randomMatrix(300);
    const Eigen::SimplicialLDLT<Matrix> expected(matrix);
    CancellableLdlt factor;
    factor.compute(matrix);
    ASSERT_EQ(factor.info(), Eigen::Success);
    EXPECT_TRUE(factor.vectorD() == expected.vectorD());
    const Matrix lower = factor.matrixL(), expectedLower = expected.matrixL();
    EXPECT_GT(lower.nonZeros(), matrix.nonZeros());  // It is filled in.
    EXPECT_EQ((lower - expectedLower).norm(), 0);
    const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(300, 1, 2);
    EXPECT_TRUE(factor.solve(right) == expected.solve(right));
}

TEST(SquareOf, HasTheBitsOfEigensProduct) {
    // More rows than columns, as targets and vertices of a fit; a column is empty.
    Matrix matrix = randomMatrix(300).leftCols(40);
    matrix.prune([](Eigen::Index, Eigen::Index column, double) { return column != 7; });
    Matrix expected;
    expected = matrix.transpose() * matrix;
    const Matrix square = squareOf(matrix);
    EXPECT_EQ(square.nonZeros(), expected.nonZeros());
    EXPECT_GT(square.nonZeros(), 200);
    EXPECT_EQ((square - expected).norm(), 0);
}

TEST(CancellableLdlt, ReportsASingularMatrix) {
    Matrix matrix(2, 2);
    matrix.insert(0, 0) = 1;
    CancellableLdlt factor;
    factor.compute(matrix);
    EXPECT_EQ(factor.info(), Eigen::NumericalIssue);
}

TEST(CancellableLdlt, CanBeCancelledAtEachRow) {
    const Matrix matrix = randomMatrix(100);
    CancellableLdlt factor;
    int calls = 0;
    {
        const ProgressScope scope([&](const Progress&) { return ++calls < 50; },
                                  std::chrono::milliseconds(0));
        EXPECT_THROW(factor.compute(matrix), Cancelled);
    }
    EXPECT_EQ(calls, 50);
    factor.compute(matrix);
    EXPECT_EQ(factor.info(), Eigen::Success);
}

}  // namespace
}  // namespace espalier::solve
