// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/bind/bind.h>

#include <span>
#include <vector>

// How weights change the rows of a binding.
namespace espalier::bind {

/// Multiplies rows by the weights of their points, and keeps the weights for the gradients. The
/// row of a point with the weight 0 becomes empty, and its status NotBound.
/// \param weights one per point
/// \cost O(entries), in parallel
void applyWeights(std::vector<PointWeight> weights, WeightedRows& rows);

/// Returns the rows, each times the weight of its point, and without entries where it is 0.
stencils::StencilTable<double> weighted(const stencils::StencilTable<double>& table,
                                        std::span<const PointWeight> weights);

/// Adds points that stay in place, with the status NotBound.
/// \param binding its points have weights (applyWeights()); there may be none
/// \param numbers the numbers of its points among all, ascending
void addKeptPoints(std::span<const Index> numbers, Index pointCount, Binding& binding);

}  // namespace espalier::bind
