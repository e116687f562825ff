// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/cell_bounds.h>
#include <espalier/embed/cell_frame.h>
#include <espalier/embed/regular_cells.h>

#include <Eigen/LU>
#include <algorithm>

namespace espalier::embed {

using Eigen::Vector3d;

CellBounds::CellBounds(const far::Level& level, std::span<const Point3> positions,
                       far::Creasing creasing)
    : level_(level),
      positions_(positions),
      mayExtrapolate_(creasing == far::Creasing::Chaikin && level.strata.hasSemiSharp()) {}

std::optional<CellBound> CellBounds::boundOf(Index cell, const std::optional<Vector3d>& inherited) {
    CellBound bound;
    if (inherited) bound.drift = *inherited / 4;
    // Three axes, with a sixth of the second difference each.
    if (!bound.drift && isRegular(cell)) bound.drift = largestSecondDifference(cell) / 2;
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

namespace {

/// Returns the value of an entity in a cache, which is allocated on first use: regular lattices
/// never need some of the caches, and lattices without regular cells never need the others.
template <class Value>
Value& valueIn(std::vector<Value>& cache, const far::CellComplex& complex, Entity entity) {
    if (cache.empty()) cache.resize(complex.count(entity.dimension));
    return cache[entity.index];
}

}  // namespace

const CellBounds::Box& CellBounds::boxOf(Index cell) {
    auto& box = valueIn(ofCell_, level_.complex, {3, cell});
    if (!box) {
        box.emplace();
        for (const Index corner : level_.complex.relation(3, 0)[cell])
            box->extend(positionOf(corner));
    }
    return *box;
}

const CellBounds::Box& CellBounds::boxAround(Index vertex) {
    auto& box = valueIn(aroundVertex_, level_.complex, {0, vertex});
    if (!box) {
        box.emplace();
        for (const Index cell : level_.complex.relation(0, 3)[vertex]) box->extend(boxOf(cell));
    }
    return *box;
}

const std::optional<CellFrame>& CellBounds::hexahedron(Index cell) {
    auto& frame = valueIn(hexahedra_, level_.complex, {3, cell});
    if (!frame) frame = frameOf(level_.complex, cell);
    return frame;
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

/// Returns true if no new point around a cell has a negative weight, on this level or a later one.
bool CellBounds::staysInHull(Index cell) {
    const auto vertices = level_.complex.relation(3, 0)[cell];
    return !mayExtrapolate_ && std::all_of(vertices.begin(), vertices.end(), [&](Index vertex) {
        auto& stays = valueIn(staysInHull_, level_.complex, {0, vertex});
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

/// Returns true if the cell is regular: see isRegularCell().
bool CellBounds::isRegular(Index cell) {
    const auto vertices = level_.complex.relation(3, 0)[cell];
    return std::all_of(vertices.begin(), vertices.end(), [&](Index vertex) {
        auto& isRegular = valueIn(isRegular_, level_.complex, {0, vertex});
        if (!isRegular)
            isRegular = isRegularVertex(
                level_, vertex, [&](Index around) { return hexahedron(around).has_value(); });
        return *isRegular;
    });
}

/// Returns, for each coordinate, the largest |P₋ − 2P + P₊| over the vertices P of the cells around
/// a regular cell, which are a grid. P₋ and P₊ are the neighbours of P along one axis; all three
/// must be vertices of these cells.
///
/// P₋, P and P₊ are on two edges that leave a face with P on its two sides. The faces between two
/// cells of the grid are the faces with two cells that contain a corner of the middle cell.
Vector3d CellBounds::largestSecondDifference(Index cell) {
    Vector3d largest = Vector3d::Zero();
    for (const Index corner : level_.complex.relation(3, 0)[cell])
        largest = largest.cwiseMax(secondDifferenceAround(corner));
    return largest;
}

/// Returns the largest second difference across the faces around a regular vertex.
const Vector3d& CellBounds::secondDifferenceAround(Index vertex) {
    auto& largest = valueIn(secondDifferenceAround_, level_.complex, {0, vertex});
    if (!largest) {
        largest = Vector3d::Zero();
        const far::Incidence& cells = level_.complex.relation(2, 3);
        for (const Index face : level_.complex.relation(0, 2)[vertex])
            if (cells[face].size() == 2) *largest = largest->cwiseMax(secondDifferenceAcross(face));
    }
    return *largest;
}

/// Returns the largest second difference at the corners of a face, along the edges that leave the
/// face in its two cells, which are hexahedra.
const Vector3d& CellBounds::secondDifferenceAcross(Index face) {
    auto& largest = valueIn(secondDifferenceAcross_, level_.complex, {2, face});
    if (!largest) {
        const auto corners = level_.complex.relation(2, 0)[face];
        const auto cells = level_.complex.relation(2, 3)[face];
        largest = Vector3d::Zero();
        const CellFrame& before = *hexahedron(cells[0]);
        const CellFrame& after = *hexahedron(cells[1]);
        for (const Index corner : corners) {
            const Vector3d difference = positionOf(beyond(before, corners, corner)) -
                                        2 * positionOf(corner) +
                                        positionOf(beyond(after, corners, corner));
            *largest = largest->cwiseMax(difference.cwiseAbs());
        }
    }
    return *largest;
}

/// Returns the vertex of a hexahedron that an edge joins to a corner of a face, outside the face.
Index CellBounds::beyond(const CellFrame& frame, std::span<const Index> face, Index corner) {
    const auto& corners = frame.corners;
    const std::size_t at = std::find(corners.begin(), corners.end(), corner) - corners.begin();
    for (std::size_t axis = 0; axis < 2; ++axis)
        if (const Index end = corners[at ^ std::size_t{1} << axis]; !far::contains(face, end))
            return end;
    return corners[at ^ std::size_t{4}];
}

}  // namespace espalier::embed
