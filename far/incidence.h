// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/array.h>
#include <espalier/base/index.h>
#include <espalier/base/parallel.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace espalier::far {

/// Rows of varying length: row r is values[offsets[r]] to values[offsets[r + 1] − 1].
template <class T>
struct Rows {
    Array<Offset> offsets = {0};
    Array<T> values;
};

/// Builds rows in parallel: fill(row, out) appends the values of `row` to `out`.
/// The result does not depend on the number of threads.
template <class T, class Fill>
Rows<T> buildRows(Index rowCount, Fill fill) {
    constexpr Offset kGrain = 4096;
    const Offset chunkCount = (static_cast<Offset>(rowCount) + kGrain - 1) / kGrain;
    std::vector<std::vector<T>> chunks(chunkCount);
    Rows<T> rows;
    rows.offsets.resize(static_cast<std::size_t>(rowCount) + 1);
    // First the length of each row, then their running sum.
    rows.offsets[0] = 0;
    parallelFor(rowCount, kGrain, [&](Offset first, Offset last) {
        std::vector<T>& chunk = chunks[first / kGrain];
        for (Offset row = first; row < last; ++row) {
            const std::size_t before = chunk.size();
            fill(static_cast<Index>(row), chunk);
            rows.offsets[static_cast<std::size_t>(row) + 1] =
                static_cast<Offset>(chunk.size() - before);
        }
    });
    for (std::size_t row = 1; row < rows.offsets.size(); ++row)
        rows.offsets[row] += rows.offsets[row - 1];
    rows.values.resize(rows.offsets.back());
    parallelFor(rowCount, kGrain, [&](Offset first, Offset) {
        std::vector<T>& chunk = chunks[first / kGrain];
        std::copy(chunk.begin(), chunk.end(), rows.values.begin() + rows.offsets[first]);
        std::vector<T>().swap(chunk);
    });
    return rows;
}

/// A relation between entities of two dimensions in compressed sparse rows.
///
/// Row r lists the entities of the second dimension that are incident to entity r of the first.
/// Immutable, so any number of threads may read it.
class ESPALIER_API Incidence {
public:
    Incidence() = default;
    explicit Incidence(Rows<Index> rows)
        : rowCount_(static_cast<Index>(rows.offsets.size() - 1)), rows_(std::move(rows)) {}

    /// Makes rows of the same length, without storing offsets.
    /// \param length 1 or more; the number of `values` must be a multiple of it
    static Incidence uniform(Index length, Array<Index> values);

    Index rowCount() const { return rowCount_; }

    std::span<const Index> operator[](Index row) const {
        return {rows_.values.data() + offset(row),
                static_cast<std::size_t>(offset(row + 1) - offset(row))};
    }

    /// Returns the position of the first entry of `row` in values(); offset(rowCount()) is the
    /// number of entries.
    Offset offset(Index row) const {
        return length_ > 0 ? Offset{length_} * row : rows_.offsets[row];
    }

    /// Returns the row that contains a position of values(). \cost O(log rows)
    Index rowOf(Offset position) const;

    std::span<const Index> values() const { return rows_.values; }

    /// Returns the transposed relation, with `columnCount` rows, each ascending.
    Incidence transposed(Index columnCount) const;

private:
    Index rowCount_ = 0;
    Index length_ = 0;  ///< of every row; 0 if the rows have offsets
    Rows<Index> rows_;
};

/// A boundary entity, and whether its direction agrees with the direction of the entity that it
/// bounds.
struct Signed {
    Index index = 0;
    std::int8_t sign = 1;  ///< +1 or −1
};

/// A relation to the next lower dimension, with the incidence numbers of the boundary operator.
class ESPALIER_API SignedIncidence {
public:
    SignedIncidence() = default;
    explicit SignedIncidence(const Rows<Signed>& rows);

    /// \param signs one per value of `incidence`: +1 or −1
    SignedIncidence(Incidence incidence, Array<std::int8_t> signs)
        : incidence_(std::move(incidence)), signs_(std::move(signs)) {}

    const Incidence& unsignedRows() const { return incidence_; }

    std::span<const Index> operator[](Index row) const { return incidence_[row]; }

    /// Returns the signs of the entries of operator[](row): +1 or −1.
    std::span<const std::int8_t> signs(Index row) const {
        return {signs_.data() + incidence_.offset(row), incidence_[row].size()};
    }

    /// Returns the signs of the entries of unsignedRows().values().
    std::span<const std::int8_t> signs() const { return signs_; }

private:
    Incidence incidence_;
    Array<std::int8_t> signs_;
};

/// Returns true if a row contains a value. A scan: rows are short, so it is faster than a binary
/// search.
inline bool contains(std::span<const Index> row, Index value) {
    return std::find(row.begin(), row.end(), value) != row.end();
}

}  // namespace espalier::far
