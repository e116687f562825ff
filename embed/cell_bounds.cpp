// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/sort_unique.h>
#include <espalier/embed/cell_bounds.h>
#include <espalier/embed/cell_frame.h>
#include <espalier/embed/regular_cells.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace espalier::embed {

using Eigen::Vector3d;

CellBounds::CellBounds(const far::Level& level, std::span<const Point3> positions,
                       far::Creasing creasing)
    : level_(level),
      positions_(positions),
      mayExtrapolate_(creasing == far::Creasing::Chaikin && level.strata.hasSemiSharp()),
      aroundVertex_(level.complex.count(0)),
      staysInHull_(level.complex.count(0)) {}

std::optional<CellBound> CellBounds::boundOf(Index cell, const std::optional<Vector3d>& inherited) {
    CellBound bound;
    if (inherited) bound.drift = *inherited / 4;
    // Three axes, with a sixth of the second difference each.
    if (!bound.drift && isRegularCell(level_, cell))
        bound.drift = largestSecondDifference(ringOf(cell)) / 2;
    if (bound.drift) {
        if (!bound.drift->allFinite()) return std::nullopt;  // Coordinates near the largest double.
        bound.box = ownBox(cell).box;
        bound.box.min() -= *bound.drift;
        bound.box.max() += *bound.drift;
        return bound;
    }
    if (!staysInHull(cell)) return std::nullopt;
    for (const Index vertex : level_.complex.relation(3, 0)[cell])
        bound.box.extend(boxAround(vertex));
    return bound;
}

const CellBounds::Box& CellBounds::boxOf(Index cell) {
    // Allocated on first use: regular lattices never need it.
    if (ofCell_.empty()) ofCell_.resize(level_.complex.count(3));
    auto& box = ofCell_[cell];
    if (!box) {
        box.emplace();
        for (const Index corner : level_.complex.relation(3, 0)[cell])
            box->extend(positionOf(corner));
    }
    return *box;
}

const CellBounds::Box& CellBounds::boxAround(Index vertex) {
    auto& box = aroundVertex_[vertex];
    if (!box) {
        box.emplace();
        for (const Index cell : level_.complex.relation(0, 3)[vertex]) box->extend(boxOf(cell));
    }
    return *box;
}

const CellFrame& CellBounds::hexahedron(Index cell) {
    // Allocated on first use: lattices without regular cells never need it.
    if (hexahedra_.empty()) hexahedra_.resize(level_.complex.count(3));
    auto& frame = hexahedra_[cell];
    if (!frame) frame = frameOf(level_.complex, cell);
    return *frame;
}

CellBound CellBounds::ownBox(Index cell, double widening) const {
    CellBound bound;
    for (const Index vertex : level_.complex.relation(3, 0)[cell])
        bound.box.extend(positionOf(vertex));
    const double margin = widening * bound.box.diagonal().norm();
    bound.box.min().array() -= margin;
    bound.box.max().array() += margin;
    bound.drift = Vector3d::Constant(margin);
    return bound;
}

AffineHull CellBounds::ownHull(Index cell, double widening) const {
    AffineHull hull(axesOf(cell).inverse());
    for (const Index vertex : level_.complex.relation(3, 0)[cell]) hull.extend(positionOf(vertex));
    hull.widen(widening);
    return hull;
}

/// Returns three directions of a cell, linearly independent unless the cell is flat: in a
/// hexahedron the means of its edges along each axis, in any other cell three edges that meet in a
/// vertex.
Eigen::Matrix3d CellBounds::axesOf(Index cell) const {
    Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
    if (const auto frame = frameOf(level_.complex, cell)) {
        for (std::size_t corner = 0; corner < 8; ++corner)
            for (std::size_t axis = 0; axis < 3; ++axis)
                axes.col(static_cast<Eigen::Index>(axis)) +=
                    (bitOf(corner, axis) != 0 ? 0.25 : -0.25) * positionOf(frame->corners[corner]);
        return axes;
    }
    const Index corner = level_.complex.relation(3, 0)[cell].front();
    Eigen::Index count = 0;
    for (const Index edge : level_.complex.relation(3, 1)[cell]) {
        const auto ends = level_.complex.relation(1, 0)[edge];
        if (ends[0] != corner && ends[1] != corner) continue;
        const Index other = ends[0] == corner ? ends[1] : ends[0];
        if (count < 3) axes.col(count++) = positionOf(other) - positionOf(corner);
    }
    return axes;
}

std::vector<Index> CellBounds::ringOf(Index cell) const {
    std::vector<Index> ring;
    for (const Index vertex : level_.complex.relation(3, 0)[cell]) {
        const auto cells = level_.complex.relation(0, 3)[vertex];
        ring.insert(ring.end(), cells.begin(), cells.end());
    }
    sortUnique(ring);
    return ring;
}

/// Returns true if no new point around a cell has a negative weight, on this level or a later one.
bool CellBounds::staysInHull(Index cell) {
    const auto vertices = level_.complex.relation(3, 0)[cell];
    return !mayExtrapolate_ && std::all_of(vertices.begin(), vertices.end(), [&](Index vertex) {
        auto& stays = staysInHull_[vertex];
        if (!stays) stays = isConvexAround(vertex);
        return *stays;
    });
}

/// Returns true if no new point around a vertex has a negative weight, on this level or a later
/// one.
bool CellBounds::isConvexAround(Index vertex) const {
    std::size_t surfaceEdges = 0;
    for (const Index edge : level_.complex.relation(0, 1)[vertex]) {
        if (level_.strata.isOpen({1, edge})) continue;  // An open edge has no new point.
        if (level_.strata.smoothStratum({1, edge}) == 2)
            ++surfaceEdges;
        else if (level_.complex.relation(1, 2)[edge].size() == 2)
            return false;  // The mask (C̄ + 2Ā − M)/2 has a negative weight.
    }
    // With two surface edges, the mask (Ā + 2M̄ − P)/2 has a negative weight.
    return level_.strata.smoothStratum({0, vertex}) != 2 || surfaceEdges != 2;
}

namespace {

/// The neighbours of a vertex in a grid, at most 6.
struct Neighbours {
    std::array<Index, 6> vertices = {};
    std::size_t count = 0;
    std::array<unsigned, 6> together = {};  ///< bit k: some cell contains this neighbour and
                                            ///< vertices[k]

    /// Returns the position of a neighbour in `vertices`. Adds it if it is new.
    std::size_t placeOf(Index neighbour) {
        const auto at = std::find(vertices.begin(), vertices.begin() + count, neighbour);
        if (at == vertices.begin() + count) vertices[count++] = neighbour;
        return static_cast<std::size_t>(at - vertices.begin());
    }
};

}  // namespace

/// Returns, for each coordinate, the largest |P₋ − 2P + P₊| over the vertices P of `ring`, which is
/// a grid of cells. P₋ and P₊ are neighbours of P along one axis: neighbours that no cell has in
/// common.
Vector3d CellBounds::largestSecondDifference(const std::vector<Index>& ring) {
    std::vector<Index> vertices;
    for (const Index cell : ring) {
        const auto& corners = hexahedron(cell).corners;
        vertices.insert(vertices.end(), corners.begin(), corners.end());
    }
    sortUnique(vertices);
    std::vector<Neighbours> around(vertices.size());
    for (const Index cell : ring)
        for (std::size_t i = 0; i < 8; ++i) {
            const auto& corners = hexahedron(cell).corners;
            const auto at = std::lower_bound(vertices.begin(), vertices.end(), corners[i]);
            Neighbours& neighbours = around[at - vertices.begin()];
            std::array<std::size_t, 3> places;
            unsigned together = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                places[axis] = neighbours.placeOf(corners[i ^ std::size_t{1} << axis]);
                together |= 1U << places[axis];
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

}  // namespace espalier::embed
