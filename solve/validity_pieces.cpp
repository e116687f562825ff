// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/standard_cells.h>
#include <espalier/solve/validity_pieces.h>
#include <espalier/stencils/cell_place.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace espalier::solve {
namespace {

Point3 edge(const Point3& from, const Point3& to) {
    return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

double length(const Point3& edge) {
    return std::hypot(edge[0], edge[1], edge[2]);
}

const Point3& at(std::span<const Point3> positions, Index vertex) {
    return positions[static_cast<std::size_t>(vertex)];
}

/// The corner of a hexahedron at places (0 or 1) along u, v and w, in VTK's order.
std::size_t cornerAt(const std::array<std::size_t, 3>& place) {
    return 4 * place[2] + (place[1] == 1 ? 3 - place[0] : place[0]);
}

}  // namespace

CellPieces::CellPieces(const far::CellComplex& complex, Index cell)
    : complex_(complex), cell_(cell), corners_(far::hexahedronVertices(complex, cell_)) {}

Index CellPieces::count() const {
    return corners_ ? 1 : stencils::tetrahedronCount(complex_, cell_);
}

Piece CellPieces::piece(Index number, std::span<const Point3> positions) const {
    return corners_ ? hexahedron(positions) : tetrahedron(number, positions);
}

Piece CellPieces::hexahedron(std::span<const Point3> positions) const {
    Piece piece{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t i = 0; i < 4; ++i) {
            std::array<std::size_t, 3> place{};
            place[(axis + 1) % 3] = i % 2;
            place[(axis + 2) % 3] = i / 2;
            const Point3& from = at(positions, (*corners_)[cornerAt(place)]);
            place[axis] = 1;
            const Point3& to = at(positions, (*corners_)[cornerAt(place)]);
            piece.derivatives[axis][i] = edge(from, to);
            piece.lengths[axis] = std::max(piece.lengths[axis], length(piece.derivatives[axis][i]));
        }
    return piece;
}

Piece CellPieces::tetrahedron(Index number, std::span<const Point3> positions) const {
    // From one of the vertices, so that where the cell lies does not cost digits.
    const auto vertices = complex_.relation(3, 0)[cell_.value];
    const Point3& origin = at(positions, vertices.front());
    Point3 apex{};
    double size = 0;
    for (const Index vertex : vertices) {
        const Point3 offset = edge(origin, at(positions, vertex));
        size = std::max(size, length(offset));
        for (std::size_t c = 0; c < 3; ++c)
            apex[c] += offset[c] / static_cast<double>(vertices.size());
    }
    auto base = stencils::tetrahedronBase(complex_, cell_, number);
    const auto face = static_cast<std::size_t>(number / 2);
    if (complex_.boundary(3).signs(cell_.value)[face] < 0) std::swap(base[1], base[2]);
    Piece piece{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        piece.derivatives[axis].fill(edge(apex, edge(origin, at(positions, base[axis]))));
        piece.lengths[axis] = size;
    }
    return piece;
}

double determinantFloor(const std::array<double, 3>& lengths) {
    constexpr double kRounding = 256 * std::numeric_limits<double>::epsilon();
    // Below the least normal number, products lose digits.
    return kRounding * lengths[0] * lengths[1] * lengths[2] + std::numeric_limits<double>::min();
}

}  // namespace espalier::solve
