// SPDX-License-Identifier: Apache-2.0
#include "limit_place.h"

#include <espalier/base/argument_error.h>
#include <espalier/base/number_text.h>
#include <espalier/base/sort_unique.h>
#include <espalier/embed/patch_solver.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/level_rows.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace espalier::limit {
namespace {

/// Appends weights, multiplied by `scale`.
void add(std::vector<embed::VertexWeight>& weights, double scale,
         std::span<const embed::VertexWeight> more) {
    for (const auto& [vertex, weight] : more) weights.push_back({vertex, scale * weight});
}

/// Returns the weights of the position or of a first derivative.
std::vector<embed::VertexWeight> cellWeights(const far::CellComplex& complex,
                                             const embed::CellPlace& place, const Orders& orders) {
    if (orders == kPosition) return embed::placeWeights(complex, place);
    const auto axis = std::find(kFirst.begin(), kFirst.end(), orders) - kFirst.begin();
    return embed::directionWeights(complex, place, static_cast<int>(axis));
}

}  // namespace

stencils::StencilTable<double> blendedRows(const stencils::Levels& levels, int level,
                                           std::span<const Index> vertices) {
    auto limits = buildLimitMasks(levels.refiner(), level, vertices);
    if (levels.refiner().boundary() != far::Boundary::Open) return limits;
    return stencils::buildTable(limits.rowCount(), limits.columnCount(),
                                [&](Index row, stencils::RowAccumulator& accumulator) {
                                    for (std::size_t k = 0; k < limits.columns(row).size(); ++k)
                                        accumulator.add(limits.columns(row)[k],
                                                        limits.weights(row)[k]);
                                    if (limits.columns(row).empty())
                                        accumulator.add(vertices[row], 1);
                                });
}

namespace {

/// Half the sum of the absolute differences of two rows: an upper bound of the distance of the two
/// points, as a fraction of the size of the control points.
double spreadOf(const stencils::StencilTable<double>& rows, Index a, Index b) {
    double sum = 0;
    std::size_t i = 0, k = 0;
    const auto first = rows.columns(a), second = rows.columns(b);
    while (i < first.size() || k < second.size()) {
        const bool isFirst = k == second.size() || (i < first.size() && first[i] <= second[k]);
        const bool isSecond = i == first.size() || (k < second.size() && second[k] <= first[i]);
        sum += std::abs((isFirst ? rows.weights(a)[i] : 0) - (isSecond ? rows.weights(b)[k] : 0));
        i += isFirst;
        k += isSecond;
    }
    return sum / 2;
}

/// Weight of one end of the unit interval in linear interpolation, or in its derivative.
double blendFactor(std::size_t bit, double at, int order) {
    if (order == 0) return bit != 0 ? at : 1 - at;
    return order > 1 ? 0 : bit != 0 ? 1 : -1;
}

std::vector<embed::VertexWeight> blendWeights(const FramePlace& place, const Orders& orders) {
    std::vector<embed::VertexWeight> weights;
    for (std::size_t corner = 0; corner < 8; ++corner) {
        double weight = 1;
        for (std::size_t axis = 0; axis < 3; ++axis)
            weight *= blendFactor(embed::bitOf(corner, axis), place.uvw[axis], orders[axis]);
        if (weight != 0) weights.push_back({place.frame.corners[corner], weight});
    }
    return weights;
}

/// Returns the weights of the position or of a first derivative.
std::vector<embed::VertexWeight> edgeWeights(const EdgePlace& place, const Orders& orders) {
    if (orders != kPosition)
        return place.rows
            ->directions[std::find(kFirst.begin(), kFirst.end(), orders) - kFirst.begin()];
    std::vector<embed::VertexWeight> weights = place.rows->position;
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (place.offset[axis] != 0) add(weights, place.offset[axis], place.rows->directions[axis]);
    return weights;
}

}  // namespace

std::vector<double> cellSizes(const stencils::Levels& levels, std::span<const Index> cells) {
    const far::Incidence& vertices = levels.finestLevel().complex.relation(3, 0);
    const int level = levels.finest();
    std::vector<Index> corners;
    for (const Index cell : cells)
        corners.insert(corners.end(), vertices[cell].begin(), vertices[cell].end());
    sortUnique(corners);
    std::vector<stencils::StencilTable<double>> selections;
    for (int k = 0; k <= level; ++k)
        selections.push_back(
            stencils::buildTable(k < level ? 0 : static_cast<Index>(corners.size()),
                                 levels.refiner().level(k).complex.count(0),
                                 [&](Index row, stencils::RowAccumulator& accumulator) {
                                     accumulator.add(corners[row], 1);
                                 }));
    const auto rows = stencils::composeRows(levels.tables(), std::move(selections),
                                            stencils::compositionOf(levels.tables()))
                          .back();
    std::vector<double> result;
    for (const Index cell : cells) {
        double spread = 0;
        for (const Index vertex : vertices[cell])
            spread = std::max(spread, spreadOf(rows, indexIn(corners, vertices[cell][0]),
                                               indexIn(corners, vertex)));
        // By the triangle inequality, any two vertices are at most twice that far apart.
        result.push_back(2 * spread);
    }
    return result;
}

void checkLimitTolerance(double tolerance, const std::string& name) {
    if (!(tolerance >= 1e-14 && tolerance <= 0.1))
        throw ArgumentError("", name, textOf(tolerance), "1e-14 to 0.1");
}

int levelsToShrink(double size, double tolerance) {
    return std::max(1, static_cast<int>(std::ceil(std::log2(size / tolerance))));
}

PlaceRows::PlaceRows(const stencils::Levels& levels, int level, std::span<const LimitPlace> places)
    : levels_(levels),
      levelNumber_(level),
      level_(levels.refiner().level(level)),
      places_(places),
      patchOf_(places.size(), kMaxIndex) {
    std::map<std::array<Index, 8>, Index> patchWith;  // By the corners of its frame.
    const auto blend = [&](std::span<const Index> corners) {
        vertices_.insert(vertices_.end(), corners.begin(), corners.end());
    };
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (const auto* inCell = std::get_if<embed::CellPlace>(&places[i].where))
            blend(level_.complex.relation(3, 0)[inCell->cell.value]);
        const auto* place = std::get_if<FramePlace>(&places[i].where);
        if (!place) continue;
        if (place->isBlended) {
            blend(place->frame.corners);
        } else {
            const auto [known, isNew] =
                patchWith.try_emplace(place->frame.corners, static_cast<Index>(patches_.size()));
            if (isNew) patches_.emplace_back(level_, place->frame);
            patchOf_[i] = known->second;
        }
    }
    sortUnique(vertices_);
    if (!vertices_.empty()) limits_ = blendedRows(levels, level, vertices_);
}

std::vector<embed::VertexWeight> PlaceRows::weights(std::size_t i, const Orders& orders) const {
    if (const auto* inCell = std::get_if<embed::CellPlace>(&places_[i].where))
        return inLimits(cellWeights(level_.complex, *inCell, orders));
    if (const auto* onEdge = std::get_if<EdgePlace>(&places_[i].where))
        return edgeWeights(*onEdge, orders);
    const FramePlace& place = std::get<FramePlace>(places_[i].where);
    if (place.isBlended) return inLimits(blendWeights(place, orders));
    const embed::TricubicPatch& patch = patches_[patchOf_[i]];
    const Eigen::Vector3d uvw(place.uvw.data());
    auto weights = patch.weights(uvw, orders);
    if (orders == kPosition)
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (place.offset[axis] != 0)
                add(weights, place.offset[axis], patch.weights(uvw, kFirst[axis]));
    return weights;
}

stencils::StencilTable<double> PlaceRows::tangents() const {
    std::vector<CellCorner> corners;
    std::vector<Index> cornerOf(places_.size());  // Used in blends.
    for (std::size_t i = 0; i < places_.size(); ++i) {
        if (!isBlended(i)) continue;
        cornerOf[i] = static_cast<Index>(corners.size());
        corners.push_back(nearestCorner(i));
    }
    stencils::StencilTable<double> atCorners;
    if (!corners.empty()) atCorners = buildTangentTable(levels_.refiner(), levelNumber_, corners);
    return stencils::buildTable(
        static_cast<Index>(3 * places_.size()), level_.complex.count(0),
        [&](Index row, stencils::RowAccumulator& accumulator) {
            const std::size_t i = row / 3;
            const std::size_t axis = row % 3;
            if (!isBlended(i)) {
                for (const auto& [vertex, weight] : weights(i, kFirst[axis]))
                    accumulator.add(vertex, weight);
                accumulator.makeSumZero();
                return;
            }
            const Index source = 3 * cornerOf[i] + row % 3;
            for (std::size_t k = 0; k < atCorners.columns(source).size(); ++k)
                accumulator.add(atCorners.columns(source)[k], atCorners.weights(source)[k]);
        });
}

embed::SplinePlaces PlaceRows::splinePlaces() const {
    // Dividing by the determinant of unit directions costs at most three digits.
    constexpr double kAlmostFlat = 1e-3;
    embed::SplinePlaces splines;
    std::vector<embed::TricubicMap> maps;
    for (const embed::TricubicPatch& patch : patches_) {
        splines.patches.push_back(patch.vertices());
        maps.emplace_back(patch.controlPoints(levels_.positions(levelNumber_)));
    }
    for (std::size_t i = 0; i < places_.size(); ++i) {
        if (patchOf_[i] == kMaxIndex) continue;
        const auto& uvw = std::get<FramePlace>(places_[i].where).uvw;
        const auto derivatives = maps[patchOf_[i]].tangent(Eigen::Vector3d(uvw.data())).jacobian;
        if (std::abs(derivatives.colwise().normalized().determinant()) > kAlmostFlat)
            splines.places.push_back({static_cast<Index>(i), patchOf_[i], uvw});
    }
    return splines;
}

/// Returns the vertex with the largest weight in a place, among the vertices that have a limit.
CellCorner PlaceRows::nearestCorner(std::size_t i) const {
    Index cell = 0;
    std::vector<embed::VertexWeight> weights;
    if (const auto* place = std::get_if<FramePlace>(&places_[i].where)) {
        cell = place->frame.cell;
        weights = blendWeights(*place, kPosition);
    } else {
        embed::CellPlace inCell = std::get<embed::CellPlace>(places_[i].where);
        inCell.offset = {};
        cell = inCell.cell.value;
        weights = embed::placeWeights(level_.complex, inCell);
    }
    std::map<Index, double> shares;
    for (const auto& [vertex, weight] : weights) shares[vertex] += weight;
    CellCorner corner{cell, kMaxIndex};
    for (const auto& [vertex, share] : shares)
        if (!level_.strata.isOpen({0, vertex}) &&
            (corner.vertex == kMaxIndex || share > shares.at(corner.vertex)))
            corner.vertex = vertex;
    return corner;
}

/// Replaces each vertex by its limit: weights of limits become weights of vertices.
std::vector<embed::VertexWeight> PlaceRows::inLimits(
    std::span<const embed::VertexWeight> weights) const {
    std::vector<embed::VertexWeight> result;
    for (const auto& [vertex, weight] : weights) {
        const Index row = indexIn(vertices_, vertex);
        for (std::size_t k = 0; k < limits_.columns(row).size(); ++k)
            result.push_back({limits_.columns(row)[k], weight * limits_.weights(row)[k]});
    }
    return result;
}

}  // namespace espalier::limit
