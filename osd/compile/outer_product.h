// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/function_ref.h>
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
/// factorizeRow() tells whether it is such an outer product.
///
/// \param rows the weights of rows with the same columns
/// \return nothing if there is no box, if the box has a single axis, which would save nothing, or
///         if there are more than kernels::kMaxProductColumns columns
/// \cost O(columns² log columns)
template <class Real>
std::optional<OuterProduct> findOuterProduct(std::span<const std::span<const Real>> rows);

/// Computes the factors of rows: size[0] + size[1] + size[2] numbers for each row, a then b then c.
///
/// \param positions for each weight of a row, its position among the columns of the outer product;
///        the row has the weight 0 for other columns
/// \param rows the weights of each row
/// \param use use(i, factors) is called for each row in turn. There are no factors if row i is not
///        such an outer product: a weight differs from its product by more than three times the
///        precision of Real (plus the smallest normal number), or the largest weight is so small
///        that this test would mean nothing
template <class Real>
void factorizeRows(const OuterProduct& product, std::span<const Index> positions,
                   std::span<const std::span<const Real>> rows,
                   FunctionRef<void(std::size_t, std::span<const Real>)> use);

}  // namespace espalier::osd
