// SPDX-License-Identifier: Apache-2.0
#include "matrix_rows.h"
#include "../files/bytes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace espalier::io {

using stencils::StencilTable;

namespace {

class RowSorter {
public:
    explicit RowSorter(Index columnCount) : columnCount_(columnCount) {}

    /// Sorts the columns of a row, with their weights.
    void sort(std::size_t row, std::span<Index> columns, std::span<double> weights) {
        const auto isAscending = [&] {
            return std::adjacent_find(columns.begin(), columns.end(), std::greater_equal<>()) ==
                   columns.end();
        };
        const auto fail = [&](const std::string& cause) {
            throw CodingError(concat("row ", row, " ", cause));
        };
        for (const Index column : columns)
            if (column < 0 || column >= columnCount_)
                fail(concat("names column ", column, "; there are ", columnCount_));
        for (const double weight : weights)
            if (!std::isfinite(weight))
                fail(concat("has the weight ", weight, ", which is not finite"));
        if (isAscending()) return;

        entries_.clear();
        for (std::size_t i = 0; i < columns.size(); ++i)
            entries_.emplace_back(columns[i], weights[i]);
        std::sort(entries_.begin(), entries_.end());
        for (std::size_t i = 0; i < columns.size(); ++i) {
            columns[i] = entries_[i].first;
            weights[i] = entries_[i].second;
        }
        if (!isAscending())
            fail(concat("has column ", *std::adjacent_find(columns.begin(), columns.end()),
                        " twice"));
    }

private:
    Index columnCount_;
    std::vector<std::pair<Index, double>> entries_;
};

}  // namespace

Index matrixSize(std::int64_t count, const char* of) {
    if (count < 0 || count > kMaxIndex)
        throw CodingError(concat("claims ", count, " ", of, "; expected 0 to ", kMaxIndex));
    return static_cast<Index>(count);
}

StencilTable<double> tableOfRows(Index columnCount, Array<Offset> offsets, Array<Index> columns,
                                 Array<double> weights) {
    const auto entryCount = static_cast<Offset>(columns.size());
    if (weights.size() != columns.size())
        throw CodingError(concat("has ", entryCount, " columns and ", weights.size(),
                                 " weights; expected the same number"));
    if (offsets.empty())
        throw CodingError("has no row offsets; expected one more than there are rows");
    matrixSize(static_cast<std::int64_t>(offsets.size()) - 1, "rows");
    if (offsets.front() != 0 || offsets.back() != entryCount)
        throw CodingError(concat("has rows from entry ", offsets.front(), " to ", offsets.back(),
                                 "; expected 0 to ", entryCount));
    RowSorter sorter(columnCount);
    for (std::size_t row = 0; row + 1 < offsets.size(); ++row) {
        const Offset first = offsets[row], last = offsets[row + 1];
        if (first > last || last > entryCount)
            throw CodingError(
                concat("row ", row, " goes from entry ", first, " to ", last, " of ", entryCount));
        const std::size_t begin = first;
        const std::size_t count = last - first;
        sorter.sort(row, std::span(columns).subspan(begin, count),
                    std::span(weights).subspan(begin, count));
    }
    return StencilTable<double>(stencils::Trusted{}, columnCount, std::move(offsets),
                                std::move(columns), std::move(weights));
}

}  // namespace espalier::io
