// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/osd/evaluation.h>
#include <espalier/osd/kernels/simd.h>

#include <cstddef>
#include <memory>
#include <type_traits>

namespace espalier::osd {

template <class Real>
class ChangeEvaluator;

/// Implements evaluate() for all compiled forms of tables: CompiledTable, CompiledAdjoint and their
/// chains. The documentation of each Form says what it computes and how exactly.
///
/// \tparam Form has rowCount(), columnCount(), workspaceBytes() and evaluateIn()
template <class Form, class Real>
class ESPALIER_API CompiledForm {
public:
    /// Evaluates `rows`, with the contract of checkEvaluation(). Results do not depend on the
    /// number of threads or on the range, bit for bit.
    void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                  MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows, const Addend<Real>& addend = {}) const {
        Workspace own;
        evaluate(source, sourceLayout, destination, destinationLayout, rows, own, addend);
    }

    /// Does the same with temporary memory from `workspace`: for real time.
    void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                  MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows, Workspace& workspace, const Addend<Real>& addend = {}) const;

    /// Returns a workspace that is large enough for entries of `length` components, in any layout.
    /// \throws Error as checkLength() does; std::bad_alloc if there is not enough memory
    Workspace workspace(Offset length) const;

private:
    const Form& form() const { return static_cast<const Form&>(*this); }
};

/// A stencil table in the form that is fastest to evaluate. It holds all weights of the table that
/// it is made from, and does not refer to that table.
///
/// Each row is stored in one of three forms:
///
/// - Rows with the same columns form a group, and the columns are stored once for the group.
///   Examples are points that are bound to one base cell and level-n vertices of one base face. The
///   weights of a group form panels, in which one register holds weights of several rows.
/// - A group of outer products (compile/outer_product.h), as in regular regions, stores only the
///   factors of each row: 12 numbers instead of 64.
/// - All other rows are stored as in the table, grouped by length.
///
/// Identical weights are stored once, for example the weights of rows with the same mask, or of
/// groups that are alike, such as the faces of a regular surface. Results are in the order of the
/// table.
///
/// Each result is within 4 ulp of Σ |w · x| for rows of up to 64 entries; for longer rows the bound
/// grows by 1 ulp for each 32 entries. The error has two causes: terms are not added in the order
/// of the columns, and products of factors differ slightly from the weights. A source value that is
/// not finite may also reach rows of its group whose weight for it is 0. Results of two instruction
/// sets (Simd) may differ, within this bound; the compiler and its tuning change nothing.
///
/// Immutable, so threads may share it. Copies share the data.
///
/// \cost of an evaluation: O(entries of the range × components), in parallel, and one check for
///       each group. The source is copied unless its stride is its length rounded up to a multiple
///       of 4 and its first entry is aligned to 4 numbers; the numbers between the entries may have
///       any values then. Memory is allocated for the copy, and for groups of very many columns
///       (more than 1024 with 3 components in float)
/// \cite MacCracken & Joy 1996, section 5: the deformation is evaluated again for each pose
template <class Real>
class ESPALIER_API CompiledTable : public CompiledForm<CompiledTable<Real>, Real> {
public:
    /// \param simd selects the kernels that evaluate it
    /// \throws Error if this processor does not have `simd`
    /// \cost O(entries + rows log rows)
    explicit CompiledTable(const stencils::StencilTable<Real>& table, Simd simd = bestSimd());

    Index rowCount() const;
    Index columnCount() const;

    /// Number of rows in groups, outer products included.
    Index panelRowCount() const;
    Index productRowCount() const;

    /// Memory of this table, in bytes.
    std::size_t byteCount() const;

    /// Returns the size in bytes of the memory that evaluateIn() needs for entries of `length`
    /// components.
    /// \param hasPaddedSource true if the layout of the source needs no copy
    std::size_t workspaceBytes(Offset length, bool hasPaddedSource) const;

    /// Evaluates without checks, in memory of the caller that is aligned to 64 bytes.
    void evaluateIn(std::byte* memory, Values<Real> source, const BufferDescriptor& sourceLayout,
                    MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                    RowRange rows, const Addend<Real>& addend) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;

    friend class ChangeEvaluator<Real>;
};

/// Compiles a table or its factors, which are in double, in the precision Real.
/// \tparam Form CompiledTable, CompiledAdjoint or CompiledChain
/// \throws Error, \cost as the constructor of the form
template <template <class> class Form, class Real, class Table>
Form<Real> compile(const Table& table) {
    if constexpr (std::is_same_v<Real, double>)
        return Form<Real>(table);
    else
        return Form<Real>(stencils::convertTable<Real>(table));
}

}  // namespace espalier::osd
