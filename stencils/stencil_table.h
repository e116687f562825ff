// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/base/index.h>

#include <span>
#include <vector>

namespace espalier::stencils {

/// Says that arrays are what they should be, and need no check.
struct Trusted {};

template <class Real>
class StencilTable;

/// The same table with weights rounded to another precision, of a table that is done with: its
/// offsets and columns are moved, not copied.
template <class To, class From>
ESPALIER_API StencilTable<To> convertTable(StencilTable<From>&& table);

/// A sparse matrix of weights in compressed sparse rows, as OpenSubdiv's stencil tables: row i
/// gives result i as Σ_k weights(i)[k] · source[columns(i)[k]].
///
/// Columns ascend and are unique in a row. Immutable, and so safe to share between threads.
/// Real is float or double.
template <class Real>
class ESPALIER_API StencilTable {
public:
    using Weight = Real;

    /// The table of no rows and no columns.
    StencilTable() = default;

    /// \param columnCount number of source entries
    /// \param offsets one more than rows; row i has entries offsets[i] to offsets[i + 1]
    /// \param columns, weights one an entry
    /// \throws Error if the arrays are not such a matrix, naming the first bad row
    StencilTable(Index columnCount, Array<Offset> offsets, Array<Index> columns,
                 Array<Real> weights);

    /// The same without the checks.
    StencilTable(Trusted, Index columnCount, Array<Offset> offsets, Array<Index> columns,
                 Array<Real> weights);

    Index rowCount() const { return static_cast<Index>(offsets_.size() - 1); }
    Index columnCount() const { return columnCount_; }
    Offset entryCount() const { return offsets_.back(); }

    std::span<const Index> columns(Index row) const { return slice<Index>(columns_, row); }
    std::span<const Real> weights(Index row) const { return slice<Real>(weights_, row); }

    // The arrays as a whole: rowCount() + 1 offsets, entryCount() columns and weights.
    std::span<const Offset> offsets() const { return offsets_; }
    std::span<const Index> columns() const { return columns_; }
    std::span<const Real> weights() const { return weights_; }

    friend bool operator==(const StencilTable&, const StencilTable&) = default;

private:
    template <class To, class From>
    friend StencilTable<To> convertTable(StencilTable<From>&& table);

    template <class T>
    std::span<const T> slice(const Array<T>& values, Index row) const {
        const Offset first = offsets_[row];
        const Offset last = offsets_[static_cast<std::size_t>(row) + 1];
        return {values.data() + first, static_cast<std::size_t>(last - first)};
    }

    Index columnCount_ = 0;
    Array<Offset> offsets_ = {0};
    Array<Index> columns_;
    Array<Real> weights_;
};

extern template class StencilTable<float>;
extern template class StencilTable<double>;

/// The same table with weights rounded to another precision: tables are built in double, and
/// evaluators take float as well.
template <class To, class From>
ESPALIER_API StencilTable<To> convertTable(const StencilTable<From>& table);

/// The transpose: row j holds the weights of column j, by ascending rows. Of D it carries gradients
/// by the points to gradients by the lattice vertices.
/// \cost O(entries + rows + columns)
template <class Real>
ESPALIER_API StencilTable<Real> transposeTable(const StencilTable<Real>& table);

/// Some rows of a table, in the order in which they are named.
/// \param rows those of the table, repeats allowed
/// \cost O(entries), in parallel
template <class Real>
ESPALIER_API StencilTable<Real> selectRows(const StencilTable<Real>& table,
                                           std::span<const Index> rows);

/// Tables of as many rows over the same columns as one: row i · n + t is row i of table t of n. To
/// apply them in one pass, as a position and its derivatives: the n results of a point lie
/// together, and rows that share their columns read the values once (osd::CompiledTable).
///
/// \param tables none of them null
/// \throws Error if there is no table, one is of another shape than the first, or rows are too many
/// \cost O(entries), in parallel
template <class Real>
ESPALIER_API StencilTable<Real> interleaveRows(
    const std::vector<const StencilTable<Real>*>& tables);

}  // namespace espalier::stencils
