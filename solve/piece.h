// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/point.h>
#include <espalier/base/vector3.h>
#include <espalier/limit/limit_parts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "bernstein.h"

// The maps whose determinants are checked, and the rounding of these determinants.
namespace espalier::solve {

/// Two units of rounding.
inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// Returns the length of a derivative, below 1e91. Unlike length() it need not avoid overflow,
/// which takes four times as long.
inline double sizeOf(const Point3& derivative) {
    return std::sqrt(dot(derivative, derivative));
}

inline double largestCoordinate(const Point3& point) {
    return std::max({std::abs(point[0]), std::abs(point[1]), std::abs(point[2])});
}

/// The sizes of derivatives, and their uncertainty.
struct PieceSize {
    /// The longest derivative along each axis. In a tetrahedron the size of the cell instead, since
    /// the apex is a mean over the cell. The rounding of derivatives is proportional to this.
    std::array<double, 3> lengths = {};

    /// Upper bound of the rounding error of each coordinate at the ends of the differences that
    /// derivatives are. Positions are sums of products of up to 27 numbers, level by level: 16
    /// units of the largest coordinate cover this. Another 32 cover the conversion to Bézier
    /// points, which is 3 times a sum of |weights| of 2.4 and of 6 terms along each axis. For
    /// cubics the total is multiplied by 3, since their derivatives are 3 times differences.
    double uncertainty = 0;

    /// Upper bounds of the lengths: both ends may be off along all three axes.
    std::array<double, 3> longest() const {
        const double longer = 2 * std::numbers::sqrt3 * uncertainty;
        return {lengths[0] + longer, lengths[1] + longer, lengths[2] + longer};
    }
};
/// A map from the unit cube. Degree 0: a tetrahedron. Degree 1: a hexahedron. Degree 2: a cell of
/// second order. Degree 3: a patch of the limit.
template <std::size_t Degree>
struct Piece {
    Derivatives<Degree> derivatives;
    PieceSize size = {};
};
/// Returns a map from its Bézier points: point (i, j, k) is at index i + n (j + n k). The
/// uncertainty is left to the caller.
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
            piece.size.lengths[axis] = std::max(piece.size.lengths[axis], sizeOf(derivative));
        }
    }
    return piece;
}

Piece<3> pieceOf(const limit::BezierPatch& patch);

/// Returns the map of a hexahedron, without its uncertainty.
/// \param corners in VTK's order
Piece<1> trilinear(std::span<const Index> corners, std::span<const Point3> positions);

double largestAmong(std::span<const Index> points, std::span<const Point3> positions);

/// Returns the rounding error of the points of a mesh. They are given exactly, but the points on
/// the way to a pose are rounded: a product, and a sum.
inline double meshUncertainty(std::span<const Index> points, std::span<const Point3> positions) {
    return 2 * kEpsilon * largestAmong(points, positions);
}

/// 512 units of rounding; a unit is half of epsilon.
inline constexpr double kDeterminantRounding = 256 * kEpsilon;

/// Returns the rounding error of a coefficient.
/// \param exact, longer volumes of the box of the lengths, and of their upper bounds
inline double floorOf(double exact, double longer, double rounding) {
    // Below the smallest normal number, products lose digits.
    return longer - exact + rounding * longer + std::numeric_limits<double>::min();
}

/// Returns the value that a determinant must exceed to count as positive: its change when edges
/// become longer by their uncertainty, plus 6e-14 of the product of the lengths, which is 512 units
/// of rounding. The units cover all rounding of the coefficients:
///
/// - 3 for edges, 12 for determinants of edges, 24 for their sums, and 60 for halvings;
/// - in a type-n cell 2n + 2 for each edge of its tetrahedra, for n up to about 50;
/// - in a patch 12 for determinants, 84 for sums of 36 and 48 of them, and 240 for halvings.
///
/// \param roundings how many times this rounding is allowed for
inline double determinantFloor(const PieceSize& size, double roundings = 1) {
    const auto volume = [](const std::array<double, 3>& lengths) {
        return lengths[0] * lengths[1] * lengths[2];
    };
    return floorOf(volume(size.lengths), volume(size.longest()), roundings * kDeterminantRounding);
}

/// Returns the same bound while a piece changes linearly from `first` to `last`: Bernstein
/// coefficients of degree 3 in time, as for determinant(). It allows for twice the rounding, since
/// sums have twice as many terms and time is halved up to 60 times, by 3 units each.
std::array<double, 4> determinantFloor(const PieceSize& first, const PieceSize& last);

/// Returns an upper bound of these four coefficients, which takes a tenth of their time.
inline double largestFloor(const PieceSize& first, const PieceSize& last) {
    PieceSize larger = first;
    for (std::size_t axis = 0; axis < 3; ++axis)
        larger.lengths[axis] = std::max(larger.lengths[axis], last.lengths[axis]);
    larger.uncertainty = std::max(first.uncertainty, last.uncertainty);
    // Two roundings are those of the coefficients, and two more cover the rounding of this bound.
    return determinantFloor(larger, 4);
}

}  // namespace espalier::solve
