// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/osd/evaluation.h>
#include <espalier/osd/kernels/simd.h>

#include <cstddef>
#include <memory>

namespace espalier::osd {

template <class Real>
class ChangeEvaluator;

/// How all compiled forms of tables are evaluated: CompiledTable, CompiledAdjoint, and their
/// chains. What results are, and how exact, is said in Form.
///
/// \tparam Form has rowCount(), columnCount(), roomFor() and evaluateIn()
template <class Form, class Real>
class ESPALIER_API CompiledForm {
public:
    /// As checkEvaluation() says. Results do not depend on the number of threads, nor on the range,
    /// bit for bit.
    void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                  MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows) const {
        Workspace own;
        evaluate(source, sourceLayout, destination, destinationLayout, rows, own);
    }

    /// The same in memory that is kept: for real time (Workspace).
    void evaluate(Values<Real> source, const BufferDescriptor& sourceLayout,
                  MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows, Workspace& workspace) const;

    /// One that is large enough for entries of so many components, in any layout.
    /// \throws Error as checkLength() does; std::bad_alloc if there is not enough memory
    Workspace workspace(Offset length) const;

private:
    const Form& form() const { return static_cast<const Form&>(*this); }
};

/// A stencil table in the form that is fastest to evaluate. The table itself stays the truth; this
/// holds all of its weights, and does not refer to it.
///
/// Rows with the same columns — points that are bound to one cell of the base, level-n vertices of
/// one base face — become panels: their columns are there once, and their weights lie so that one
/// register holds those of several rows. Of those that are outer products (outer_product.h), as in
/// regular regions, just the factors are kept: 12 numbers instead of 64. All other rows lie as in
/// the table, those of one length together. Weights that come again are there once: those of the
/// faces of a regular surface, whose panels are alike, and those of rows of one mask. Results come
/// out in the order of the table.
///
/// Results are within 4 ulp of Σ |w · x| in rows of up to 64 entries, and of longer ones within one
/// more for each 32: sums are made in another order than that of the columns, and weights of outer
/// products are a little off. A source value that is not finite may reach rows beside its own,
/// whose weight for it is 0.
///
/// Immutable, and so safe to share between threads. Copies share the numbers.
///
/// \cost of an evaluation: O(entries of the range × components), in parallel, and a look at each
///       group of rows; a copy of the source, unless its stride is its length rounded up to a
///       multiple of 4, and the first entry is at a multiple of 4 numbers in memory. What lies
///       between such entries makes no difference. The copy is allocated, and what rows of very
///       many columns need (more than 1024 of xyz in float)
/// \cite MacCracken & Joy 1996, section 5: the deformation is evaluated again for each pose
template <class Real>
class ESPALIER_API CompiledTable : public CompiledForm<CompiledTable<Real>, Real> {
public:
    /// \param simd which kernels evaluate it
    /// \throws Error if this processor does not have `simd`
    /// \cost O(entries + rows log rows)
    explicit CompiledTable(const stencils::StencilTable<Real>& table, Simd simd = bestSimd());

    Index rowCount() const;
    Index columnCount() const;

    /// Rows that lie in panels, outer products among them.
    Index panelRowCount() const;
    Index productRowCount() const;

    /// Memory that it takes.
    std::size_t byteCount() const;

    /// Memory of the caller's that an evaluation takes: bytes, for entries of so many components.
    /// \param hasPaddedSource whether the source lies so that it is not copied
    std::size_t roomFor(Offset length, bool hasPaddedSource) const;

    /// evaluate() of arguments that are checked, in such memory, aligned to 64 bytes.
    void evaluateIn(std::byte* memory, Values<Real> source, const BufferDescriptor& sourceLayout,
                    MutableValues<Real> destination, const BufferDescriptor& destinationLayout,
                    RowRange rows) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;

    friend class ChangeEvaluator<Real>;
};

}  // namespace espalier::osd
