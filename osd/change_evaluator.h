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

/// Evaluates only the rows that depend on a few changed vertices of a lattice, for example while
/// one of them is dragged.
///
/// A row depends on the columns for which it has a weight other than 0. In a subdivided lattice, a
/// vertex affects points in the cells around it and in the cells around these.
///
/// The evaluator shares the data of the compiled table. In addition it holds, for each column, an
/// index of the rows that depend on it: one number and one byte for each column of each group of
/// rows, and one number for each entry of the remaining rows.
///
/// Where nearly all rows depend on the changed columns, a whole evaluation is faster
/// (docs/performance.md). There is none for a CompiledChain, in which every row depends on all
/// intermediate values.
///
/// Immutable, so threads may share it. Copies share the data.
template <class Real>
class ESPALIER_API ChangeEvaluator {
public:
    /// \param table may be destroyed after this call
    /// \cost O(entries)
    explicit ChangeEvaluator(const CompiledTable<Real>& table);

    Index rowCount() const;
    Index columnCount() const;

    /// Memory of the evaluator in bytes, without the memory of the compiled table.
    std::size_t byteCount() const;

    /// Evaluates the rows that depend on one of the `changed` columns, with the same results as
    /// CompiledTable::evaluate(), bit for bit. It writes no other rows. So if the destination holds
    /// the results for one source, and the next source differs from that in the changed columns
    /// only, the destination then holds the results for the next source. All values must be finite.
    ///
    /// \param changed columns, in any order; duplicates count once
    /// \throws Error as checkEvaluation() says, for all rows, and if a column is not in the table;
    ///         nothing has been written then
    /// \cost O(entries of these rows × components), in parallel, and O(rows / 64)
    void evaluateChanged(Values<Real> source, const BufferDescriptor& sourceLayout,
                         MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                         std::span<const Index> changed, const Addend<Real>& addend = {}) const {
        Workspace own;
        evaluateChanged(source, sourceLayout, destination, destinationLayout, changed, own, addend);
    }

    /// Does the same with temporary memory from `workspace`: for real time.
    void evaluateChanged(Values<Real> source, const BufferDescriptor& sourceLayout,
                         MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                         std::span<const Index> changed, Workspace& workspace,
                         const Addend<Real>& addend = {}) const;

    /// Returns a workspace that is large enough for entries of `length` components, in any layout,
    /// and for any changed columns.
    /// \throws Error as checkLength() does; std::bad_alloc if there is not enough memory
    Workspace workspace(Offset length) const;

    /// Returns the rows that evaluateChanged() writes, ascending, so that the caller can update
    /// what depends on them.
    /// \throws Error if a column is not in the table
    std::vector<Index> rowsOf(std::span<const Index> changed) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

}  // namespace espalier::osd
