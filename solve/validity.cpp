// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/solve/bernstein_bounds.h>
#include <espalier/solve/validity.h>
#include <espalier/solve/validity_pieces.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace espalier::solve {
namespace {

using far::CellComplex;
using far::Offset;

/// Cells that one thread takes at a time.
constexpr Offset kGrain = 1024;

std::size_t at(Index index) {
    return static_cast<std::size_t>(index);
}

/// \param name of the positions, in messages
void checkPositions(const CellComplex& complex, std::span<const Point3> positions,
                    const char* name) {
    constexpr double kMost = 1e90;
    if (positions.size() != at(complex.count(0)))
        throw Error("got " + std::to_string(positions.size()) + " positions of the " + name +
                    " for " + std::to_string(complex.count(0)) + " vertices");
    for (std::size_t vertex = 0; vertex < positions.size(); ++vertex)
        for (const double coordinate : positions[vertex])
            if (!(std::abs(coordinate) <= kMost))
                throw Error(
                    "the " + std::string(name) + " of vertex " + std::to_string(vertex) +
                    (std::isfinite(coordinate) ? " is too far from the origin" : " is not finite"));
}

const CellComplex& checkedLattice(const CellComplex& complex) {
    if (complex.dimension() != 3)
        throw Error("cells are checked in a lattice only, not in a complex of dimension " +
                    std::to_string(complex.dimension()));
    for (Index face = 0; face < complex.count(2); ++face)
        if (complex.relation(2, 0)[face].size() != 4)
            throw Error("face " + std::to_string(face) +
                        " is not a quadrilateral: checking cells needs a lattice refined at least "
                        "once");
    return complex;
}

/// What is left of a determinant above its floor, turned so that it is positive at rest.
template <std::size_t Lanes>
Triquadratics<Lanes> aboveFloor(Triquadratics<Lanes> determinant, int orientation,
                                const std::array<double, Lanes>& floor) {
    for (auto& lanes : determinant)
        for (std::size_t lane = 0; lane < Lanes; ++lane)
            lanes[lane] = orientation * lanes[lane] - floor[lane];
    return determinant;
}

/// The sign of the determinant all over a cell; 0 if it has none.
std::int8_t orientationOf(const CellComplex& complex, Index cell, std::span<const Point3> rest) {
    const CellPieces pieces(complex, cell);
    std::int8_t orientation = 0;
    for (Index i = 0; i < pieces.count(); ++i) {
        const Piece piece = pieces.piece(i, rest);
        const auto polynomial = determinant(piece.derivatives);
        const std::int8_t sign = polynomial[0][0] > 0 ? 1 : -1;
        if (sign == -orientation ||
            !isPositive(aboveFloor(polynomial, sign, {determinantFloor(piece)})))
            return 0;
        orientation = sign;
    }
    return orientation;
}

/// Takes their orientation from cells that are turned against most of those that they are joined
/// to by faces; in doubt, against the lowest of them.
void dropTurned(const CellComplex& complex, std::vector<std::int8_t>& orientation) {
    const far::Incidence& faces = complex.relation(3, 2);
    const far::Incidence& cells = complex.relation(2, 3);
    std::vector<char> isSeen(orientation.size(), 0);
    std::vector<Index> joined;
    for (Index start = 0; start < complex.count(3); ++start) {
        if (isSeen[at(start)]) continue;
        joined = {start};
        isSeen[at(start)] = 1;
        Index sum = 0;
        std::int8_t first = 0;
        for (std::size_t i = 0; i < joined.size(); ++i) {
            sum += orientation[at(joined[i])];
            for (const Index face : faces[joined[i]])
                for (const Index cell : cells[face]) {
                    if (isSeen[at(cell)]) continue;
                    isSeen[at(cell)] = 1;
                    joined.push_back(cell);
                }
        }
        std::sort(joined.begin(), joined.end());
        for (const Index cell : joined)
            if (first == 0) first = orientation[at(cell)];
        const std::int8_t usual = sum > 0 ? 1 : sum < 0 ? -1 : first;
        for (const Index cell : joined)
            if (orientation[at(cell)] != usual) orientation[at(cell)] = 0;
    }
}

/// A lower bound of the least volume ratio of a cell; its sign is sure.
double leastRatio(const CellComplex& complex, Index cell, int orientation,
                  std::span<const Point3> rest, std::span<const Point3> pose) {
    const CellPieces pieces(complex, cell);
    double least = std::numeric_limits<double>::max();  // where the quotient is beyond it
    for (Index i = 0; i < pieces.count(); ++i) {
        const Piece posed = pieces.piece(i, pose);
        const auto now = determinant(posed.derivatives);
        const auto before = determinant(pieces.piece(i, rest).derivatives);
        const double floor = determinantFloor(posed);
        Triquadratics<2> quotient;
        for (std::size_t k = 0; k < quotient.size(); ++k)
            quotient[k] = {orientation * now[k][0] - floor, orientation * before[k][0]};
        least = std::min(least, leastQuotient(quotient));
    }
    return least;
}

/// A piece at the end of the way that is looked at, beyond the pose perhaps.
///
/// \param end where the vertices are there: rest + most (pose − rest)
Piece pieceAtEnd(const CellPieces& pieces, Index number, const Piece& rest,
                 std::span<const Point3> end, double most) {
    Piece piece = pieces.piece(number, end);
    // That of rest and pose grows by the way: most (|rest| + |pose|), of which the latter is at
    // most |rest| + (|rest| + |end|) / most.
    piece.uncertainty = 2 * (piece.uncertainty + (1 + most) * rest.uncertainty);
    return piece;
}

}  // namespace

ValidityCheck::ValidityCheck(const CellComplex& complex, std::span<const Point3> rest)
    : complex_(checkedLattice(complex)) {
    checkPositions(complex_, rest, "rest");
    rest_.assign(rest.begin(), rest.end());
    orientation_.resize(at(complex_.count(3)));
    far::parallelFor(complex_.count(3), kGrain, [&](Offset first, Offset last) {
        for (auto cell = static_cast<Index>(first); cell < last; ++cell)
            orientation_[at(cell)] = orientationOf(complex_, cell, rest_);
    });
    dropTurned(complex_, orientation_);
    for (Index cell = 0; cell < complex_.count(3); ++cell)
        if (orientation_[at(cell)] == 0) badAtRest_.push_back(cell);
}

PoseValidity ValidityCheck::check(std::span<const Point3> pose) const {
    checkPositions(complex_, pose, "pose");
    PoseValidity result;
    result.ratios.resize(orientation_.size());
    far::parallelFor(complex_.count(3), kGrain, [&](Offset first, Offset last) {
        for (auto cell = static_cast<Index>(first); cell < last; ++cell)
            if (orientation_[at(cell)] != 0)
                result.ratios[at(cell)] =
                    leastRatio(complex_, cell, orientation_[at(cell)], rest_, pose);
    });
    for (Index cell = 0; cell < complex_.count(3); ++cell) {
        const auto& ratio = result.ratios[at(cell)];
        if (!ratio) continue;
        if (!(*ratio > 0)) result.inverted.push_back(cell);
        if (!result.smallest || *ratio < result.smallest->value) result.smallest = {cell, *ratio};
    }
    return result;
}

LargestStep ValidityCheck::largestStep(std::span<const Point3> pose, double most) const {
    constexpr double kMostAsked = 1e6;
    if (!(most > 0 && most <= kMostAsked))
        throw Error("the largest step was asked for up to " + std::to_string(most) +
                    "; expected a number above 0, up to a million");
    checkPositions(complex_, pose, "pose");
    std::vector<Point3> end(rest_);
    for (std::size_t vertex = 0; vertex < end.size(); ++vertex)
        for (std::size_t c = 0; c < 3; ++c)
            end[vertex][c] += most * (pose[vertex][c] - rest_[vertex][c]);
    // In parts of `most`. The digits of a cell's depend on how far the cells before it have brought
    // the step down. So each range has a step of its own: ranges do not depend on the threads.
    std::vector<LargestStep> ofRanges(
        static_cast<std::size_t>((complex_.count(3) + kGrain - 1) / kGrain), {1, {}, true});
    far::parallelFor(complex_.count(3), kGrain, [&](Offset first, Offset last) {
        LargestStep& step = ofRanges[static_cast<std::size_t>(first / kGrain)];
        for (auto cell = static_cast<Index>(first); cell < last; ++cell) {
            if (orientation_[at(cell)] == 0) continue;
            const CellPieces pieces(complex_, cell);
            for (Index i = 0; i < pieces.count() && step.length > 0; ++i) {
                const Piece before = pieces.piece(i, rest_);
                const Piece after = pieceAtEnd(pieces, i, before, end, most);
                const ProvedTime proved = positiveUpTo(
                    aboveFloor(determinant(before.derivatives, after.derivatives),
                               orientation_[at(cell)], determinantFloor(before, after)),
                    step.length);
                if (proved.time < step.length) step = {proved.time, cell, proved.isTight};
            }
        }
    });
    LargestStep result{1, {}, true};
    for (const LargestStep& step : ofRanges)
        if (step.length < result.length) result = step;
    result.length *= most;
    return result;
}

Index baseCellOf(const far::TopologyRefiner& refiner, int level, Index cell) {
    for (; level > 0; --level) cell = refiner.refinement(level).parentOf({3, cell}).upper.index;
    return cell;
}

}  // namespace espalier::solve
