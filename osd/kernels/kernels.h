// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/osd/kernels/simd.h>

#include <utility>

// The inner loops of compiled tables, compiled once for each kind of processor and chosen when the
// program runs. They see plain arrays only: nothing that is inline elsewhere may be compiled here
// with instructions that other processors lack.
namespace espalier::osd::kernels {

/// Rows of a panel: as many as a register of AVX-512 holds numbers.
template <class Real>
inline constexpr Index kLanes = static_cast<Index>(64 / sizeof(Real));

/// The components of an entry take the room of a multiple of this. What lies behind them is read,
/// and makes no difference.
inline constexpr Offset kPadding = 4;

/// Columns of rows that are outer products, at most.
inline constexpr Index kMaxProductColumns = 512;

/// Where results go: component c of row r to values[r · stride + c], for rows first to last − 1.
template <class Real>
struct Destination {
    Real* values;
    Offset stride;
    Offset length;
    Index first, last;
    bool isWhole;  ///< whether that is all rows of the table, and need not be looked at
};

/// Rows that share their columns, kLanes by kLanes; the last panel may have fewer.
template <class Real>
struct PanelRun {
    const Real* weights;  ///< panels × columnCount × kLanes, aligned to 64 bytes
    const Real* points;   ///< columnCount × pointStride: the source entries of the columns
    Offset pointStride;   ///< a multiple of kPadding
    Index columnCount;
    const Index* rows;  ///< rowCount
    Index rowCount;
};

/// Rows that share their columns and are outer products (outer_product.h), kLanes by kLanes; the
/// last panel may have fewer.
template <class Real>
struct ProductRun {
    const Real* factors;  ///< panels × (size[0] + size[1] + size[2]) × kLanes, aligned to 64 bytes
    const Real* points;   ///< size[0] · size[1] · size[2] × pointStride, in the product's order
    Offset pointStride;   ///< a multiple of kPadding
    Index size[3];
    const Index* rows;  ///< rowCount
    Index rowCount;
};

/// Rows of the same number of entries, each with columns of its own.
template <class Real>
struct RowRun {
    const Real* weights;   ///< rowCount × length; or, if shared, length
    bool isShared;         ///< whether all rows have the same weights
    const Index* columns;  ///< rowCount × length
    Index length;
    const Real* points;  ///< all source entries, aligned to kPadding numbers
    Offset pointStride;  ///< a multiple of kPadding
    const Index* rows;   ///< rowCount
    Index rowCount;
};

/// Rows that share their columns, for the adjoint: panels of weights where size[0] is 0, else
/// factors of outer products, both as above.
template <class Real>
struct AdjointRun {
    const Real* numbers;
    Index size[3];
    Index columnCount;
    const Index* rows;  ///< rowCount
    Index rowCount;

    // How many there are from `rows` and from `numbers` on that this run takes and those after it
    // do: to look ahead at. 0 where that is not worth it.
    Offset rowsToCome;
    Offset numbersToCome;
};

/// Values of the rows: component c of row r is values[r · stride + c].
template <class Real>
struct RowValues {
    const Real* values;
    Offset stride;
    Offset length;
};

template <class Real>
struct ESPALIER_API Kernels {
    void (*panels)(const PanelRun<Real>& run, const Destination<Real>& to);
    void (*products)(const ProductRun<Real>& run, const Destination<Real>& to);
    void (*rows)(const RowRun<Real>& run, const Destination<Real>& to);
    /// Σ over the rows of weight times value, for each column.
    /// \param result columnCount × length, one column after the other
    /// \param sums room for 4 · kLanes numbers a column, aligned to 64 bytes
    void (*adjoint)(const AdjointRun<Real>& run, const RowValues<Real>& source, Real* result,
                    Real* sums);
};

/// \param simd one that hasSimd()
template <class Real>
ESPALIER_API const Kernels<Real>& kernelsFor(Simd simd);
template <>
ESPALIER_API const Kernels<float>& kernelsFor<float>(Simd simd);
template <>
ESPALIER_API const Kernels<double>& kernelsFor<double>(Simd simd);

}  // namespace espalier::osd::kernels
