// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/kernels/kernels.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace espalier::osd {

/// How the columns that some rows share lie in a box, so that the rows are outer products: the
/// weight of column order[(k·size[1] + j)·size[0] + i] is a_i · b_j · c_k, with a, b and c of each
/// row.
///
/// In regular regions rows are such: level-n vertices of a tensor-product spline, points bound to
/// its cells by trilinear weights or in the limit, and derivatives there, whose weights have either
/// sign.
struct OuterProduct {
    std::array<Index, 3> size = {};  ///< 1 or more; descending
    std::vector<Index> order = {};   ///< positions in the columns of a row
};

/// Finds the order from the weights alone, as what their logarithms say: those of an outer product
/// are sums α_i + β_j + γ_k.
///
/// \param rows the weights of rows with the same columns
/// \return nothing if no box is found, or one along a single axis, which saves nothing, or if there
///         are over kernels::kMaxProductColumns. The rows looked at are a few: whether one is an
///         outer product, factorsOf() says.
/// \cost O(columns² log columns)
template <class Real>
std::optional<OuterProduct> findOuterProduct(std::span<const std::span<const Real>> rows);

/// The factors of a row: size[0] + size[1] + size[2] numbers, a then b then c.
///
/// \return false if a weight is off its product by more than three times the precision of Real, and
///         by more than the least normal number; or if that is not far below the largest weight
template <class Real>
bool factorizeRow(const OuterProduct& product, std::span<const Real> weights,
                  std::span<Real> factors);

}  // namespace espalier::osd
