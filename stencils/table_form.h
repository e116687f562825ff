// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/embedding.h>
#include <espalier/stencils/factored_table.h>

#include <span>
#include <vector>

// Points are bound to D or to its factors. These overloads are the steps that differ between the
// two. The limit binds to D with its gradients, and adds overloads of pointRows() and gatherRows()
// (limit_binding.cpp).
namespace espalier::stencils {

/// Some of the points of a group, as they were bound.
template <class Table>
struct BoundPart {
    std::vector<Index> points;  ///< which, counted from 0
    std::vector<PointStatus> statuses;
    double largestResidual = 0;
    Table table;  ///< a row for each, without entries where it has no place
};

/// The rows that tell which points have a place.
template <class Real>
const StencilTable<Real>& pointRows(const StencilTable<Real>& table) {
    return table;
}
template <class Real>
const StencilTable<Real>& pointRows(const FactoredTable<Real>& table) {
    return table.points;
}

/// Makes the table of points whose cells are cells of a level.
/// \param tables the level tables of `refiner`
template <class Real>
void buildRows(const far::TopologyRefiner& refiner, std::span<const StencilTable<double>> tables,
               const Embedding& embedding, StencilTable<Real>& result);
template <class Real>
void buildRows(const far::TopologyRefiner& refiner, std::span<const StencilTable<double>> tables,
               const Embedding& embedding, FactoredTable<Real>& result);

/// The same from the stencils of the whole level.
/// \param weights W of the points
/// \param stencils S of the whole level
/// \param order of the rows of W
template <class Real>
void buildRows(StencilTable<double> weights, const StencilTable<double>& stencils,
               const RowOrder& order, StencilTable<Real>& result);
template <class Real>
void buildRows(StencilTable<double> weights, const StencilTable<double>& stencils,
               const RowOrder& order, FactoredTable<Real>& result);

/// Puts the rows of all parts into one table, and empties the tables of the parts. A vertex of
/// factors that several parts use is repeated for each of them. \param parts with the numbers of
/// their points in the whole model
template <class Real>
void gatherRows(std::vector<BoundPart<StencilTable<Real>>>& parts, Index rowCount,
                Index columnCount, StencilTable<Real>& result);
template <class Real>
void gatherRows(std::vector<BoundPart<FactoredTable<Real>>>& parts, Index rowCount,
                Index columnCount, FactoredTable<Real>& result);

}  // namespace espalier::stencils
