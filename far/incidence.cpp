// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/incidence.h>

namespace espalier::far {

Incidence Incidence::uniform(Index length, Array<Index> values) {
    Incidence result;
    result.rowCount_ = static_cast<Index>(values.size() / static_cast<std::size_t>(length));
    result.length_ = length;
    result.rows_.values = std::move(values);
    return result;
}

Index Incidence::rowOf(Offset position) const {
    if (length_ > 0) return static_cast<Index>(position / length_);
    const auto end = std::upper_bound(rows_.offsets.begin(), rows_.offsets.end(), position);
    return static_cast<Index>(end - rows_.offsets.begin()) - 1;
}

Incidence Incidence::transposed(Index columnCount) const {
    Rows<Index> result;
    result.offsets.assign(static_cast<std::size_t>(columnCount) + 1, 0);
    for (const Index column : rows_.values) ++result.offsets[column + 1];
    for (std::size_t column = 1; column < result.offsets.size(); ++column)
        result.offsets[column] += result.offsets[column - 1];

    result.values.resize(rows_.values.size());
    std::vector<Offset> next(result.offsets.begin(), result.offsets.end() - 1);
    for (Index row = 0; row < rowCount(); ++row)
        for (const Index column : (*this)[row]) result.values[next[column]++] = row;
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
