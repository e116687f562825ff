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

/// Applies several compiled tables one after the other: T_n · (… · (T_1 · source)). The tables are
/// the two factors of a deformation table, for example, or the level tables R_1 to R_n. With Step =
/// CompiledAdjoint it applies the adjoint of the chain, T_1ᵀ · (… · (T_nᵀ · source)), which turns
/// gradients by the points of a model into gradients by the vertices of its lattice.
///
/// An evaluation computes all rows of every step but the last, whatever the range. The error bounds
/// of the steps add up.
///
/// Immutable, so threads may share it.
///
/// \tparam Step CompiledTable<Real>; CompiledAdjoint<Real> for the adjoint
/// \cost of an evaluation: the sum of the costs of the tables; memory for the intermediate values
template <class Step, class Real>
class ESPALIER_API StepChain : public CompiledForm<StepChain<Step, Real>, Real> {
public:
    /// \param tables T_1 to T_n, at least one; not transposed, for the adjoint too
    /// \throws Error if there are none, if the number of columns of a table differs from the number
    ///         of rows of the table before it, or if this processor does not have `simd`
    /// \cost the sum of the costs of compiling the tables
    explicit StepChain(std::span<const stencils::StencilTable<Real>> tables,
                       Simd simd = bestSimd());

    /// Makes the chain of D, or of Dᵀ, from the two factors of D.
    explicit StepChain(const stencils::FactoredTable<Real>& table, Simd simd = bestSimd());

    Index rowCount() const { return steps_.back().rowCount(); }
    Index columnCount() const { return steps_.front().columnCount(); }

    /// Memory of the chain, in bytes.
    std::size_t byteCount() const;

    /// As CompiledTable::workspaceBytes() and evaluateIn(). The size always includes a copy of the
    /// source.
    std::size_t workspaceBytes(Offset length, bool) const;
    void evaluateIn(std::byte* memory, Values<Real> source, const BufferDescriptor& sourceLayout,
                    MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                    RowRange rows, const Addend<Real>& addend) const;

private:
    std::vector<Step> steps_;  ///< the steps in the order of evaluation
};

template <class Real>
using CompiledChain = StepChain<CompiledTable<Real>, Real>;
template <class Real>
using CompiledAdjointChain = StepChain<CompiledAdjoint<Real>, Real>;

}  // namespace espalier::osd
