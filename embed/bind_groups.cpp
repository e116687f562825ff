// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/bind_groups.h>
#include <espalier/embed/gradient_rows.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <string>
#include <utility>

namespace espalier::embed {
namespace {

/// A table under construction whose rows come in any order, from several threads.
class ScatteredRows {
public:
    /// \param lengths a 0, and then the length of each row
    explicit ScatteredRows(Array<Offset> lengths) : offsets_(std::move(lengths)) {
        stencils::allocateEntries(offsets_, columns_, weights_);
    }

    /// Writes a row.
    /// \param numberOf numberOf(column) returns the number of a column here
    template <class NumberOf>
    void set(Index row, std::span<const Index> columns, std::span<const double> weights,
             NumberOf numberOf) {
        const Offset to = offsets_[row];
        std::transform(columns.begin(), columns.end(), columns_.begin() + to, numberOf);
        std::copy(weights.begin(), weights.end(), weights_.begin() + to);
    }

    stencils::StencilTable<double> take(Index columnCount) {
        return {stencils::Trusted{}, columnCount, std::move(offsets_), std::move(columns_),
                std::move(weights_)};
    }

private:
    Array<Offset> offsets_;
    Array<Index> columns_;
    Array<double> weights_;
};

/// Puts the rows of the points of all parts into one table, and empties the rows of the parts.
/// \param rowsOf returns the rows of the points of a part
/// \param numberOf numberOf(p, column) returns the number in the result of a column of part p
template <class Table, class RowsOf, class NumberOf>
stencils::StencilTable<double> gatherPoints(std::vector<BoundPart<Table>>& parts, Index rowCount,
                                            Index columnCount, RowsOf rowsOf, NumberOf numberOf) {
    Array<Offset> lengths(Offset{rowCount} + 1, 0);
    for (BoundPart<Table>& part : parts) {
        const stencils::StencilTable<double>& rows = rowsOf(part);
        for (Index i = 0; i < rows.rowCount(); ++i)
            // A point placed by a later part has an empty row in the earlier one.
            lengths[part.points[i] + 1] += static_cast<Offset>(rows.columns(i).size());
    }
    ScatteredRows scattered(std::move(lengths));
    parallelFor(std::ssize(parts), 1, [&](Offset first, Offset last) {
        for (Offset p = first; p < last; ++p) {
            BoundPart<Table>& part = parts[p];
            stencils::StencilTable<double>& rows = rowsOf(part);
            for (Index i = 0; i < rows.rowCount(); ++i)
                if (!rows.columns(i).empty())
                    scattered.set(part.points[i], rows.columns(i), rows.weights(i),
                                  [&](Index column) { return numberOf(p, column); });
            rows = {};
        }
    });
    return scattered.take(columnCount);
}

}  // namespace

void gatherRows(std::vector<BoundPart<stencils::StencilTable<double>>>& parts, Index rowCount,
                Index columnCount, stencils::StencilTable<double>& result) {
    result = gatherPoints(
        parts, rowCount, columnCount,
        [](BoundPart<stencils::StencilTable<double>>& part) -> stencils::StencilTable<double>& {
            return part.table;
        },
        [&](Offset p, Index column) { return parts[p].baseVertex(column); });
}

Gradients gatherGradients(std::vector<BoundPart<stencils::StencilTable<double>>>& parts,
                          Index columnCount) {
    std::vector<Gradients> ofParts;
    for (BoundPart<stencils::StencilTable<double>>& part : parts) {
        Gradients gradients = renumbered(std::move(part.gradients), part.points);
        part.gradients = {};
        if (!part.baseVertices.empty())
            gradients.vertices =
                stencils::renumberColumns(gradients.vertices, columnCount,
                                          [&](Index column) { return part.baseVertices[column]; });
        ofParts.push_back(std::move(gradients));
    }
    return merged(ofParts, columnCount);
}

void gatherRows(std::vector<BoundPart<stencils::FactoredTable<double>>>& parts, Index rowCount,
                Index columnCount, stencils::FactoredTable<double>& result) {
    Offset vertexTotal = 0;
    for (const BoundPart<stencils::FactoredTable<double>>& part : parts)
        vertexTotal += part.table.vertices.rowCount();
    if (vertexTotal > kMaxIndex)
        throw Error("the factors would have " + std::to_string(vertexTotal) +
                    " vertices, more than an index can count; bind fewer points at once");
    std::vector<Index> shifts;
    Array<Offset> lengths = {0};
    for (const BoundPart<stencils::FactoredTable<double>>& part : parts) {
        const stencils::StencilTable<double>& vertices = part.table.vertices;
        shifts.push_back(static_cast<Index>(lengths.size()) - 1);
        for (Index row = 0; row < vertices.rowCount(); ++row)
            lengths.push_back(static_cast<Offset>(vertices.columns(row).size()));
    }
    const auto vertexCount = static_cast<Index>(lengths.size()) - 1;
    ScatteredRows scattered(std::move(lengths));
    parallelFor(std::ssize(parts), 1, [&](Offset first, Offset last) {
        for (Offset p = first; p < last; ++p) {
            const auto& part = parts[p];
            const stencils::StencilTable<double>& vertices = part.table.vertices;
            for (Index row = 0; row < vertices.rowCount(); ++row)
                scattered.set(shifts[p] + row, vertices.columns(row), vertices.weights(row),
                              [&](Index column) { return part.baseVertex(column); });
        }
    });
    stencils::StencilTable<double> points = gatherPoints(
        parts, rowCount, vertexCount,
        [](BoundPart<stencils::FactoredTable<double>>& part) -> stencils::StencilTable<double>& {
            return part.table.points;
        },
        [&](Offset p, Index column) { return column + shifts[p]; });
    result = {scattered.take(columnCount), std::move(points)};
}

}  // namespace espalier::embed
