// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "../compile/table_compiler.h"
#include "device_adjoint_kernels.h"
#include "device_table.h"
#include "spline_rows.h"

namespace espalier::osd::device {
namespace {

using stencils::StencilTable;

/// Maximum number of entries of a segment, and of slots of a sum. A longer one would still run
/// when all others are done.
constexpr Offset kMaxEntries = 1024;

/// Returns the rows of a table without copying them. The table must live longer.
template <class Real>
SparseArrays<Real> borrowedRows(const StencilTable<Real>& table) {
    SparseArrays<Real> rows;
    rows.offsets = table.offsets();
    rows.columns = table.columns();
    rows.weights = table.weights();
    return rows;
}

template <class Real>
SparseArrays<Real> ownRows(StencilTable<Real> table) {
    SparseArrays<Real> rows = borrowedRows(table);
    rows.table = std::move(table);  // The move leaves the arrays where they are, so the spans stay
                                    // valid.
    return rows;
}

/// Rows, cut into segments of at most kMaxEntries entries.
struct RowSegments {
    std::vector<Offset> offsets = {0};  ///< offsets of the segments in the entries
    /// The first segment of each row; at the end, the number of segments.
    std::vector<Offset> firstSegments = {};
};

RowSegments splitRows(std::span<const Offset> offsets) {
    RowSegments cut;
    for (std::size_t row = 0; row + 1 < offsets.size(); ++row) {
        cut.firstSegments.push_back(std::ssize(cut.offsets) - 1);
        for (Offset first = offsets[row]; first < offsets[row + 1]; first += kMaxEntries)
            cut.offsets.push_back(std::min(first + kMaxEntries, offsets[row + 1]));
    }
    cut.firstSegments.push_back(std::ssize(cut.offsets) - 1);
    return cut;
}

}  // namespace

template <class Real>
TableArrays<Real>::TableArrays(const StencilTable<Real>& table, bool isGrouped, bool hasParameters)
    : rowCount(table.rowCount()), columnCount(table.columnCount()) {
    if (!isGrouped) {
        ungrouped = borrowedRows(table);
        return;
    }
    CompiledRows<Real> compiled = compileRows(table);
    const std::vector<Index> splines = hasParameters
                                           ? storeSplineParameters(compiled)
                                           : std::vector<Index>(compiled.groups.size(), kNoSpline);
    groupColumns = std::move(compiled.groupColumns);
    groupNumbers = std::move(compiled.groupNumbers);
    groupRows = std::move(compiled.groupRows);
    for (const auto& group : compiled.groups) {
        const auto& size = group.size;
        const auto number = static_cast<Index>(groups.size());
        groups.push_back({group.firstColumn,
                          group.firstNumber,
                          group.firstRow,
                          group.columnCount,
                          group.rowCount,
                          group.lowest,
                          group.highest,
                          {size[0], size[1], size[2]},
                          splines[number]});
        if (splines[number] != kNoSpline) parametricRowCount += group.rowCount;
        std::vector<Task>* tasks = &panels;
        if (size[0] > 0) {
            const auto* const last = std::end(kSizes) - 1;
            const auto* const kind = std::find(std::begin(kSizes), last, size[0]);
            if (kind == last) maxProductColumns = std::max(maxProductColumns, group.columnCount);
            tasks = &products[splines[number] != kNoSpline ? kSplines : kind - std::begin(kSizes)];
        }
        for (Index first = 0; first < group.rowCount; first += kWarp * kRowsPerLane<Real>)
            tasks->push_back({number, first});
    }
    std::sort(compiled.rows.begin(), compiled.rows.end());
    ungrouped = ownRows(stencils::selectRows<Real>(table, compiled.rows));
    ungrouped.ownRows = std::move(compiled.rows);
    ungrouped.rows = ungrouped.ownRows;
}

template <class Real>
AdjointArrays<Real>::AdjointArrays(const StencilTable<Real>& table,
                                   const TableArrays<Real>& arrays) {
    for (Index number = 0; number < std::ssize(arrays.groups); ++number) {
        const Group& group = arrays.groups[number];
        const bool isProduct = group.size[0] > 0;
        const Index tiles = isProduct ? AdjointProductKernel<false, 1, Real>::tileCount(group)
                                      : AdjointPanelKernel<1, Real>::tileCount(group);
        std::vector<Task>& tasks = group.spline != kNoSpline ? splines
                                   : isProduct               ? products
                                                             : panels;
        for (Index tile = 0; tile < tiles; ++tile) tasks.push_back({number, tile});
    }

    // The columns of the ungrouped rows.
    segments =
        ownRows(arrays.groups.empty()
                    ? stencils::transposeTable(table)
                    : stencils::transposeTable(rowsOnly<Real>(table, arrays.ungrouped.rows)));
    RowSegments cut = splitRows(segments.offsets);
    segments.ownOffsets = std::move(cut.offsets);
    segments.offsets = segments.ownOffsets;
    firstSegment = std::ssize(arrays.groupColumns);
    slotCount = firstSegment + segments.count();

    // For each column, the slots of the sums that add up to its result.
    const InverseIndex<Offset> slots(table.columnCount(), [&](auto found) {
        for (Offset slot = 0; slot < firstSegment; ++slot) found(arrays.groupColumns[slot], slot);
        for (Index column = 0; column < table.columnCount(); ++column)
            for (Offset i = cut.firstSegments[column]; i < cut.firstSegments[column + 1]; ++i)
                found(column, firstSegment + i);
    });
    std::vector<Offset> offsets = {0}, summands;
    for (Index column = 0; column < table.columnCount(); ++column) {
        const auto own = slots.of(column);
        summands.insert(summands.end(), own.begin(), own.end());
        offsets.push_back(std::ssize(summands));
    }
    const auto addStep = [&](std::vector<Offset> stepOffsets) {
        if (slotCount > std::numeric_limits<Index>::max())
            throw Error(concat("the adjoint of this table has ", slotCount,
                               " partial sums; at most ", std::numeric_limits<Index>::max(),
                               " are possible"));
        SparseArrays<Real> rows;
        rows.ownOffsets = std::move(stepOffsets);
        rows.ownColumns.assign(summands.begin(), summands.end());
        rows.offsets = rows.ownOffsets;
        rows.columns = rows.ownColumns;
        steps.push_back({std::move(rows), slotCount});
    };
    const auto longest = [&] {
        Offset maximum = 0;
        for (std::size_t i = 0; i + 1 < offsets.size(); ++i)
            maximum = std::max(maximum, offsets[i + 1] - offsets[i]);
        return maximum;
    };
    while (longest() > kMaxEntries) {
        RowSegments parts = splitRows(offsets);
        addStep(std::move(parts.offsets));
        summands.resize(steps.back().rows.count());
        std::iota(summands.begin(), summands.end(), slotCount);
        slotCount += steps.back().rows.count();
        offsets = std::move(parts.firstSegments);
    }
    addStep(std::move(offsets));
}

template <class Real>
int lanesLog2Of(const SparseArrays<Real>& rows) {
    const Offset count = std::max(rows.count(), Index{1});
    int log2 = 0;
    while (1 << log2 < kWarp && (8 << log2) * count <= std::ssize(rows.columns)) ++log2;
    return log2;
}

template struct TableArrays<float>;
template struct TableArrays<double>;
template struct AdjointArrays<float>;
template struct AdjointArrays<double>;
template int lanesLog2Of(const SparseArrays<float>&);
template int lanesLog2Of(const SparseArrays<double>&);

}  // namespace espalier::osd::device
