// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/stencils/surroundings.h>

#include <algorithm>

#include "repeated_rows.h"
#include "vertex_parents.h"

namespace espalier::stencils {

bool RepeatedRows::isApplicable(const far::TopologyRefiner& refiner, int level) {
    // On level 1, an entity contains no vertex but its own point. Rows are matched by their
    // position among the rows of an entity, so no row may be missing.
    return level >= 2 && refiner.isUniform() &&
           Surroundings::shapesDetermineRows(refiner.level(0), refiner.options());
}

RepeatedRows::RepeatedRows(const far::TopologyRefiner& refiner, int level,
                           std::span<const BaseEntities> origins, std::span<const Index> vertices)
    : copies_(vertices.size()) {
    const VertexParents parents(refiner, level);
    const BaseEntities& origin = origins[level - 1];
    insides_.resize(origin.count());

    // Refinement keeps the order of vertices in equal shapes, so corresponding rows have the same
    // position among the rows of their base entities.
    Array<Index> slots(parents.count());
    std::vector<Index> sizes(insides_.size(), 0);
    for (Index vertex = 0; vertex < parents.count(); ++vertex)
        slots[vertex] = sizes[origin.of(parents(vertex))]++;

    std::vector<Index> firstSets;  // for each shape
    std::vector<std::optional<Index>>
        sets;  // for each set of rows, its position in representatives_
    Surroundings surroundings(refiner.level(0));
    for (std::size_t row = 0; row < vertices.size(); ++row) {
        checkCancelledEvery(row, 14);
        const Index vertex = vertices[row];
        const Index base = origin.of(parents(vertex));
        std::optional<Inside>& inside = insides_[base];
        if (!inside) {
            const Index shape = surroundings.shapeOf(origins.front().entity(base));
            if (shape == std::ssize(firstSets)) {
                firstSets.push_back(static_cast<Index>(sets.size()));
                sets.resize(std::ssize(sets) + sizes[base]);
            }
            inside = {firstSets[shape], static_cast<Offset>(around_.size())};
            around_.insert(around_.end(), surroundings.vertices().begin(),
                           surroundings.vertices().end());
        }
        std::optional<Index>& first = sets[inside->firstSet + slots[vertex]];
        if (!first) {
            first = static_cast<Index>(representatives_.size());
            representatives_.push_back(vertex);
            baseEntities_.push_back(base);
        }
        copies_[row] = {*first, base};
    }
}

/// Returns, for each entry of a table, the position of its column among the vertices around the
/// row's base entity.
template <class Real>
Array<Index> RepeatedRows::slotsOf(const StencilTable<Real>& distinctRows) const {
    Array<Index> slots(distinctRows.columns().size());
    for (Index row = 0; row < distinctRows.rowCount(); ++row) {
        checkCancelledEvery(row, 14);
        const Index* const around = verticesAround(baseEntities_[row]);
        Offset entry = distinctRows.offsets()[row];
        Index slot = 0;
        for (const Index column : distinctRows.columns(row)) {  // Both are ascending.
            while (around[slot] != column) ++slot;
            slots[entry++] = slot;
        }
    }
    return slots;
}

template <class Real>
StencilTable<Real> RepeatedRows::expand(const StencilTable<Real>& distinctRows) const {
    const Array<Index> slots = slotsOf(distinctRows);
    const Index columnCount = distinctRows.columnCount();
    Array<Offset> offsets(copies_.size() + 1);
    offsets[0] = 0;
    for (std::size_t row = 0; row < copies_.size(); ++row)
        offsets[row + 1] = offsets[row] + distinctRows.offsets()[copies_[row].first + 1] -
                           distinctRows.offsets()[copies_[row].first];
    Array<Index> columns(offsets.back());
    Array<Real> weights(columns.size());
    parallelFor(static_cast<Offset>(copies_.size()), 4096, [&](Offset begin, Offset end) {
        for (Offset row = begin; row < end; ++row) {
            const Copy& copy = copies_[row];
            const auto from = distinctRows.weights(copy.first);
            const Index* const slot = slots.data() + distinctRows.offsets()[copy.first];
            const Index* const around = verticesAround(copy.base);
            Index* const to = columns.data() + offsets[row];
            for (std::size_t k = 0; k < from.size(); ++k) to[k] = around[slot[k]];
            std::copy(from.begin(), from.end(), weights.begin() + offsets[row]);
        }
    });
    return StencilTable<Real>(Trusted{}, columnCount, std::move(offsets), std::move(columns),
                              std::move(weights));
}

template StencilTable<float> RepeatedRows::expand(const StencilTable<float>&) const;
template StencilTable<double> RepeatedRows::expand(const StencilTable<double>&) const;

}  // namespace espalier::stencils
