// SPDX-License-Identifier: Apache-2.0
#include "piece.h"

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

/// Returns the rounding error that coefficients may have while a piece changes from `first` to
/// `last`.
std::array<double, 4> floorsOf(const PieceSize& first, const PieceSize& last, double rounding) {
    const auto exact = volumes(first.lengths, last.lengths);
    const auto longer = volumes(first.longest(), last.longest());
    std::array<double, 4> floor;
    for (std::size_t i = 0; i < 4; ++i) floor[i] = floorOf(exact[i], longer[i], rounding);
    return floor;
}

}  // namespace

using Positions = std::span<const Point3>;

double largestAmong(std::span<const Index> vertices, Positions positions) {
    double largest = 0;
    for (const Index vertex : vertices)
        largest = std::max(largest, largestCoordinate(positions[vertex]));
    return largest;
}

Piece<1> trilinear(std::span<const Index> corners, Positions positions) {
    std::array<Point3, 8> points;
    for (std::size_t i = 0; i < 8; ++i)
        points[i] = positions[corners[cornerAt({i % 2, i / 2 % 2, i / 4})]];
    return pieceOf<1>(points);
}

Piece<3> pieceOf(const limit::BezierPatch& patch) {
    Piece<3> piece = pieceOf<3>(patch.points);
    piece.size.uncertainty = 3 * 48 * kEpsilon * patch.largestCoordinate;
    return piece;
}

std::array<double, 4> determinantFloor(const PieceSize& first, const PieceSize& last) {
    return floorsOf(first, last, 2 * kDeterminantRounding);
}

}  // namespace espalier::solve
