// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/osd/compiled_table.h>

#include <cstddef>
#include <memory>

namespace espalier::osd {

/// Evaluates the adjoint Dᵀ of a table: it turns gradients by the points of a model into gradients
/// by the vertices of its lattice.
///
/// The rows of the adjoint are the columns of the table, and its columns are the rows of the table.
/// Rows have the same groups as in CompiledTable, and identical weights are stored once, but in
/// another order: each lane of a register has the weight of another column. Each group of rows is
/// summed for its own columns first; then, for each column of the table, the sums of the groups and
/// the entries of the remaining rows are added. No two threads add to the same number.
///
/// The error is at most 4 ulp of Σ |w · x| plus 1 ulp for each entry of the column; in practice it
/// grows by 1 ulp when the number of entries doubles. A source value that is not finite may also
/// reach columns of its group whose weight for it is 0.
///
/// Immutable, so threads may share it. Copies share the data.
///
/// \cost of an evaluation: O(entries × components), in parallel, whatever the range; memory for the
///       sums of the groups, which a workspace keeps for the next evaluation
/// \cite MacCracken & Joy 1996, section 5: D is linear, so Dᵀ is the adjoint of its derivative
template <class Real>
class ESPALIER_API CompiledAdjoint : public CompiledForm<CompiledAdjoint<Real>, Real> {
public:
    /// \param table D, not its transpose
    /// \param simd selects the kernels that evaluate it
    /// \throws Error if this processor does not have `simd`
    /// \cost O(entries + rows log rows)
    explicit CompiledAdjoint(const stencils::StencilTable<Real>& table, Simd simd = bestSimd());

    Index rowCount() const;     ///< number of columns of the table
    Index columnCount() const;  ///< number of rows of the table

    /// Memory of the adjoint, in bytes.
    std::size_t byteCount() const;

    /// As CompiledTable::workspaceBytes() and evaluateIn(). The source is never copied.
    std::size_t workspaceBytes(Offset length, bool) const;
    void evaluateIn(std::byte* memory, Values<Real> source, const BufferDescriptor& sourceLayout,
                    MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                    RowRange rows, const Addend<Real>& addend) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

}  // namespace espalier::osd
