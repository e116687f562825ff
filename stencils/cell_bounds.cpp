// SPDX-License-Identifier: Apache-2.0
#include "cell_bounds.h"

#include <espalier/far/standard_cells.h>

#include <algorithm>
#include <array>

namespace espalier::stencils {

using Eigen::Vector3d;
using far::Entity;
using far::Index;

CellBounds::CellBounds(const far::Level& level, std::span<const Point3> positions,
                       far::Creasing creasing)
    : complex_(level.complex),
      strata_(level.strata),
      positions_(positions),
      mayExtrapolate_(creasing == far::Creasing::Chaikin && level.strata.hasSemiSharp()) {}

std::optional<CellBound> CellBounds::boundOf(Index cell,
                                             const std::optional<Vector3d>& inherited) const {
    CellBound bound;
    if (inherited) bound.drift = *inherited / 4;
    std::vector<Index> ring;
    if (!bound.drift) {
        ring = ringOf(cell);
        // Three axes, a sixth of the second difference for each.
        if (isRegular(cell)) bound.drift = largestSecondDifference(ring) / 2;
    }
    if (bound.drift) {
        if (!bound.drift->allFinite()) return std::nullopt;  // Coordinates near the largest number.
        bound.box = ownBox(cell).box;
        bound.box.min() -= *bound.drift;
        bound.box.max() += *bound.drift;
        return bound;
    }
    if (!staysInHull(cell)) return std::nullopt;
    for (const Index other : ring)
        for (const Index vertex : complex_.relation(3, 0)[other])
            bound.box.extend(positionOf(vertex));
    return bound;
}

CellBound CellBounds::ownBox(Index cell) const {
    CellBound bound;
    for (const Index vertex : complex_.relation(3, 0)[cell]) bound.box.extend(positionOf(vertex));
    return bound;
}

std::vector<Index> CellBounds::ringOf(Index cell) const {
    std::vector<Index> ring;
    for (const Index vertex : complex_.relation(3, 0)[cell]) {
        const auto cells = complex_.relation(0, 3)[vertex];
        ring.insert(ring.end(), cells.begin(), cells.end());
    }
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return ring;
}

/// Whether the cells around a cell are a part of a grid, and keep to the rules of one: inside, at a
/// flat boundary, at a sharp edge or at a corner.
bool CellBounds::isRegular(Index cell) const {
    const auto vertices = complex_.relation(3, 0)[cell];
    return std::all_of(vertices.begin(), vertices.end(),
                       [&](Index vertex) { return isRegularAt(vertex); });
}

bool CellBounds::isRegularAt(Index vertex) const {
    // The stratum of what lies in so many cells of a grid; none for other numbers.
    const auto stratumOf = [](std::size_t cells, int dimension) {
        for (int stratum = 3; stratum >= dimension; --stratum)
            if (cells == std::size_t{1} << (stratum - dimension)) return stratum;
        return -1;
    };
    const auto isPlain = [&](const Entity& entity) {
        const auto cells = complex_.relation(entity.dimension, 3)[entity.index].size();
        const bool fades = entity.dimension < 2 && far::isSemiSharp(strata_.sharpness(entity));
        return !fades && !strata_.isOpen(entity) &&
               strata_.of(entity) == stratumOf(cells, entity.dimension);
    };
    const auto cells = complex_.relation(0, 3)[vertex];
    const int stratum = strata_.of({0, vertex});
    const auto edges = complex_.relation(0, 1)[vertex];
    if (!isPlain({0, vertex}) || edges.size() != 3 + static_cast<std::size_t>(stratum))
        return false;
    for (const int dimension : {1, 2})
        for (const Index index : complex_.relation(0, dimension)[vertex])
            if (!isPlain({dimension, index})) return false;
    // In a loop of two cells, both neighbours along the loop are the same vertex.
    std::vector<Index> ends;
    for (const Index edge : edges)
        for (const Index end : complex_.relation(1, 0)[edge])
            if (end != vertex) ends.push_back(end);
    std::sort(ends.begin(), ends.end());
    if (std::adjacent_find(ends.begin(), ends.end()) != ends.end()) return false;
    return std::all_of(cells.begin(), cells.end(), [&](Index cell) {
        return far::hexahedronVertices(complex_, far::CellId(cell)).has_value();
    });
}

/// Whether no new point around a cell, at this level or a later one, has a negative weight.
bool CellBounds::staysInHull(Index cell) const {
    if (mayExtrapolate_) return false;
    for (const Index vertex : complex_.relation(3, 0)[cell]) {
        std::size_t surfaceEdges = 0;
        for (const Index edge : complex_.relation(0, 1)[vertex]) {
            if (strata_.smoothStratum({1, edge}) == 2)
                ++surfaceEdges;
            else if (complex_.relation(1, 2)[edge].size() == 2)
                return false;  // (C̄ + 2Ā − M)/2
        }
        if (strata_.smoothStratum({0, vertex}) == 2 && surfaceEdges == 2)
            return false;  // (Ā + 2M̄ − P)/2
    }
    return true;
}

namespace {

/// The neighbours of a vertex in a grid: 6 at most.
struct Neighbours {
    std::array<Index, 6> vertices = {};
    std::size_t count = 0;
    std::array<unsigned, 6> together = {};  ///< bit k: in one cell with vertices[k], or the same

    /// Where a neighbour is, which is added if it is new.
    std::size_t placeOf(Index neighbour) {
        const auto at = std::find(vertices.begin(), vertices.begin() + count, neighbour);
        if (at == vertices.begin() + count) vertices[count++] = neighbour;
        return static_cast<std::size_t>(at - vertices.begin());
    }
};

/// The neighbours of each corner of a hexahedron.
constexpr std::array<std::array<std::size_t, 3>, 8> kNeighbours = {
    {{1, 3, 4}, {0, 2, 5}, {1, 3, 6}, {0, 2, 7}, {0, 5, 7}, {1, 4, 6}, {2, 5, 7}, {3, 4, 6}}};

}  // namespace

/// Coordinate by coordinate, |P₋ − 2P + P₊| where P lies between two others along an axis of the
/// grid that `ring` is: they are its neighbours, and in no cell together.
Vector3d CellBounds::largestSecondDifference(const std::vector<Index>& ring) const {
    std::vector<std::array<Index, 8>> cells;
    std::vector<Index> vertices;
    for (const Index cell : ring) {
        cells.push_back(*far::hexahedronVertices(complex_, far::CellId(cell)));
        vertices.insert(vertices.end(), cells.back().begin(), cells.back().end());
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    std::vector<Neighbours> around(vertices.size());
    for (const auto& corners : cells)
        for (std::size_t i = 0; i < 8; ++i) {
            const auto at = std::lower_bound(vertices.begin(), vertices.end(), corners[i]);
            Neighbours& neighbours = around[static_cast<std::size_t>(at - vertices.begin())];
            std::array<std::size_t, 3> places;
            unsigned together = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                places[k] = neighbours.placeOf(corners[kNeighbours[i][k]]);
                together |= 1U << places[k];
            }
            for (const std::size_t place : places) neighbours.together[place] |= together;
        }
    Vector3d largest = Vector3d::Zero();
    for (std::size_t v = 0; v < vertices.size(); ++v)
        for (std::size_t i = 0; i < around[v].count; ++i)
            for (std::size_t k = 0; k < i; ++k) {
                if ((around[v].together[i] >> k & 1U) != 0) continue;
                const Vector3d difference = positionOf(around[v].vertices[i]) -
                                            2 * positionOf(vertices[v]) +
                                            positionOf(around[v].vertices[k]);
                largest = largest.cwiseMax(difference.cwiseAbs());
            }
    return largest;
}

}  // namespace espalier::stencils
