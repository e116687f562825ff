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
/// factors of a deformation table, or the level tables R_1 to R_n.
///
/// Immutable, and so safe to share between threads.
template <class Real>
class ESPALIER_API CompiledChain {
public:
    /// \param tables T_1 to T_n, at least one
    /// \throws Error if there are none, if one has not the columns that the one before has rows, or
    ///         if this processor does not have `simd`
    /// \cost that of compiling each
    explicit CompiledChain(std::span<const stencils::StencilTable<Real>> tables,
                           Simd simd = bestSimd());

    /// D, by its factors.
    explicit CompiledChain(const stencils::FactoredTable<Real>& table, Simd simd = bestSimd());

    Index rowCount() const { return steps_.back().rowCount(); }
    Index columnCount() const { return steps_.front().columnCount(); }

    /// Memory that it takes.
    std::size_t byteCount() const;

    /// As checkEvaluation() says, for the product of the tables. All rows of all tables but the
    /// last are evaluated, whatever the range. Results are off the sums of the product by no more
    /// than the bounds of CompiledTable::evaluate(), one after the other. They do not depend on the
    /// number of threads, nor on the range, bit for bit.
    ///
    /// \cost that of each table; memory for the values between them
    void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                  MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows) const;

    /// The same in memory that is kept: for real time (workspace.h).
    void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                  MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows, Workspace& workspace) const;

    /// One that is large enough for entries of so many components, in any layout.
    /// \throws Error as checkLength() does; std::bad_alloc if there is not enough memory
    Workspace workspace(Offset length) const;

private:
    std::vector<CompiledTable<Real>> steps_;
};

/// The adjoint of such a chain, T_1ᵀ · (… · (T_nᵀ · source)): gradients by the points of a model
/// become gradients by the vertices of its lattice.
///
/// Immutable, and so safe to share between threads.
template <class Real>
class ESPALIER_API CompiledAdjointChain {
public:
    /// \param tables T_1 to T_n, not their transposes, at least one
    /// \throws Error as CompiledChain
    /// \cost that of compiling each
    explicit CompiledAdjointChain(std::span<const stencils::StencilTable<Real>> tables,
                                  Simd simd = bestSimd());

    /// Dᵀ, by the factors of D.
    explicit CompiledAdjointChain(const stencils::FactoredTable<Real>& table,
                                  Simd simd = bestSimd());

    Index rowCount() const { return steps_.back().rowCount(); }         ///< columns of T_1
    Index columnCount() const { return steps_.front().columnCount(); }  ///< rows of T_n

    /// Memory that it takes.
    std::size_t byteCount() const;

    /// As checkEvaluation() says, for the transpose of the product. Results are off its sums by no
    /// more than the bounds of CompiledAdjoint::evaluate(), one after the other. They do not depend
    /// on the number of threads, nor on the range, bit for bit.
    ///
    /// \cost that of each table; memory for the values between them
    void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                  MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows) const;

    /// The same in memory that is kept: for real time (workspace.h).
    void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                  MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows, Workspace& workspace) const;

    /// One that is large enough for entries of so many components, in any layout.
    /// \throws Error as checkLength() does; std::bad_alloc if there is not enough memory
    Workspace workspace(Offset length) const;

private:
    std::vector<CompiledAdjoint<Real>> steps_;  ///< T_nᵀ first
};

}  // namespace espalier::osd
