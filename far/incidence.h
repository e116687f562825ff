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

    std::size_t count() const { return offsets.size() - 1; }
    bool empty() const { return count() == 0; }

    std::span<const T> operator[](std::size_t row) const {
        return {values.data() + offsets[row], values.data() + offsets[row + 1]};
    }

    /// Adds a row.
    void push(std::span<const T> row) {
        values.insert(values.end(), row.begin(), row.end());
        offsets.push_back(static_cast<Offset>(values.size()));
    }
};

/// Builds rows in parallel: fill(row, out) appends the values of `row` to `out`.
/// The result does not depend on the number of threads.
template <class T, class Fill>
Rows<T> buildRows(Index rowCount, Fill fill) {
    constexpr Offset kGrain = 4096;
    const Offset chunkCount = (static_cast<Offset>(rowCount) + kGrain - 1) / kGrain;
    std::vector<std::vector<T>> chunks(chunkCount);
    Rows<T> rows;
    rows.offsets.resize(Offset{rowCount} + 1);
    // First the length of each row, then their running sum.
    rows.offsets[0] = 0;
    parallelFor(rowCount, kGrain, [&](Offset first, Offset last) {
        std::vector<T>& chunk = chunks[first / kGrain];
        for (Offset row = first; row < last; ++row) {
            const std::size_t before = chunk.size();
            fill(static_cast<Index>(row), chunk);
            rows.offsets[row + 1] = static_cast<Offset>(chunk.size() - before);
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

/// The starts of rows in the values of compressed rows. They are stored as offsets, or as one
/// length of all rows.
class ESPALIER_API RowStarts {
public:
    RowStarts() = default;

    /// \param offsets 0, then the end of each row
    explicit RowStarts(Array<Offset> offsets)
        : rowCount_(static_cast<Index>(offsets.size() - 1)), offsets_(std::move(offsets)) {}

    /// Makes rows of the same length, without storing offsets.
    /// \param length 1 or more
    RowStarts(Index rowCount, Index length) : rowCount_(rowCount), length_(length) {}

    /// Makes rows of these lengths; without offsets if they are all equal and not 0.
    static RowStarts ofLengths(std::span<const Index> lengths);

    /// Adds a row. Stores offsets as soon as two lengths differ.
    void append(Index length);

    Index rowCount() const { return rowCount_; }

    /// Returns the length of every row; 0 if rows have offsets.
    Index commonLength() const { return length_; }

    /// \param row 0 to rowCount(), which gives the number of values
    Offset operator[](Index row) const {
        return length_ > 0 ? Offset{length_} * row : offsets_[row];
    }

    /// Returns the row that contains a position of the values. \cost O(log rows)
    Index rowOf(Offset position) const;

    /// The same starts, to be copied into loops. Must not outlive the object.
    struct View {
        Index rowCount;
        Index length;
        const Offset* offsets;
        Offset operator[](Index row) const {
            return length > 0 ? Offset{length} * row : offsets[row];
        }
    };
    operator View() const { return {rowCount_, length_, offsets_.data()}; }

private:
    Index rowCount_ = 0;
    Index length_ = 0;
    Array<Offset> offsets_ = {0};
};

/// A relation between entities of two dimensions in compressed sparse rows.
///
/// Row r lists the entities of the second dimension that are incident to entity r of the first.
/// Immutable, so any number of threads may read it.
class ESPALIER_API Incidence {
public:
    Incidence() = default;
    explicit Incidence(Rows<Index> rows)
        : Incidence(RowStarts(std::move(rows.offsets)), std::move(rows.values)) {}

    /// \param values starts[starts.rowCount()] values
    Incidence(RowStarts starts, Array<Index> values)
        : starts_(std::move(starts)), values_(std::move(values)) {}

    /// Makes rows of the same length, without storing offsets.
    /// \param length 1 or more; the number of `values` must be a multiple of it
    static Incidence uniform(Index length, Array<Index> values);

    Index rowCount() const { return starts_.rowCount(); }

    const RowStarts& starts() const { return starts_; }

    /// Returns the length of every row; 0 if lengths may differ.
    Index commonLength() const { return starts_.commonLength(); }

    std::span<const Index> operator[](Index row) const {
        const Offset first = starts_[row];
        return {values_.data() + first, static_cast<std::size_t>(starts_[row + 1] - first)};
    }

    /// Returns the position of the first entry of `row` in values(); offset(rowCount()) is the
    /// number of entries.
    Offset offset(Index row) const { return starts_[row]; }

    /// Returns the row that contains a position of values(). \cost O(log rows)
    Index rowOf(Offset position) const { return starts_.rowOf(position); }

    std::span<const Index> values() const { return values_; }

    /// Returns the transposed relation, with `columnCount` rows, each ascending.
    Incidence transposed(Index columnCount) const;

private:
    RowStarts starts_;
    Array<Index> values_;
};

/// Builds rows of known lengths in parallel: fill(row, first) writes the values of `row` from
/// `first` on.
template <class Fill>
Incidence fillRows(RowStarts starts, Fill fill) {
    Array<Index> values(starts[starts.rowCount()]);
    parallelFor(starts.rowCount(), 4096, [&](Offset first, Offset last) {
        for (Offset row = first; row < last; ++row)
            fill(static_cast<Index>(row), values.data() + starts[static_cast<Index>(row)]);
    });
    return {std::move(starts), std::move(values)};
}

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
