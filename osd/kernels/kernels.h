// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>
#include <espalier/osd/kernels/simd.h>

#include <limits>
#include <utility>

// The inner loops of compiled tables. They are compiled once for each instruction set, and one is
// selected when the program runs. They use plain arrays only: an inline function of another header,
// compiled here, could spread instructions that some processors lack.
namespace espalier::osd::kernels {

/// Number of rows in a panel. An AVX-512 register holds one number for each row.
template <class Real>
inline constexpr Index kLanes = static_cast<Index>(64 / sizeof(Real));

/// An entry of the source takes a multiple of this number of components. The padding is read, and
/// has no effect on results.
inline constexpr Offset kPadding = 4;

/// Maximum number of columns of rows that are outer products.
inline constexpr Index kMaxProductColumns = 512;

/// The destination of a kernel: component c of row r goes to values[r · stride + c]. Only rows
/// first to last − 1 are written. The kernel adds addend[r · addendStride + c mod addendLength] to
/// each sum, if there is an addend.
template <class Real>
struct Destination {
    Real* values;
    Offset stride;
    Offset length;
    Index first, last;
    bool isWhole;  ///< true if the range covers all rows of the table, so that kernels skip the
                   ///< range check
    const Real* addend;  ///< null: there is none
    Offset addendStride;
    Offset addendLength;  ///< divides `length`
};

/// A group of rows that share their columns, in panels of kLanes rows; the last panel may have
/// fewer.
template <class Real>
struct PanelRun {
    const Real* weights;  ///< panels × columnCount × kLanes, aligned to 64 bytes
    const Real* points;   ///< columnCount × pointStride: the source entries of the columns
    Offset pointStride;   ///< a multiple of kPadding
    Index columnCount;
    const Index* rows;  ///< the row numbers: rowCount
    Index rowCount;
};

/// A group of rows that share their columns and are outer products (compile/outer_product.h), in
/// panels of kLanes rows; the last panel may have fewer.
template <class Real>
struct ProductRun {
    const Real* factors;  ///< panels × (size[0] + size[1] + size[2]) × kLanes, aligned to 64 bytes
    const Real* points;   ///< size[0] · size[1] · size[2] × pointStride, in the product's order
    Offset pointStride;   ///< a multiple of kPadding
    Index size[3];
    const Index* rows;  ///< the row numbers: rowCount
    Index rowCount;
};

/// Rows of equal length, each with its own columns.
template <class Real>
struct RowRun {
    const Real* weights;   ///< rowCount × length; only length if isShared
    bool isShared;         ///< true if all rows have the same weights
    const Index* columns;  ///< rowCount × length
    Index length;
    const Real* points;  ///< all source entries, aligned to kPadding numbers
    Offset pointStride;  ///< a multiple of kPadding
    const Index* rows;   ///< the row numbers: rowCount
    Index rowCount;
};

/// A group of rows that share their columns, for the adjoint.
template <class Real>
struct AdjointRun {
    /// The size[0] + size[1] + size[2] factors of each row, row by row; or the weights, in the
    /// order in which the kernel reads them: for every kAdjointRows rows, for every
    /// Kernels::adjointColumns columns, row by row. kLanes more numbers are read after the last
    /// one, and have no effect on results.
    const Real* numbers;
    Index size[3];  ///< sizes of outer products for which adjointTakesFactors(); size[0] is 0 for
                    ///< weights
    Index columnCount;
    const Index* rows;  ///< the row numbers: rowCount
    Index rowCount;
};

/// Returns true if the adjoint takes outer products as factors, false if it takes their weights. Up
/// to 16 weights fit in one register, and weights are faster then.
/// \param size0 the largest size along an axis
constexpr bool adjointTakesFactors(Index size0, Index columnCount) {
    return size0 <= 4 && columnCount > 16;
}

/// How many rows the adjoint sums at once. More sums in a row would be less exact.
inline constexpr Index kAdjointRows = 64;

/// How many numbers the adjoint needs for the sums of a group.
template <class Real>
constexpr Offset adjointSumCount(Offset columnCount) {
    // Outer products take 4 × 4 × 4 slots if they have fewer columns, too.
    return 4 * ((columnCount < 64 ? 64 : columnCount) + kLanes<Real>);
}

/// The source of the adjoint: component c of row r is values[r · stride + c].
template <class Real>
struct RowValues {
    const Real* values;
    Offset stride;
    Offset length;
};

/// Rows that share their columns, to be split into factors (compile/outer_product.h).
template <class Real>
struct FactorRun {
    const Real* const* weights;  ///< the weights of each row: weightCount numbers
    Index rowCount;
    Index weightCount;     ///< number of weights of a row, at most kMaxProductColumns
    const Index* sources;  ///< size[0] · size[1] · size[2], in the product's order: the slot of
                           ///< each weight in a row; weightCount if rows lack this column
    Index size[3];
    Real* memory;  ///< temporary: factorizingCount() numbers, aligned to 64 bytes
};

/// How many numbers of temporary memory a FactorRun needs.
/// \param factorCount size[0] + size[1] + size[2]
template <class Real>
constexpr Offset factorizingCount(Offset weightCount, Offset factorCount) {
    return (weightCount + 1 + factorCount) * kLanes<Real>;
}

template <class Real>
struct ESPALIER_API Kernels {
    void (*panels)(const PanelRun<Real>& run, const Destination<Real>& to);
    void (*products)(const ProductRun<Real>& run, const Destination<Real>& to);
    void (*rows)(const RowRun<Real>& run, const Destination<Real>& to);
    /// Computes Σ weight · value over the rows of the run, for each column.
    /// \param result columnCount × length, one column after the other
    /// \param sums temporary memory of adjointSumCount(columnCount) numbers, aligned to 64 bytes
    void (*adjoint)(const AdjointRun<Real>& run, const RowValues<Real>& source, Real* result,
                    Real* sums);
    Index adjointColumns;  ///< how many columns `adjoint` sums at once

    // For compilation. The results have the same bits with all instruction sets.

    /// Puts kLanes rows side by side: number k of row r goes to to[k · kLanes + r].
    /// \param rows `length` numbers for each row
    /// \param to aligned to 64 bytes
    void (*interleave)(const Real* const* rows, Offset length, Real* to);
    /// Computes the factors of rows: size[0] + size[1] + size[2] numbers.
    /// \param factors gets the factors of those rows that are outer products, one after the other
    /// \param isProduct gets for each row whether it is an outer product: see factorizeRows()
    void (*factorize)(const FactorRun<Real>& run, Real* factors, char* isProduct);
};

/// Returns the kernels for an instruction set.
/// \param simd must be supported: see hasSimd()
template <class Real>
ESPALIER_API const Kernels<Real>& kernelsFor(Simd simd);
template <>
ESPALIER_API const Kernels<float>& kernelsFor<float>(Simd simd);
template <>
ESPALIER_API const Kernels<double>& kernelsFor<double>(Simd simd);

}  // namespace espalier::osd::kernels
