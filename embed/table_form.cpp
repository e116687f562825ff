// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/table_form.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace espalier::embed {
namespace {

/// A table under construction whose rows come in any order, from several threads.
template <class Real>
class RowPlaces {
public:
    /// \param lengths of the rows, behind a 0
    explicit RowPlaces(Array<Offset> lengths) : offsets_(std::move(lengths)) {
        std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
        requireMemory(static_cast<std::uint64_t>(offsets_.back()) * (sizeof(Index) + sizeof(Real)),
                      "a table of " + std::to_string(offsets_.back()) + " weights");
        columns_.resize(offsets_.back());
        weights_.resize(columns_.size());
    }

    /// Sets a row.
    /// \param shift is added to its columns
    void set(Index row, std::span<const Index> columns, std::span<const Real> weights,
             Index shift) {
        const Offset to = offsets_[row];
        std::transform(columns.begin(), columns.end(), columns_.begin() + to,
                       [&](Index column) { return column + shift; });
        std::copy(weights.begin(), weights.end(), weights_.begin() + to);
    }

    stencils::StencilTable<Real> take(Index columnCount) {
        return {stencils::Trusted{}, columnCount, std::move(offsets_), std::move(columns_),
                std::move(weights_)};
    }

private:
    Array<Offset> offsets_;
    Array<Index> columns_;
    Array<Real> weights_;
};

/// Puts the rows of the points of all parts into one table, and empties theirs.
/// \param shifts what is added to the columns of each part
/// \param rowsOf these rows among the tables of a part
template <class Real, class Table, class RowsOf>
stencils::StencilTable<Real> gatherPoints(std::vector<BoundPart<Table>>& parts, Index rowCount,
                                          Index columnCount, std::span<const Index> shifts,
                                          RowsOf rowsOf) {
    Array<Offset> lengths(static_cast<std::size_t>(rowCount) + 1, 0);
    for (BoundPart<Table>& part : parts) {
        const stencils::StencilTable<Real>& rows = rowsOf(part.table);
        for (Index i = 0; i < rows.rowCount(); ++i)
            // A point that is settled beside the cells has no entries among those inside.
            lengths[static_cast<std::size_t>(part.points[i]) + 1] +=
                static_cast<Offset>(rows.columns(i).size());
    }
    RowPlaces<Real> places(std::move(lengths));
    parallelFor(std::ssize(parts), 1, [&](Offset first, Offset last) {
        for (Offset p = first; p < last; ++p) {
            BoundPart<Table>& part = parts[p];
            stencils::StencilTable<Real>& rows = rowsOf(part.table);
            for (Index i = 0; i < rows.rowCount(); ++i)
                if (!rows.columns(i).empty())
                    places.set(part.points[i], rows.columns(i), rows.weights(i), shifts[p]);
            rows = {};
        }
    });
    return places.take(columnCount);
}

}  // namespace

template <class Real>
void buildRows(const far::TopologyRefiner& refiner,
               std::span<const stencils::StencilTable<double>> tables, const Embedding& embedding,
               stencils::StencilTable<Real>& result) {
    result = buildDeformationTable<Real>(refiner, tables, embedding);
}

template <class Real>
void buildRows(const far::TopologyRefiner& refiner,
               std::span<const stencils::StencilTable<double>> tables, const Embedding& embedding,
               stencils::FactoredTable<Real>& result) {
    result = buildFactoredTable<Real>(refiner, tables, embedding);
}

template <class Real>
void buildRows(stencils::StencilTable<double> weights,
               const stencils::StencilTable<double>& stencils, const stencils::RowOrder& order,
               stencils::StencilTable<Real>& result) {
    result = stencils::multiply<Real>(weights, stencils, order);
}

template <class Real>
void buildRows(stencils::StencilTable<double> weights,
               const stencils::StencilTable<double>& stencils, const stencils::RowOrder&,
               stencils::FactoredTable<Real>& result) {
    stencils::CompactTable compact = stencils::compactColumns(std::move(weights));
    result = {stencils::convertTable<Real>(stencils::selectRows(stencils, compact.columns)),
              stencils::convertTable<Real>(std::move(compact.table))};
}

template <class Real>
void gatherRows(std::vector<BoundPart<stencils::StencilTable<Real>>>& parts, Index rowCount,
                Index columnCount, stencils::StencilTable<Real>& result) {
    const std::vector<Index> none(parts.size(), 0);
    result = gatherPoints<Real>(
        parts, rowCount, columnCount, none,
        [](stencils::StencilTable<Real>& table) -> stencils::StencilTable<Real>& { return table; });
}

template <class Real>
void gatherRows(std::vector<BoundPart<stencils::FactoredTable<Real>>>& parts, Index rowCount,
                Index columnCount, stencils::FactoredTable<Real>& result) {
    Offset vertexTotal = 0;
    for (const BoundPart<stencils::FactoredTable<Real>>& part : parts)
        vertexTotal += part.table.vertices.rowCount();
    if (vertexTotal > kMaxIndex)
        throw Error("the factors would have " + std::to_string(vertexTotal) +
                    " vertices, more than an index counts: bind fewer points at once");
    std::vector<Index> shifts;
    Array<Offset> lengths = {0};
    for (const BoundPart<stencils::FactoredTable<Real>>& part : parts) {
        const stencils::StencilTable<Real>& vertices = part.table.vertices;
        shifts.push_back(static_cast<Index>(lengths.size()) - 1);
        for (Index row = 0; row < vertices.rowCount(); ++row)
            lengths.push_back(static_cast<Offset>(vertices.columns(row).size()));
    }
    const auto vertexCount = static_cast<Index>(lengths.size()) - 1;
    RowPlaces<Real> places(std::move(lengths));
    parallelFor(std::ssize(parts), 1, [&](Offset first, Offset last) {
        for (Offset p = first; p < last; ++p) {
            const auto part = static_cast<std::size_t>(p);
            const stencils::StencilTable<Real>& vertices = parts[part].table.vertices;
            for (Index row = 0; row < vertices.rowCount(); ++row)
                places.set(shifts[part] + row, vertices.columns(row), vertices.weights(row), 0);
        }
    });
    stencils::StencilTable<Real> points = gatherPoints<Real>(
        parts, rowCount, vertexCount, shifts,
        [](stencils::FactoredTable<Real>& table) -> stencils::StencilTable<Real>& {
            return table.points;
        });
    result = {places.take(columnCount), std::move(points)};
}

template void buildRows(const far::TopologyRefiner&,
                        std::span<const stencils::StencilTable<double>>, const Embedding&,
                        stencils::StencilTable<float>&);
template void buildRows(stencils::StencilTable<double>, const stencils::StencilTable<double>&,
                        const stencils::RowOrder&, stencils::StencilTable<float>&);
template void gatherRows(std::vector<BoundPart<stencils::StencilTable<float>>>&, Index, Index,
                         stencils::StencilTable<float>&);
template void buildRows(const far::TopologyRefiner&,
                        std::span<const stencils::StencilTable<double>>, const Embedding&,
                        stencils::FactoredTable<float>&);
template void buildRows(stencils::StencilTable<double>, const stencils::StencilTable<double>&,
                        const stencils::RowOrder&, stencils::FactoredTable<float>&);
template void gatherRows(std::vector<BoundPart<stencils::FactoredTable<float>>>&, Index, Index,
                         stencils::FactoredTable<float>&);
template void buildRows(const far::TopologyRefiner&,
                        std::span<const stencils::StencilTable<double>>, const Embedding&,
                        stencils::StencilTable<double>&);
template void buildRows(stencils::StencilTable<double>, const stencils::StencilTable<double>&,
                        const stencils::RowOrder&, stencils::StencilTable<double>&);
template void gatherRows(std::vector<BoundPart<stencils::StencilTable<double>>>&, Index, Index,
                         stencils::StencilTable<double>&);
template void buildRows(const far::TopologyRefiner&,
                        std::span<const stencils::StencilTable<double>>, const Embedding&,
                        stencils::FactoredTable<double>&);
template void buildRows(stencils::StencilTable<double>, const stencils::StencilTable<double>&,
                        const stencils::RowOrder&, stencils::FactoredTable<double>&);
template void gatherRows(std::vector<BoundPart<stencils::FactoredTable<double>>>&, Index, Index,
                         stencils::FactoredTable<double>&);

}  // namespace espalier::embed
