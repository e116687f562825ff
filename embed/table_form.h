// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/embed/embedding.h>
#include <espalier/stencils/factored_table.h>

#include <span>
#include <vector>

// Points are bound to D or to its factors. These overloads are the steps that differ between the
// two. The limit binds to D with its gradients, and adds overloads of pointRows() and gatherRows()
// (limit_binding.cpp).
namespace espalier::embed {

/// Some of the points of a group, as they were bound.
template <class Table>
struct BoundPart {
    std::vector<Index> points;  ///< which, counted from 0
    std::vector<PointStatus> statuses;
    double largestResidual = 0;
    Table table;  ///< a row for each, without entries where it has no place
};

/// The rows that tell which points have a place.
inline const stencils::StencilTable<double>& pointRows(
    const stencils::StencilTable<double>& table) {
    return table;
}
inline const stencils::StencilTable<double>& pointRows(
    const stencils::FactoredTable<double>& table) {
    return table.points;
}

/// Makes the table of points whose cells are cells of a level.
/// \param tables the level tables of `refiner`
void buildRows(const far::TopologyRefiner& refiner,
               std::span<const stencils::StencilTable<double>> tables, const Embedding& embedding,
               stencils::StencilTable<double>& result);
void buildRows(const far::TopologyRefiner& refiner,
               std::span<const stencils::StencilTable<double>> tables, const Embedding& embedding,
               stencils::FactoredTable<double>& result);

/// The same from the stencils of the whole level.
/// \param weights W of the points
/// \param stencils S of the whole level
/// \param order of the rows of W
void buildRows(stencils::StencilTable<double> weights,
               const stencils::StencilTable<double>& stencils, const stencils::RowOrder& order,
               stencils::StencilTable<double>& result);
void buildRows(stencils::StencilTable<double> weights,
               const stencils::StencilTable<double>& stencils, const stencils::RowOrder& order,
               stencils::FactoredTable<double>& result);

/// Puts the rows of all parts into one table, and empties the tables of the parts. A vertex of
/// factors that several parts use is repeated for each of them. \param parts with the numbers of
/// their points in the whole model
void gatherRows(std::vector<BoundPart<stencils::StencilTable<double>>>& parts, Index rowCount,
                Index columnCount, stencils::StencilTable<double>& result);
void gatherRows(std::vector<BoundPart<stencils::FactoredTable<double>>>& parts, Index rowCount,
                Index columnCount, stencils::FactoredTable<double>& result);

}  // namespace espalier::embed
