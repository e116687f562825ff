// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/stencils/stencil_table.h>

#include <array>
#include <span>
#include <vector>

#include "../kernels/scratch.h"
#include "device_data.h"

namespace espalier::osd::device {

/// Rows in compressed form, and sums of earlier results: what SparseRows points to.
template <class Real>
struct SparseArrays {
    std::span<const Offset> offsets = kNone;
    std::span<const Index> columns = {};
    std::span<const Real> weights = {};  ///< 1 for each entry if there are none
    std::span<const Index> rows = {};    ///< row i is row i if there are none

    // What the spans are of, unless it is the caller's.
    stencils::StencilTable<Real> table = {};
    std::vector<Offset> ownOffsets = {};
    std::vector<Index> ownColumns = {}, ownRows = {};

    SparseArrays() = default;
    SparseArrays(SparseArrays&&) = default;
    SparseArrays& operator=(SparseArrays&&) = default;

    Index count() const { return static_cast<Index>(offsets.size() - 1); }

private:
    static constexpr Offset kNone[] = {0};
};

/// A table in the form in which it goes to a device: the arrays of TableView. Rows that share their
/// columns lie as in CompiledTable, outer products by their factors; all others in compressed form.
template <class Real>
struct ESPALIER_API TableArrays {
    Index rowCount, columnCount;
    std::vector<Group> groups = {};
    std::vector<Index> groupColumns = {};
    AlignedVector<Real> groupNumbers = {};
    std::vector<Index> groupRows = {};
    std::vector<Task> panels = {};
    std::array<std::vector<Task>, kSizeCount> products = {};
    Index maxProductColumns = 0;  ///< of those of kSizes 0
    SparseArrays<Real> ungrouped = {};

    /// \param table must live as long as this, unless it is grouped
    /// \param isGrouped whether to look for rows that share their columns
    /// \cost O(entries + rows log rows); ungrouped nothing, and no memory
    TableArrays(const stencils::StencilTable<Real>& table, bool isGrouped);
};

/// What the adjoint needs besides: the arrays of AdjointView.
///
/// No two warps add to the same number, so that results do not depend on which goes first: they
/// leave sums of their own in places, and steps of sums follow until each column has one.
template <class Real>
struct ESPALIER_API AdjointArrays {
    std::vector<Task> panels = {}, products = {};
    SparseArrays<Real> segments = {};
    Offset firstSegment = 0;  ///< its place
    struct Step {
        SparseArrays<Real> rows;
        Offset firstPlace;
    };
    std::vector<Step> steps = {};
    Offset placeCount = 0;

    /// \param arrays of this table
    /// \throws Error if there are more places than an Index counts
    /// \cost O(entries)
    AdjointArrays(const stencils::StencilTable<Real>& table, const TableArrays<Real>& arrays);
};

/// How many lanes, as a power of 2, go through each of these rows side by side: as many as have
/// four entries each in a row of the mean length, or more, up to a warp.
template <class Real>
ESPALIER_API int lanesLog2Of(const SparseArrays<Real>& rows);

/// \param place gives where the elements of a vector lie on the device: nothing matters where it is
///        empty, but for `offsets`
template <class Real, class Place>
SparseRows<Real> viewOf(const SparseArrays<Real>& rows, Place place) {
    return {place(rows.offsets),
            place(rows.columns),
            rows.weights.empty() ? nullptr : place(rows.weights),
            rows.rows.empty() ? nullptr : place(rows.rows),
            rows.count(),
            lanesLog2Of(rows)};
}

template <class Real, class Place>
TableView<Real> viewOf(const TableArrays<Real>& arrays, Place place) {
    const auto tasks = [&](const std::vector<Task>& list) {
        return TaskList{place(list), static_cast<Index>(list.size())};
    };
    TableView<Real> view = {arrays.rowCount,
                            arrays.columnCount,
                            {place(arrays.groups), place(arrays.groupColumns),
                             place(arrays.groupNumbers), place(arrays.groupRows)},
                            tasks(arrays.panels),
                            {},
                            arrays.maxProductColumns,
                            viewOf(arrays.ungrouped, place)};
    for (std::size_t i = 0; i < arrays.products.size(); ++i)
        view.products[i] = tasks(arrays.products[i]);
    return view;
}

/// \param steps is filled, and must live as long as the result
template <class Real, class Place>
AdjointView<Real> viewOf(const AdjointArrays<Real>& arrays, std::vector<SumStep<Real>>& steps,
                         Place place) {
    steps.clear();
    for (const auto& step : arrays.steps)
        steps.push_back({viewOf(step.rows, place), step.firstPlace});
    return {{place(arrays.panels), static_cast<Index>(arrays.panels.size())},
            {place(arrays.products), static_cast<Index>(arrays.products.size())},
            viewOf(arrays.segments, place),
            arrays.firstSegment,
            steps.data(),
            static_cast<int>(steps.size()),
            arrays.placeCount};
}

}  // namespace espalier::osd::device
