// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/osd/compiled_table.h>

#include <cstddef>
#include <memory>

namespace espalier::osd {

/// The adjoint of a table, Dᵀ, in the form that is fastest to evaluate: gradients by the points of
/// a model become gradients by the vertices of its lattice.
///
/// Its rows are the columns of the table, its columns the rows. The numbers lie as in
/// CompiledTable, and are read once: sums over the rows of each group of rows that share their
/// columns, and then the sums of these, and of the rows that are in no group, for each column of
/// the table. No two threads add to the same number.
///
/// Results are off the sums by no more than 4 ulp of Σ |w · x| and one more for each entry; in
/// practice for each doubling of their number. A source value that is not finite may reach columns
/// of its group whose weight for it is 0.
///
/// Immutable, and so safe to share between threads. Copies share the numbers.
///
/// \cost of an evaluation: O(entries × components), in parallel, whatever the range; memory for the
///       sums of the groups
/// \cite MacCracken & Joy 1996, section 5: D is linear, and so Dᵀ is its derivative's adjoint
template <class Real>
class ESPALIER_API CompiledAdjoint : public CompiledForm<CompiledAdjoint<Real>, Real> {
public:
    /// \param table D, not its transpose
    /// \param simd which kernels evaluate it
    /// \throws Error if this processor does not have `simd`
    /// \cost O(entries + rows log rows)
    explicit CompiledAdjoint(const stencils::StencilTable<Real>& table, Simd simd = bestSimd());

    Index rowCount() const;     ///< columns of the table
    Index columnCount() const;  ///< rows of the table

    /// Memory that it takes.
    std::size_t byteCount() const;

    /// As those of CompiledTable; the source is never copied.
    std::size_t roomFor(Offset length, bool) const;
    void evaluateIn(std::byte* memory, Values<Real> source, const BufferDescriptor& sourceLayout,
                    MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                    RowRange rows) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

}  // namespace espalier::osd
