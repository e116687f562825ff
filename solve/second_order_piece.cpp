// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/second_order_cells.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

#include "second_order_piece.h"

namespace espalier::solve {
namespace {

using far::CornerBits;
using far::StandardCell;

constexpr std::size_t kMaxPoints = 27;

/// The weights of the points of a cell in a point of its map.
using Row = std::array<double, kMaxPoints>;

/// A point of a map is one of 27 (of a face, 9): at 0, ½ or 1 along each axis.
using Grid = std::array<Row, 27>;

/// The points of a piece: weights of the points of the cell in each Bézier point.
struct BezierWeights {
    Grid rows = {};
    double largestSum = 0;  ///< of the absolute weights of a row
};

void add(Row& row, double factor, const Row& other) {
    for (std::size_t i = 0; i < row.size(); ++i) row[i] += factor * other[i];
}

/// The row of each place of a kind of cell or face.
class Places {
public:
    explicit Places(std::span<const CornerBits> places) : places_(places) {}

    /// Returns the weights of the points in a place: a corner, or the middle of an edge, of a
    /// quadrilateral or of the cell. A cell that has no point there gets the weights of
    /// serendipity cells.
    Row at(CornerBits place) const {
        Row row{};
        if (const auto found = std::ranges::find(places_, place); found != places_.end()) {
            row[found - places_.begin()] = 1;
            return row;
        }
        const double ofEdge = std::popcount(place) == 8 ? 0.25 : 0.5;
        for (std::size_t i = 0; i < places_.size(); ++i) {
            if ((places_[i] & ~place) != 0) continue;
            const int corners = std::popcount(places_[i]);
            row[i] = corners == 1 ? -0.25 : corners == 2 ? ofEdge : 0;
        }
        return row;
    }

private:
    std::span<const CornerBits> places_;
};

CornerBits bit(std::size_t corner) {
    return static_cast<CornerBits>(1u << corner);
}

/// Returns the corners of a square that a place of the grid lies between: 0 and 1 at its lower
/// side, 3 and 2 above them.
CornerBits ofSquare(std::size_t i, std::size_t j) {
    CornerBits place = 0;
    for (std::size_t corner = 0; corner < 4; ++corner) {
        const std::size_t u = corner == 1 || corner == 2 ? 2 : 0, v = corner >= 2 ? 2 : 0;
        if ((i == 1 || i == u) && (j == 1 || j == v)) place |= bit(corner);
    }
    return place;
}

/// Returns the weights at a point of a simplex of second order, which has the barycentric
/// coordinates `lambda`.
/// \param rowOf the weights of a corner, or of the middle of two corners
template <std::size_t Corners, class RowOf>
Row inSimplex(const std::array<double, Corners>& lambda, RowOf rowOf) {
    Row row{};
    for (std::size_t a = 0; a < Corners; ++a) {
        add(row, lambda[a] * (2 * lambda[a] - 1), rowOf(a, a));
        for (std::size_t b = 0; b < a; ++b) add(row, 4 * lambda[a] * lambda[b], rowOf(a, b));
    }
    return row;
}

/// Barycentric coordinates in a triangle whose corner 1 is the collapsed side u = 1.
std::array<double, 3> inTriangle(double u, double v) {
    return {(1 - u) * (1 - v), u, v * (1 - u)};
}

/// Barycentric coordinates in a tetrahedron whose corner 1 is the collapsed side u = 1, and whose
/// corner 2 is the collapsed edge v = 1.
std::array<double, 4> inTetrahedron(double u, double v, double w) {
    return {(1 - u) * (1 - v) * (1 - w), u, v * (1 - u), w * (1 - u) * (1 - v)};
}

/// Returns the row of a point of the map of a cell.
Row rowOfCell(const Places& places, StandardCell kind, std::array<std::size_t, 3> at) {
    const std::size_t i = at[0], j = at[1], k = at[2];
    const double u = 0.5 * static_cast<double>(i), v = 0.5 * static_cast<double>(j),
                 w = 0.5 * static_cast<double>(k);
    switch (kind) {
        case StandardCell::Tetrahedron:
            return inSimplex(inTetrahedron(u, v, w), [&](std::size_t a, std::size_t b) {
                return places.at(bit(a) | bit(b));
            });
        case StandardCell::Wedge: {
            // VTK's first triangle is clockwise seen from the other one.
            constexpr std::array<std::size_t, 3> kOrder = {0, 2, 1};
            return inSimplex(inTriangle(u, v), [&](std::size_t a, std::size_t b) {
                const unsigned lower = bit(kOrder[a]) | bit(kOrder[b]), upper = lower << 3;
                return places.at(static_cast<CornerBits>(k == 0   ? lower
                                                         : k == 2 ? upper
                                                                  : lower | upper));
            });
        }
        case StandardCell::Pyramid: {
            const Row base = places.at(ofSquare(i, j));
            if (k == 0) return base;
            constexpr std::size_t kApex = 4;
            if (k == 2) return places.at(bit(kApex));
            // At half of the height, quadratic terms of the base count ¼. So a quarter of the base
            // is right up to bilinear terms, which the middles of the four edges determine.
            Row row{};
            add(row, 0.25, base);
            const std::array<double, 4> weights = {(1 - u) * (1 - v), u * (1 - v), u * v,
                                                   (1 - u) * v};
            for (std::size_t corner = 0; corner < 4; ++corner) {
                add(row, weights[corner], places.at(bit(corner) | bit(kApex)));
                add(row, -0.25 * weights[corner], places.at(bit(corner)));
            }
            return row;
        }
        case StandardCell::Hexahedron:
            break;
    }
    const unsigned square = ofSquare(i, j);
    return places.at(static_cast<CornerBits>((k == 2 ? 0 : square) | (k == 0 ? 0 : square << 4)));
}

Row rowOfFace(const Places& places, bool isTriangle, std::size_t i, std::size_t j) {
    if (!isTriangle) return places.at(ofSquare(i, j));
    return inSimplex(inTriangle(0.5 * static_cast<double>(i), 0.5 * static_cast<double>(j)),
                     [&](std::size_t a, std::size_t b) { return places.at(bit(a) | bit(b)); });
}

/// Turns the points of a map at 0, ½ and 1 into its Bézier points.
BezierWeights toBezier(Grid rows) {
    for (const std::size_t stride : kAxisStride<2>)
        for (std::size_t i = 0; i < rows.size(); ++i) {
            if (i / stride % 3 != 1) continue;
            for (std::size_t point = 0; point < kMaxPoints; ++point)
                rows[i][point] =
                    2 * rows[i][point] - 0.5 * (rows[i - stride][point] + rows[i + stride][point]);
        }
    BezierWeights result{rows};
    for (const Row& row : rows) {
        double sum = 0;
        for (const double weight : row) sum += std::abs(weight);
        result.largestSum = std::max(result.largestSum, sum);
    }
    return result;
}

BezierWeights makeCellWeights(std::size_t pointCount) {
    const Places places(far::cellPoints(pointCount));
    const StandardCell kind = far::kindOfCell(pointCount).value();
    Grid rows;
    for (std::size_t i = 0; i < rows.size(); ++i)
        rows[i] = rowOfCell(places, kind, {i % 3, i / 3 % 3, i / 9});
    return toBezier(rows);
}

BezierWeights makeFaceWeights(std::size_t pointCount) {
    constexpr std::array<CornerBits, 6> kTriangle = {1, 2, 4, 1 | 2, 2 | 4, 4 | 1};
    constexpr std::array<CornerBits, 9> kSquare = {1, 2, 4, 8, 1 | 2, 2 | 4, 4 | 8, 8 | 1, 15};
    const bool isTriangle = pointCount == kTriangle.size();
    const Places places(isTriangle ? std::span<const CornerBits>(kTriangle)
                                   : std::span<const CornerBits>(kSquare).first(pointCount));
    Grid rows;
    for (std::size_t i = 0; i < rows.size(); ++i)
        rows[i] = rowOfFace(places, isTriangle, i % 3, i / 3 % 3);
    return toBezier(rows);
}

/// Returns the weights of a number of points, which are made once.
template <BezierWeights (*make)(std::size_t), std::size_t PointCount>
const BezierWeights& weightsOf() {
    static const BezierWeights kWeights = make(PointCount);
    return kWeights;
}

const BezierWeights& cellWeights(std::size_t pointCount) {
    switch (pointCount) {
        case 10:
            return weightsOf<makeCellWeights, 10>();
        case 13:
            return weightsOf<makeCellWeights, 13>();
        case 14:
            return weightsOf<makeCellWeights, 14>();
        case 15:
            return weightsOf<makeCellWeights, 15>();
        case 18:
            return weightsOf<makeCellWeights, 18>();
        case 20:
            return weightsOf<makeCellWeights, 20>();
        default:
            return weightsOf<makeCellWeights, 27>();
    }
}

const BezierWeights& faceWeights(std::size_t pointCount) {
    switch (pointCount) {
        case 6:
            return weightsOf<makeFaceWeights, 6>();
        case 8:
            return weightsOf<makeFaceWeights, 8>();
        default:
            return weightsOf<makeFaceWeights, 9>();
    }
}

/// Returns the piece of a map, with the uncertainty of its Bézier points.
Piece<2> mapOf(const BezierWeights& weights, std::span<const Index> points,
               std::span<const Point3> positions) {
    // Measured from a corner, so that a cell far from the origin loses no digits.
    std::array<Point3, kMaxPoints> offsets;
    double size = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        offsets[i] = difference(positions[points[i]], positions[points[0]]);
        size = std::max(size, largestCoordinate(offsets[i]));
    }
    std::array<Point3, 27> bezier{};
    for (std::size_t i = 0; i < bezier.size(); ++i)
        for (std::size_t point = 0; point < points.size(); ++point)
            for (std::size_t c = 0; c < 3; ++c)
                bezier[i][c] += weights.rows[i][point] * offsets[point][c];
    Piece<2> piece = pieceOf<2>(bezier);
    // Derivatives are twice the differences of Bézier points; each division may double them. The
    // sums have up to 27 terms.
    constexpr double kDerivatives = 2 * 4, kTerms = kMaxPoints + 8;
    piece.size.uncertainty = kDerivatives * weights.largestSum *
                             (meshUncertainty(points, positions) + kTerms * kEpsilon * size);
    return piece;
}

/// Divides a derivative by 1 less the coordinate of an axis. It vanishes at the upper end of this
/// axis, where it has degree 2.
void divide(Piece<2>& piece, std::size_t derivative, std::size_t axis) {
    // The derivative has two coefficients along its own axis, and three along the others.
    std::size_t stride = 1;
    for (std::size_t before = 0; before < axis; ++before) stride *= before == derivative ? 2 : 3;
    auto& coefficients = piece.derivatives[derivative];
    for (std::size_t i = 0; i < coefficients.size(); ++i) {
        if (i / stride % 3 != 0) continue;
        const Point3 first = coefficients[i], second = coefficients[i + stride];
        coefficients[i + stride] = sum(scaled(first, 0.5), second);
        coefficients[i + 2 * stride] = scaled(second, 2);
    }
}

/// Returns the mean of the determinant over the cube, which is the mean of its coefficients.
double meanOf(const Piece<2>& piece) {
    const auto polynomial = determinant(piece.derivatives);
    double sum = 0;
    for (const auto& coefficient : polynomial) sum += coefficient[0];
    return sum / static_cast<double>(polynomial.size());
}

void measure(Piece<2>& piece) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double& longest = piece.size.lengths[axis];
        longest = 0;
        for (const Point3& derivative : piece.derivatives[axis])
            longest = std::max(longest, sizeOf(derivative));
    }
}

}  // namespace

Piece<2> secondOrderCell(std::span<const Index> points, std::span<const Point3> positions) {
    constexpr std::size_t kU = 0, kV = 1, kW = 2;
    Piece<2> piece = mapOf(cellWeights(points.size()), points, positions);
    switch (far::kindOfCell(points.size()).value()) {
        case StandardCell::Tetrahedron:
            divide(piece, kV, kU);
            divide(piece, kW, kU);
            divide(piece, kW, kV);
            break;
        case StandardCell::Wedge:
            divide(piece, kV, kU);
            break;
        case StandardCell::Pyramid:
            divide(piece, kU, kW);
            divide(piece, kV, kW);
            break;
        case StandardCell::Hexahedron:
            return piece;
    }
    measure(piece);
    return piece;
}

double secondOrderVolume(std::span<const Index> points, std::span<const Point3> positions) {
    // With the factors that vanish where the cube is collapsed, this is the integral over the cell.
    return meanOf(mapOf(cellWeights(points.size()), points, positions));
}

double secondOrderArea(std::span<const Index> points, std::span<const Point3> positions,
                       const Point3& normal) {
    Piece<2> piece = mapOf(faceWeights(points.size()), points, positions);
    piece.derivatives[2].fill(normal);
    return meanOf(piece);
}

Piece<2> secondOrderFace(std::span<const Index> points, std::span<const Point3> positions,
                         const Point3& normal) {
    Piece<2> piece = mapOf(faceWeights(points.size()), points, positions);
    if (points.size() == 6) divide(piece, 1, 0);
    piece.derivatives[2].fill(normal);
    measure(piece);
    return piece;
}

}  // namespace espalier::solve
