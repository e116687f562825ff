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

/// The arrays to which SparseRows points: compressed sparse rows, or sums of earlier results.
template <class Real>
struct SparseArrays {
    std::span<const Offset> offsets = kNone;
    std::span<const Index> columns = {};
    std::span<const Real> weights = {};  ///< if empty, all weights are 1
    std::span<const Index> rows = {};    ///< if empty, row i is row i

    // The owned arrays to which the spans refer, unless they refer to arrays of the caller.
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

/// The arrays of a TableView, which are copied to the device. Rows that share their columns are
/// stored as in CompiledTable, outer products by their factors; all others as compressed sparse
/// rows.
template <class Real>
struct ESPALIER_API TableArrays {
    Index rowCount, columnCount;
    std::vector<Group> groups = {};
    std::vector<Index> groupColumns = {};
    AlignedVector<Real> groupNumbers = {};
    std::vector<Index> groupRows = {};
    std::vector<Task> panels = {};
    std::array<std::vector<Task>, kProductLists> products = {};
    Index maxProductColumns = 0;   ///< maximum number of columns of an outer product larger than 4
    Index parametricRowCount = 0;  ///< number of rows that are stored as three parameters
    SparseArrays<Real> ungrouped = {};

    /// \param table must live as long as this, unless isGrouped
    /// \param isGrouped true to look for rows that share their columns
    /// \param hasParameters true to store rows of splines as parameters (spline_rows.h); needs
    ///        isGrouped
    /// \cost O(entries + rows log rows); if not grouped, nothing, and no memory
    TableArrays(const stencils::StencilTable<Real>& table, bool isGrouped,
                bool hasParameters = false);
};

/// The arrays of an AdjointView: the additional data of the adjoint.
///
/// No two warps add to the same number, so results do not depend on the order in which warps run.
/// Each warp stores its own sums in slots, and further steps add these up until each column has
/// one sum.
template <class Real>
struct ESPALIER_API AdjointArrays {
    std::vector<Task> panels = {}, products = {}, splines = {};
    SparseArrays<Real> segments = {};
    Offset firstSegment = 0;  ///< slot of the sum of the first segment
    struct Step {
        SparseArrays<Real> rows;
        Offset firstSlot;
    };
    std::vector<Step> steps = {};
    Offset slotCount = 0;

    /// \param arrays made from the same table
    /// \throws Error if the number of slots exceeds the range of Index
    /// \cost O(entries)
    AdjointArrays(const stencils::StencilTable<Real>& table, const TableArrays<Real>& arrays);
};

/// Returns the logarithm to base 2 of the number of lanes that work on a row together: the largest
/// number, up to a warp, that leaves each lane at least four entries in a row of mean length.
template <class Real>
ESPALIER_API int lanesLog2Of(const SparseArrays<Real>& rows);

/// Returns a view of the arrays on the device.
/// \param toDevice returns the address of the elements of a vector on the device. For an empty
/// vector
///        any address will do
template <class Real, class ToDevice>
SparseRows<Real> viewOf(const SparseArrays<Real>& rows, ToDevice toDevice) {
    return {toDevice(rows.offsets),
            toDevice(rows.columns),
            rows.weights.empty() ? nullptr : toDevice(rows.weights),
            rows.rows.empty() ? nullptr : toDevice(rows.rows),
            rows.count(),
            lanesLog2Of(rows)};
}

template <class Real, class ToDevice>
TableView<Real> viewOf(const TableArrays<Real>& arrays, ToDevice toDevice) {
    const auto tasks = [&](const std::vector<Task>& list) {
        return TaskList{toDevice(list), static_cast<Index>(list.size())};
    };
    TableView<Real> view = {arrays.rowCount,
                            arrays.columnCount,
                            {toDevice(arrays.groups), toDevice(arrays.groupColumns),
                             toDevice(arrays.groupNumbers), toDevice(arrays.groupRows)},
                            tasks(arrays.panels),
                            {},
                            arrays.maxProductColumns,
                            viewOf(arrays.ungrouped, toDevice)};
    for (std::size_t i = 0; i < arrays.products.size(); ++i)
        view.products[i] = tasks(arrays.products[i]);
    return view;
}

/// Returns a view of the arrays on the device.
/// \param steps is filled, and must live as long as the result
template <class Real, class ToDevice>
AdjointView<Real> viewOf(const AdjointArrays<Real>& arrays, std::vector<SumStep<Real>>& steps,
                         ToDevice toDevice) {
    steps.clear();
    for (const auto& step : arrays.steps)
        steps.push_back({viewOf(step.rows, toDevice), step.firstSlot});
    return {{toDevice(arrays.panels), static_cast<Index>(arrays.panels.size())},
            {toDevice(arrays.products), static_cast<Index>(arrays.products.size())},
            {toDevice(arrays.splines), static_cast<Index>(arrays.splines.size())},
            viewOf(arrays.segments, toDevice),
            arrays.firstSegment,
            steps.data(),
            static_cast<int>(steps.size()),
            arrays.slotCount};
}

}  // namespace espalier::osd::device
