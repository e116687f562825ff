// SPDX-License-Identifier: Apache-2.0
#include "limit_place.h"

#include <espalier/far/standard_cells.h>
#include <espalier/stencils/limit_table.h>
#include <espalier/stencils/trilinear.h>

#include <algorithm>
#include <numeric>

#include "table_builder.h"

namespace espalier::stencils {
namespace {

/// Adds `scale` times some weights to others.
void add(std::vector<VertexWeight>& weights, double scale, std::span<const VertexWeight> more) {
    for (const auto& [vertex, weight] : more) weights.push_back({vertex, scale * weight});
}

/// The weights of a cell's vertices in the first derivative along one axis: the place's weights are
/// linear in its offset.
std::vector<VertexWeight> slope(const far::CellComplex& complex, CellPlace place,
                                std::size_t axis) {
    std::vector<VertexWeight> weights;
    place.offset = {};
    add(weights, -1, placeWeights(complex, place));
    place.offset[axis] = 1;
    add(weights, 1, placeWeights(complex, place));
    return weights;
}

/// The same of any derivative.
std::vector<VertexWeight> slope(const far::CellComplex& complex, const CellPlace& place,
                                const Orders& orders) {
    const int total = std::accumulate(orders.begin(), orders.end(), 0);
    if (total == 0) return placeWeights(complex, place);
    const auto axis =
        static_cast<std::size_t>(std::max_element(orders.begin(), orders.end()) - orders.begin());
    if (total == 1) return slope(complex, place, axis);
    // Of second ones, a trilinear map has the mixed ones alone: differences of slopes, as these are
    // linear along the other axis.
    std::vector<VertexWeight> weights;
    if (orders[axis] == 2 || !far::hexahedronVertices(complex, place.cell)) return weights;
    const auto other = static_cast<std::size_t>(
        std::find(orders.begin() + static_cast<std::ptrdiff_t>(axis) + 1, orders.end(), 1) -
        orders.begin());
    CellPlace end = place;
    end.uvw[other] = 0;
    add(weights, -1, slope(complex, end, axis));
    end.uvw[other] = 1;
    add(weights, 1, slope(complex, end, axis));
    return weights;
}

}  // namespace

StencilTable<double> blendedRows(const far::TopologyRefiner& refiner, int level, Rules rules,
                                 std::span<const Index> vertices) {
    auto limits = buildLimitTable(refiner, level, rules, vertices);
    if (refiner.boundary() != far::Boundary::Open) return limits;
    return buildTable<double>(
        limits.rowCount(), limits.columnCount(), [&](Index row, RowAccumulator& accumulator) {
            for (std::size_t k = 0; k < limits.columns(row).size(); ++k)
                accumulator.add(limits.columns(row)[k], limits.weights(row)[k]);
            if (limits.columns(row).empty())
                accumulator.add(vertices[static_cast<std::size_t>(row)], 1);
        });
}

PlaceRows::PlaceRows(const far::TopologyRefiner& refiner, int level, Rules rules,
                     std::span<const LimitPlace> places)
    : level_(refiner.level(level)), places_(places), patches_(places.size()) {
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (const auto* patch = std::get_if<PatchPlace>(&places[i].where)) {
            // Points come along a curve: the one before is often in the same cell.
            const auto* before = i > 0 ? std::get_if<PatchPlace>(&places[i - 1].where) : nullptr;
            if (before && before->frame.corners == patch->frame.corners)
                patches_[i] = patches_[i - 1];
            else
                patches_[i].emplace(level_, patch->frame);
        } else {
            const auto corners =
                level_.complex.relation(3, 0)[std::get<CellPlace>(places[i].where).cell.value];
            vertices_.insert(vertices_.end(), corners.begin(), corners.end());
        }
    }
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    if (!vertices_.empty()) limits_ = blendedRows(refiner, level, rules, vertices_);
}

std::vector<VertexWeight> PlaceRows::weights(std::size_t i, const Orders& orders) const {
    const auto* place = std::get_if<PatchPlace>(&places_[i].where);
    if (!place) return blend(std::get<CellPlace>(places_[i].where), orders);
    const Eigen::Vector3d uvw(place->uvw.data());
    auto weights = patches_[i]->weights(uvw, orders);
    if (orders == kPosition)
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (place->offset[axis] != 0)
                add(weights, place->offset[axis], patches_[i]->weights(uvw, kFirst[axis]));
    return weights;
}

std::vector<VertexWeight> PlaceRows::blend(const CellPlace& place, const Orders& orders) const {
    std::vector<VertexWeight> weights;
    for (const auto& [vertex, weight] : slope(level_.complex, place, orders)) {
        const auto row = static_cast<Index>(
            std::lower_bound(vertices_.begin(), vertices_.end(), vertex) - vertices_.begin());
        for (std::size_t k = 0; k < limits_.columns(row).size(); ++k)
            weights.push_back({limits_.columns(row)[k], weight * limits_.weights(row)[k]});
    }
    return weights;
}

}  // namespace espalier::stencils
