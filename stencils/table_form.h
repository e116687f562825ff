// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/stencils/embedding.h>
#include <espalier/stencils/factored_table.h>
#include <espalier/stencils/limit_binding.h>

#include <span>
#include <vector>

// The forms in which points are bound: D, its factors, or D with its gradients. What binding does
// differently for each is here.
namespace espalier::stencils {

/// Some of the points of a group, as they were bound.
template <class Table>
struct BoundPart {
    std::vector<Index> points;  ///< which, counted from 0
    std::vector<PointStatus> statuses;
    double largestResidual = 0;
    Table table;  ///< a row for each, without entries where it has no place
};

template <class Table>
struct TableForm;

template <class Real>
struct TableForm<StencilTable<Real>> {
    using Table = StencilTable<Real>;

    /// \param tables the level tables of `refiner`
    static Table build(const far::TopologyRefiner& refiner,
                       std::span<const StencilTable<double>> tables, const Embedding& embedding);

    /// \param weights W of the points
    /// \param stencils S of the whole level
    /// \param order of the rows of W
    static Table build(StencilTable<double> weights, const StencilTable<double>& stencils,
                       const RowOrder& order);

    /// The rows that tell which points have a place.
    static const StencilTable<Real>& rowsOf(const Table& table) { return table; }

    /// Puts the rows of all parts into one table, and empties theirs.
    /// \param parts with the numbers of their points in the whole model
    static Table gather(std::vector<BoundPart<Table>>& parts, Index rowCount, Index columnCount);
};

/// Vertices between the points of two groups are there twice.
template <class Real>
struct TableForm<FactoredTable<Real>> {
    using Table = FactoredTable<Real>;

    static Table build(const far::TopologyRefiner& refiner,
                       std::span<const StencilTable<double>> tables, const Embedding& embedding);
    static Table build(StencilTable<double> weights, const StencilTable<double>& stencils,
                       const RowOrder& order);
    static const StencilTable<Real>& rowsOf(const Table& table) { return table.points; }
    static Table gather(std::vector<BoundPart<Table>>& parts, Index rowCount, Index columnCount);
};

template <class Real>
struct TableForm<LimitTable<Real>> {
    using Table = LimitTable<Real>;

    static const StencilTable<Real>& rowsOf(const Table& table) { return table.points; }
    static Table gather(std::vector<BoundPart<Table>>& parts, Index rowCount, Index columnCount);
};

}  // namespace espalier::stencils
