// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/progress.h>
#include <espalier/far/incidence.h>

#include <algorithm>

namespace espalier::far {

RowStarts RowStarts::ofLengths(std::span<const Index> lengths) {
    const auto rowCount = static_cast<Index>(lengths.size());
    const auto isFirst = [&](Index length) { return length == lengths.front(); };
    if (rowCount > 0 && lengths.front() > 0 && std::all_of(lengths.begin(), lengths.end(), isFirst))
        return {rowCount, lengths.front()};
    Array<Offset> offsets(lengths.size() + 1);
    offsets[0] = 0;
    for (std::size_t row = 0; row < lengths.size(); ++row)
        offsets[row + 1] = offsets[row] + lengths[row];
    return RowStarts(std::move(offsets));
}

void RowStarts::append(Index length) {
    if (rowCount_ == 0) length_ = length;
    if (length_ > 0 && length != length_) {
        offsets_.resize(Offset{rowCount_} + 1);
        for (Index row = 0; row <= rowCount_; ++row) offsets_[row] = Offset{length_} * row;
        length_ = 0;
    }
    if (length_ == 0) offsets_.push_back(offsets_.back() + length);
    ++rowCount_;
}

Index RowStarts::rowOf(Offset position) const {
    if (length_ > 0) return static_cast<Index>(position / length_);
    const auto end = std::upper_bound(offsets_.begin(), offsets_.end(), position);
    return static_cast<Index>(end - offsets_.begin()) - 1;
}

Incidence Incidence::uniform(Index length, Array<Index> values) {
    const auto rowCount = static_cast<Index>(values.size() / length);
    return {RowStarts(rowCount, length), std::move(values)};
}

Incidence Incidence::transposed(Index columnCount) const {
    Rows<Index> result;
    result.offsets.assign(Offset{columnCount} + 1, 0);
    constexpr std::size_t kBlock = 1 << 16;  // about a millisecond, if memory is far apart
    forEachBlock(values_.size(), kBlock, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) ++result.offsets[values_[i] + 1];
    });
    for (std::size_t column = 1; column < result.offsets.size(); ++column)
        result.offsets[column] += result.offsets[column - 1];

    result.values.resize(values_.size());
    std::vector<Offset> next(result.offsets.begin(), result.offsets.end() - 1);
    forEachBlock(rowCount(), kBlock / 8, [&](std::size_t first, std::size_t last) {
        for (auto row = static_cast<Index>(first); row < static_cast<Index>(last); ++row)
            for (const Index column : (*this)[row]) result.values[next[column]++] = row;
    });
    return Incidence(std::move(result));
}

SignedIncidence::SignedIncidence(const Rows<Signed>& rows) {
    Rows<Index> indices;
    indices.offsets = rows.offsets;
    indices.values.reserve(rows.values.size());
    signs_.reserve(rows.values.size());
    for (const Signed& entry : rows.values) {
        indices.values.push_back(entry.index);
        signs_.push_back(entry.sign);
    }
    incidence_ = Incidence(std::move(indices));
}

}  // namespace espalier::far
