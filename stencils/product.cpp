// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/index_set.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

// Multiplies two tables, one block of rows at a time. Neighbouring rows of the left table use the
// same few rows of the right one, and these use the same few columns: the vertices around a base
// cell. So the right rows that a block uses are stored densely over the columns of the block, once.
// The block is then a small dense product: no search, no merge, and full vectors.
namespace espalier::stencils {
namespace {

/// Multiplies blocks one after another; each thread has its own.
class BlockProduct {
public:
    BlockProduct(const StencilTable<double>& left, const StencilTable<double>& right)
        : left_(left), right_(right), middles_(right.rowCount()), columns_(right.columnCount()) {}

    /// Appends rows order.row(first) to order.row(last − 1) of the product.
    void append(Offset first, Offset last, const RowOrder& order, RowList& rows) {
        while (first < last) {
            Offset end = first;
            while (end < last && order.isSameGroup(first, end) && extend(order.row(end))) ++end;
            columns_.sort();
            spread();
            for (; first < end; ++first) {
                rowsLeft_ = static_cast<std::size_t>(last - first);
                appendRow(order.row(first), rows);
            }
            middles_.shrink(0);
            columns_.shrink(0);
        }
    }

private:
    /// Adds a row to the block, unless the block already has rows and would grow too large.
    bool extend(Index row) {
        // Wider blocks are mostly zeros; with more middle rows, they exceed the inner caches.
        constexpr std::size_t kMaxColumns = 64, kMaxMiddles = 1024;
        const std::size_t middleCount = middles_.items().size();
        const std::size_t columnCount = columns_.items().size();
        for (const Index middle : left_.columns(row)) {
            if (middles_.has(middle)) continue;
            middles_.add(middle);
            for (const Index column : right_.columns(middle))
                if (!columns_.has(column)) columns_.add(column);
        }
        // A first row that is wider may be followed by rows with the same columns.
        if (middleCount == 0 || (columns_.items().size() <= std::max(kMaxColumns, columnCount) &&
                                 middles_.items().size() <= std::max(kMaxMiddles, middleCount)))
            return true;
        middles_.shrink(middleCount);
        columns_.shrink(columnCount);
        return false;
    }

    /// Stores the rows of the right table densely over the columns of the block.
    void spread() {
        width_ = (columns_.items().size() + kLanes - 1) / kLanes * kLanes;
        dense_.assign(width_ * middles_.items().size(), 0);
        sums_.resize(width_);
        double* row = dense_.data();
        for (const Index middle : middles_.items()) {
            const auto columns = right_.columns(middle);
            const auto weights = right_.weights(middle);
            for (std::size_t k = 0; k < columns.size(); ++k)
                row[columns_.placeOf(columns[k])] = weights[k];
            row += width_;
        }
    }

    void appendRow(Index row, RowList& rows) {
        collectTerms(row);
        // Sums a strip of columns at a time in registers: half the time of a pass over all columns
        // for each term.
        for (std::size_t strip = 0; strip < width_; strip += kLanes) {
            std::array<double, kLanes> sums = {};
            for (const Term& term : terms_)
                for (std::size_t i = 0; i < kLanes; ++i)
                    sums[i] += term.factor * term.row[strip + i];
            std::copy(sums.begin(), sums.end(), sums_.begin() + static_cast<std::ptrdiff_t>(strip));
        }
        appendSums(rows);
    }

    /// Collects the factors of a row, each with the row that it multiplies. The largest factor
    /// comes last: near a vertex with many edges, the many small products are summed more
    /// accurately before it (with 360 edges, the error after two levels is 1e-16 instead of 2e-14).
    void collectTerms(Index row) {
        const auto middles = left_.columns(row);
        const auto factors = left_.weights(row);
        terms_.clear();
        std::size_t largest = 0;
        for (std::size_t k = 0; k < middles.size(); ++k) {
            terms_.push_back(
                {factors[k],
                 dense_.data() + width_ * static_cast<std::size_t>(middles_.placeOf(middles[k]))});
            if (std::abs(factors[k]) > std::abs(factors[largest])) largest = k;
        }
        if (!terms_.empty())
            std::rotate(terms_.begin() + static_cast<std::ptrdiff_t>(largest),
                        terms_.begin() + static_cast<std::ptrdiff_t>(largest) + 1, terms_.end());
    }

    void appendSums(RowList& rows) {
        // Omits sums that are exactly 0, and columns that no factor uses.
        const std::size_t begin = rows.columns.size();
        if (rows.columns.capacity() < begin + width_) grow(rows);
        rows.columns.resize(begin + columns_.items().size());
        rows.weights.resize(begin + columns_.items().size());
        std::size_t end = begin;
        for (std::size_t i = 0; i < columns_.items().size(); ++i) {
            rows.columns[end] = columns_.items()[i];
            rows.weights[end] = sums_[i];
            end += sums_[i] != 0;
        }
        rows.columns.resize(end);
        rows.weights.resize(end);
        rows.endRow();
    }

    /// Reserves memory for the remaining rows, assuming that they are as long as the rows of this
    /// block.
    void grow(RowList& rows) {
        const std::size_t size = rows.columns.size() + columns_.items().size() * (rowsLeft_ + 1);
        rows.columns.reserve(size);
        rows.weights.reserve(size);
    }

    static constexpr std::size_t kLanes = 8;

    struct Term {
        double factor;
        const double* row;  ///< `width_` elements of dense_
    };

    const StencilTable<double>& left_;
    const StencilTable<double>& right_;
    IndexSet middles_, columns_;  ///< rows and columns of the right table that the block uses
    std::size_t rowsLeft_ = 0;    ///< number of rows that append() has still to compute
    std::size_t width_ = 0;
    std::vector<double> dense_;  ///< a row of `width_` elements for each of middles_
    std::vector<Term> terms_;
    std::vector<double> sums_;
};

}  // namespace

StencilTable<double> multiply(const StencilTable<double>& left, const StencilTable<double>& right,
                              const RowOrder& order) {
    if (left.columnCount() != right.rowCount())
        throw Error("cannot multiply a table of " + std::to_string(left.columnCount()) +
                    " columns by one of " + std::to_string(right.rowCount()) + " rows");
    Pool<BlockProduct> pool;
    return buildTableByChunks(
        left.rowCount(), right.columnCount(), order.rows(),
        [&](Offset first, Offset last, RowList& rows) {
            auto product = pool.take([&] { return std::make_unique<BlockProduct>(left, right); });
            product->append(first, last, order, rows);
            pool.giveBack(std::move(product));
        });
}

}  // namespace espalier::stencils
