// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/osd/kernels/kernels.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace espalier::osd {

/// Describes rows that share their columns and are outer products: an arrangement of the columns in
/// a box so that column order[(k·size[1] + j)·size[0] + i] has the weight a_i · b_j · c_k. Each row
/// has its own a, b and c.
///
/// Rows are outer products in regular regions: level-n vertices of a tensor-product spline, points
/// bound to its cells by trilinear weights or in the limit, and derivatives there. Weights of
/// derivatives have either sign.
struct OuterProduct {
    std::array<Index, 3> size = {};  ///< 1 or more; in descending order
    std::vector<Index> order = {};   ///< positions in the columns of a row
};

/// Finds the arrangement of the columns from the weights alone. It uses their logarithms, which for
/// an outer product are sums α_i + β_j + γ_k. It samples a few of the rows only; for each row,
/// factorizeRows() tells whether it is such an outer product.
///
/// \param rows the weights of rows with the same columns: columnCount numbers for each row
/// \return nothing if there is no box, if the box has a single axis, which would save nothing, or
///         if there are more than kernels::kMaxProductColumns columns
/// \cost O(columns² log columns), and O(entries) if a sampled row has a weight near 0
template <class Real>
std::optional<OuterProduct> findOuterProduct(std::span<const Real* const> rows,
                                             std::size_t columnCount);

/// Computes the factors of rows: size[0] + size[1] + size[2] numbers for each row, a then b then c.
///
/// \param kernels for any instruction set: the result has the same bits
/// \param positions for each weight of a row, its position among the columns of the outer product;
///        the row has the weight 0 for other columns
/// \param rows the weights of each row
/// \param factors the factors of those rows that are such outer products are appended, one row
///        after the other
/// \param isProduct gets for each row whether it is such an outer product. It is none if a weight
///        differs from its product by more than three times the precision of Real (plus the
///        smallest normal number), or the largest weight is so small that this test would mean
///        nothing
template <class Real>
void factorizeRows(const kernels::Kernels<Real>& kernels, const OuterProduct& product,
                   std::span<const Index> positions, std::span<const Real* const> rows,
                   Array<Real>& factors, std::vector<char>& isProduct);

}  // namespace espalier::osd
