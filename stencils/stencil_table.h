// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/base/index.h>

#include <span>
#include <vector>

namespace espalier::stencils {

/// Tells a constructor that its arrays are valid and need no check.
struct Trusted {};

template <class Real>
class StencilTable;

/// Returns the table with weights rounded to another precision. Moves the offsets and columns of
/// `table`.
template <class To, class From>
ESPALIER_API StencilTable<To> convertTable(StencilTable<From>&& table);

/// A sparse matrix of weights in compressed sparse rows, like OpenSubdiv's stencil tables: row i
/// gives result i as Σ_k weights(i)[k] · source[columns(i)[k]].
///
/// Columns are ascending and unique in a row. Immutable, so any number of threads may read it. Real
/// is float or double.
template <class Real>
class ESPALIER_API StencilTable {
public:
    using Weight = Real;

    /// Creates a table without rows and columns.
    StencilTable() = default;

    /// \param columnCount number of source entries
    /// \param offsets one more than the number of rows; row i has entries offsets[i] to offsets[i +
    ///        1] − 1
    /// \param columns, weights one per entry
    /// \throws Error if the arrays are not such a matrix (names the first bad row)
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

    // All rows: rowCount() + 1 offsets, entryCount() columns and weights.
    std::span<const Offset> offsets() const { return offsets_; }
    std::span<const Index> columns() const { return columns_; }
    std::span<const Real> weights() const { return weights_; }

    /// Returns the rows without entries, ascending: the points that no pose moves.
    std::vector<Index> emptyRows() const {
        std::vector<Index> result;
        for (Index row = 0; row < rowCount(); ++row)
            if (columns(row).empty()) result.push_back(row);
        return result;
    }

    friend bool operator==(const StencilTable&, const StencilTable&) = default;

private:
    template <class To, class From>
    friend StencilTable<To> convertTable(StencilTable<From>&& table);

    template <class T>
    std::span<const T> slice(const Array<T>& values, Index row) const {
        const Offset first = offsets_[row];
        const Offset last = offsets_[row + 1];
        return {values.data() + first, static_cast<std::size_t>(last - first)};
    }

    Index columnCount_ = 0;
    Array<Offset> offsets_ = {0};
    Array<Index> columns_;
    Array<Real> weights_;
};

extern template class StencilTable<float>;
extern template class StencilTable<double>;

/// Returns the table with weights rounded to another precision. Tables are built in double, and
/// evaluators also take float.
template <class To, class From>
ESPALIER_API StencilTable<To> convertTable(const StencilTable<From>& table);

/// Returns the transpose: row j holds the weights of column j, with rows ascending. The transpose
/// of D carries gradients by the points to gradients by the lattice vertices.
/// \cost O(entries + rows + columns)
template <class Real>
ESPALIER_API StencilTable<Real> transposeTable(const StencilTable<Real>& table);

/// Returns some rows of a table, in the given order.
/// \param rows of the table; repeats are allowed
/// \cost O(entries), in parallel
template <class Real>
ESPALIER_API StencilTable<Real> selectRows(const StencilTable<Real>& table,
                                           std::span<const Index> rows);

/// Combines n tables with the same shape into one: row i · n + t is row i of table t. It evaluates
/// several results, such as a position and its derivatives, in one pass: the n results of a point
/// are consecutive, and rows that share their columns read the values once (osd::CompiledTable).
///
/// \param tables none of them null
/// \throws Error if there is no table, a table differs in shape from the first, or there are too
///         many rows
/// \cost O(entries), in parallel
template <class Real>
ESPALIER_API StencilTable<Real> interleaveRows(
    const std::vector<const StencilTable<Real>*>& tables);

}  // namespace espalier::stencils
