// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/stencils/factored_table.h>

#include <cstddef>
#include <span>
#include <vector>

namespace espalier::osd {

/// Tables that are applied one after the other, T_n · (… · (T_1 · source)), each compiled: the two
/// factors of a deformation table, or the level tables R_1 to R_n. Or the adjoint of such a chain,
/// T_1ᵀ · (… · (T_nᵀ · source)): gradients by the points of a model become gradients by the
/// vertices of its lattice.
///
/// An evaluation evaluates all rows of all steps but the last, whatever the range. Results are off
/// the sums of the product by no more than the bounds of the steps, one after the other.
///
/// Immutable, and so safe to share between threads.
///
/// \tparam Step CompiledTable<Real>; CompiledAdjoint<Real> for the adjoint
/// \cost of an evaluation: that of each table; memory for the values between them
template <class Step, class Real>
class ESPALIER_API StepChain : public CompiledForm<StepChain<Step, Real>, Real> {
public:
    /// \param tables T_1 to T_n, not their transposes, at least one
    /// \throws Error if there are none, if one has not the columns that the one before has rows, or
    ///         if this processor does not have `simd`
    /// \cost that of compiling each
    explicit StepChain(std::span<const stencils::StencilTable<Real>> tables,
                       Simd simd = bestSimd());

    /// D or Dᵀ, by the factors of D.
    explicit StepChain(const stencils::FactoredTable<Real>& table, Simd simd = bestSimd());

    Index rowCount() const { return steps_.back().rowCount(); }
    Index columnCount() const { return steps_.front().columnCount(); }

    /// Memory that it takes.
    std::size_t byteCount() const;

    /// As those of CompiledTable; room is taken for a copy of any source.
    std::size_t roomFor(Offset length, bool) const;
    void evaluateIn(std::byte* memory, Values<Real> source, const BufferDescriptor& sourceLayout,
                    MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                    RowRange rows) const;

private:
    std::vector<Step> steps_;  ///< in the order of their evaluation
};

template <class Real>
using CompiledChain = StepChain<CompiledTable<Real>, Real>;
template <class Real>
using CompiledAdjointChain = StepChain<CompiledAdjoint<Real>, Real>;

}  // namespace espalier::osd
