// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/embed/cell_place.h>
#include <espalier/far/standard_cells.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "validity_pieces.h"

namespace espalier::solve {
namespace {

/// Returns the corner of a hexahedron, in VTK's order, at the end 0 or 1 of u, v and w.
std::size_t cornerAt(const std::array<std::size_t, 3>& place) {
    return 4 * place[2] + (place[1] == 1 ? 3 - place[0] : place[0]);
}

/// Volume of a box whose edge lengths change linearly from `first` to `last`, as Bernstein
/// coefficients.
std::array<double, 4> volumes(const std::array<double, 3>& first,
                              const std::array<double, 3>& last) {
    const auto mean = [](const std::array<double, 3>& one, const std::array<double, 3>& others) {
        return (one[0] * others[1] * others[2] + others[0] * one[1] * others[2] +
                others[0] * others[1] * one[2]) /
               3;
    };
    return {first[0] * first[1] * first[2], mean(last, first), mean(first, last),
            last[0] * last[1] * last[2]};
}

/// Upper bounds of the lengths: both ends may be off along all three axes.
std::array<double, 3> longest(const PieceSize& size) {
    const double longer = 2 * std::numbers::sqrt3 * size.uncertainty;
    return {size.lengths[0] + longer, size.lengths[1] + longer, size.lengths[2] + longer};
}

constexpr double kUnit = std::numeric_limits<double>::epsilon();

/// 512 units of rounding; a unit is half of epsilon.
constexpr double kRounding = 256 * kUnit;

/// Returns the rounding error that coefficients may have while a piece changes from `first` to
/// `last`.
std::array<double, 4> floorOf(const PieceSize& first, const PieceSize& last, double rounding) {
    const auto exact = volumes(first.lengths, last.lengths);
    const auto longer = volumes(longest(first), longest(last));
    std::array<double, 4> floor;
    // Below the smallest normal number, products lose digits.
    for (std::size_t i = 0; i < 4; ++i)
        floor[i] = longer[i] - exact[i] + rounding * longer[i] + std::numeric_limits<double>::min();
    return floor;
}

/// Returns a map from its Bézier points: point (i, j, k) is at index i + n (j + n k).
template <std::size_t Degree>
Piece<Degree> pieceOf(
    const std::array<Point3, (Degree + 1) * (Degree + 1) * (Degree + 1)>& points) {
    Piece<Degree> piece;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t stride = kAxisStride<Degree>[axis];
        std::size_t count = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (i / stride % (Degree + 1) == Degree) continue;
            const Point3 derivative =
                scaled(difference(points[i + stride], points[i]), static_cast<double>(Degree));
            piece.derivatives[axis][count++] = derivative;
            piece.size.lengths[axis] = std::max(piece.size.lengths[axis], length(derivative));
        }
    }
    return piece;
}

}  // namespace

Piece<3> pieceOf(const limit::BezierPatch& patch) {
    Piece<3> piece = pieceOf<3>(patch.points);
    piece.size.uncertainty = 3 * 48 * kUnit * patch.largestCoordinate;
    return piece;
}

CellPieces::CellPieces(const far::CellComplex& complex, Index cell)
    : complex_(complex), cell_(cell), corners_(far::hexahedronVertices(complex, cell_)) {}

Index CellPieces::count() const {
    return corners_ ? 1 : embed::tetrahedronCount(complex_, cell_);
}

Piece<1> CellPieces::piece(Index number, std::span<const Point3> positions) const {
    Piece<1> piece = corners_ ? hexahedron(positions) : tetrahedron(number, positions);
    for (const Index vertex : complex_.relation(3, 0)[cell_.value])
        for (const double coordinate : positions[vertex])
            piece.size.uncertainty =
                std::max(piece.size.uncertainty, 16 * kUnit * std::abs(coordinate));
    return piece;
}

Piece<1> CellPieces::hexahedron(std::span<const Point3> positions) const {
    std::array<Point3, 8> points;
    for (std::size_t i = 0; i < 8; ++i)
        points[i] = positions[(*corners_)[cornerAt({i % 2, i / 2 % 2, i / 4})]];
    return pieceOf<1>(points);
}

Piece<1> CellPieces::tetrahedron(Index number, std::span<const Point3> positions) const {
    // Measure from one of the vertices, so that a cell far from the origin loses no digits.
    const auto vertices = complex_.relation(3, 0)[cell_.value];
    const Point3& origin = positions[vertices.front()];
    Point3 apex{};
    double size = 0;
    for (const Index vertex : vertices) {
        const Point3 offset = difference(positions[vertex], origin);
        size = std::max(size, length(offset));
        for (std::size_t c = 0; c < 3; ++c)
            apex[c] += offset[c] / static_cast<double>(vertices.size());
    }
    auto base = embed::tetrahedronBase(complex_, cell_, number);
    const std::size_t face = number / 2;
    if (complex_.boundary(3).signs(cell_.value)[face] < 0) std::swap(base[1], base[2]);
    Piece<1> piece;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        piece.derivatives[axis].fill(difference(difference(positions[base[axis]], origin), apex));
        piece.size.lengths[axis] = size;
    }
    return piece;
}

double determinantFloor(const PieceSize& size) {
    return floorOf(size, size, kRounding)[0];
}

std::array<double, 4> determinantFloor(const PieceSize& first, const PieceSize& last) {
    return floorOf(first, last, 2 * kRounding);
}

CheckedVolume::CheckedVolume(const far::CellComplex& level) : cells_(level) {
    if (level.dimension() != 3)
        throw Error(concat("cells are checked in a lattice only, not in a complex of dimension ",
                           level.dimension()));
    for (Index face = 0; face < level.count(2); ++face)
        if (level.relation(2, 0)[face].size() != 4)
            throw Error(
                concat("face ", face,
                       " is not a quadrilateral: checking cells needs a lattice refined at least "
                       "once"));
}

CheckedVolume::CheckedVolume(const limit::LimitParts& limit)
    : cells_(limit.base()), limit_(limit) {}

Index CheckedVolume::partCount() const {
    return limit_ ? static_cast<Index>(limit_->parts().size()) : cells_.count(3);
}

Index CheckedVolume::cellOf(Index part) const {
    return limit_ ? limit_->parts()[part].baseCell : part;
}

limit::LimitPositions CheckedVolume::place(std::span<const Point3> positions) const {
    if (limit_) return limit_->place(positions);
    return {{}, {positions.begin(), positions.end()}};
}

}  // namespace espalier::solve
