// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// Computes the factors of a row: size[0] + size[1] + size[2] numbers, a then b then c.
///
/// \return false if the row is not such an outer product: a weight differs from its product by more
///         than three times the precision of Real (plus the smallest normal number), or the largest
///         weight is so small that this test would mean nothing
template <class Real>
bool factorizeRow(const OuterProduct& product, std::span<const Real> weights,
                  std::span<Real> factors);

}  // namespace espalier::osd
