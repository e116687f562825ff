// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/evaluation.h>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace espalier::osd {

/// Evaluates again what a few moved vertices of a lattice carry, and nothing else: while one of
/// them is dragged, for example.
///
/// A row depends on the columns that it has weights for other than 0. Of a subdivided lattice a
/// vertex carries what is in the cells around it and in those around these.
///
/// It shares the numbers of the compiled table, and holds beside them, of each column, which rows
/// depend on it: an index for each column of each group of rows that share theirs, and one for each
/// entry of the other rows.
///
/// Where nearly all rows depend on what has changed, a whole evaluation is quicker
/// (docs/performance.md). For whole tables: of a CompiledChain everything depends on what lies
/// between its tables.
///
/// Immutable, and so safe to share between threads. Copies share the numbers.
template <class Real>
class ESPALIER_API ChangeEvaluator {
public:
    /// \param table need not live longer than this call
    /// \cost O(entries)
    explicit ChangeEvaluator(const CompiledTable<Real>& table);

    Index rowCount() const;
    Index columnCount() const;

    /// Memory that it takes besides that of the compiled table.
    std::size_t byteCount() const;

    /// Evaluates the rows that depend on one of `changed`, as CompiledTable::evaluate() does, bit
    /// for bit, and writes no others. So a destination that held what that gives for one source
    /// holds what it gives for another, if the two differ in these columns only and are finite.
    ///
    /// \param changed columns, in any order; one that is there twice counts once
    /// \throws Error as checkEvaluation() says, for all rows, and if a column is not in the table;
    ///         nothing has been written then
    /// \cost O(entries of these rows × components), in parallel, and O(rows / 64)
    void evaluateChanged(Values<Real> source, const BufferDescriptor& sourceLayout,
                         MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                         std::span<const Index> changed) const {
        Workspace own;
        evaluateChanged(source, sourceLayout, destination, destinationLayout, changed, own);
    }

    /// The same in memory that is kept: for real time (Workspace).
    void evaluateChanged(Values<Real> source, const BufferDescriptor& sourceLayout,
                         MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                         std::span<const Index> changed, Workspace& workspace) const;

    /// One that is large enough for entries of so many components, in any layout, and any columns.
    /// \throws Error as checkLength() does; std::bad_alloc if there is not enough memory
    Workspace workspace(Offset length) const;

    /// The rows that evaluateChanged() writes, ascending: for what a host derives from them.
    /// \throws Error if a column is not in the table
    std::vector<Index> rowsOf(std::span<const Index> changed) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

}  // namespace espalier::osd
