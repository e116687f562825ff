// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/embed/length_unit.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "bernstein.h"
#include "validity_pieces.h"

namespace espalier::solve {
namespace {

using far::CellComplex;
using limit::LimitPositions;

/// \param name name of the positions in messages
void checkPositions(Index vertexCount, std::span<const Point3> positions, const char* name) {
    constexpr double kMaxCoordinate = 1e90;
    if (std::ssize(positions) != vertexCount)
        throw Error(concat("got ", positions.size(), " positions of the ", name, " for ",
                           vertexCount, " vertices"));
    for (std::size_t vertex = 0; vertex < positions.size(); ++vertex)
        for (const double coordinate : positions[vertex])
            if (!(std::abs(coordinate) <= kMaxCoordinate))
                throw Error(concat(
                    "the ", name, " of vertex ", vertex,
                    std::isfinite(coordinate) ? " is too far from the origin" : " is not finite"));
}

/// Subtracts the floor from a determinant, whose sign is changed so that it is positive at rest.
template <std::size_t Degree, std::size_t Lanes>
Trivariate<Degree, Lanes> aboveFloor(Trivariate<Degree, Lanes> determinant, int orientation,
                                     const std::array<double, Lanes>& floor) {
    for (auto& lanes : determinant)
        for (std::size_t lane = 0; lane < Lanes; ++lane)
            lanes[lane] = orientation * lanes[lane] - floor[lane];
    return determinant;
}

/// Returns true if all coefficients of a determinant, whose sign is changed so that it is positive
/// at rest, are above a floor. Most are, and need no further proof.
template <std::size_t Degree, std::size_t Lanes>
bool isAbove(const Trivariate<Degree, Lanes>& determinant, int orientation, double floor) {
    bool areAbove = true;
    for (const auto& lanes : determinant)
        for (const double value : lanes) areAbove &= orientation * value > floor;
    return areAbove;
}

/// Returns the sign of the determinant in a part; 0 if it is not the same everywhere.
std::int8_t orientationOf(const CheckedVolume& volume, Index part, const LimitPositions& rest) {
    std::optional<std::int8_t> common;
    volume.forEachPiece(
        part,
        [&](const auto& piece) {
            if (common == 0) return;
            const auto polynomial = determinant(piece.derivatives);
            const std::int8_t sign = polynomial[0][0] > 0 ? 1 : -1;
            if (common.value_or(sign) != sign ||
                !isPositive(aboveFloor(polynomial, sign, {determinantFloor(piece.size)})))
                common = 0;
            else
                common = sign;
        },
        rest);
    return common.value_or(0);
}

/// Combines the orientations of the parts of a cell: 0 unless all agree.
void join(std::vector<std::optional<std::int8_t>>& ofCells, Index cell, std::int8_t ofPart) {
    auto& common = ofCells[cell];
    common = common.value_or(ofPart) == ofPart ? ofPart : 0;
}

/// Sets the orientation to 0 for cells that are oriented against most cells of their group. If both
/// orientations are equally frequent, the lowest-numbered cell that has one decides.
void clearMinorityOrientations(const std::vector<Index>& groups,
                               std::vector<std::int8_t>& orientation) {
    struct Group {
        Index sum = 0;
        std::int8_t first = 0;
    };
    std::vector<Group> ofGroups;
    for (std::size_t cell = 0; cell < groups.size(); ++cell) {
        const std::size_t number = groups[cell];
        if (number >= ofGroups.size()) ofGroups.resize(number + 1);
        Group& group = ofGroups[number];
        group.sum += orientation[cell];
        if (group.first == 0) group.first = orientation[cell];
    }
    for (std::size_t cell = 0; cell < groups.size(); ++cell) {
        const Group& group = ofGroups[groups[cell]];
        const std::int8_t usual = group.sum > 0 ? 1 : group.sum < 0 ? -1 : group.first;
        if (orientation[cell] != usual) orientation[cell] = 0;
    }
}

/// Returns a lower bound of the smallest volume ratio of a part, up to one rounding; its sign is
/// certain.
double leastRatio(const CheckedVolume& volume, Index part, int orientation,
                  const LimitPositions& rest, const LimitPositions& pose) {
    constexpr double kLargest = std::numeric_limits<double>::max();
    double least = kLargest;
    volume.forEachPiece(
        part,
        [&]<std::size_t Degree>(const Piece<Degree>& before, const Piece<Degree>& posed) {
            const auto upper = aboveFloor(determinant(posed.derivatives), orientation,
                                          {determinantFloor(posed.size)});
            const auto lower = determinant(before.derivatives);
            Trivariate<kDeterminantDegree<Degree>, 2> quotient;
            for (std::size_t k = 0; k < quotient.size(); ++k)
                quotient[k] = {upper[k][0], orientation * lower[k][0]};
            least = std::min(least, leastQuotient(quotient));
        },
        rest, pose);
    return std::max(least, -kLargest);
}

/// Returns the size of a piece at the end of the way, which may be beyond the pose.
///
/// \param end size at rest + maxStep (pose − rest)
PieceSize sizeAtEnd(PieceSize end, const PieceSize& rest, double maxStep) {
    // The uncertainty includes the uncertainties of rest and pose, multiplied by the length of the
    // way: maxStep (|rest| + |pose|), where |pose| is at most |rest| + (|rest| + |end|) /
    // maxStep.
    end.uncertainty = 2 * (end.uncertainty + (1 + maxStep) * rest.uncertainty);
    return end;
}

/// Shortens a step to the length for which a part is proved valid.
void shorten(LargestStep& step, const CheckedVolume& volume, Index part, int orientation,
             const LimitPositions& rest, const LimitPositions& end, double maxStep) {
    volume.forEachPiece(
        part,
        [&](const auto& before, const auto& after) {
            if (!(step.length > 0)) return;
            const auto polynomial = determinant(before.derivatives, after.derivatives);
            const PieceSize atEnd = sizeAtEnd(after.size, before.size, maxStep);
            if (isAbove(polynomial, orientation, largestFloor(before.size, atEnd))) return;
            const ProvedTime proved = positiveUpTo(
                aboveFloor(polynomial, orientation, determinantFloor(before.size, atEnd)),
                step.length);
            if (proved.time < step.length)
                step = {proved.time, volume.cellOf(part), proved.isTight};
        },
        rest, end);
}

/// Calls visit(range, part) for all parts, with ranges of parts in parallel. The ranges do not
/// depend on the number of threads.
template <class Visit>
void forEachPart(const CheckedVolume& volume, Visit visit) {
    const Offset grain = volume.grain();
    parallelFor(volume.partCount(), grain, [&](Offset first, Offset last) {
        for (auto part = static_cast<Index>(first); part < last; ++part) {
            checkCancelledEvery(part, 4);
            visit(first / grain, part);
        }
    });
}

}  // namespace

ValidityCheck::ValidityCheck(const CellComplex& complex, std::span<const Point3> rest)
    : ValidityCheck(CheckedVolume(complex), rest) {}

ValidityCheck::ValidityCheck(const limit::LimitParts& limit, std::span<const Point3> rest)
    : ValidityCheck(CheckedVolume(limit), rest) {}

ValidityCheck::ValidityCheck(const far::VolumeMesh& mesh, std::span<const Point3> rest)
    : ValidityCheck(
          [&] {
              checkPositions(mesh.pointCount(), rest, "rest");
              return CheckedVolume(mesh, rest);
          }(),
          rest) {}

ValidityCheck::ValidityCheck(const far::SurfaceMesh& mesh, std::span<const Point3> rest)
    : ValidityCheck(
          [&] {
              checkPositions(mesh.pointCount(), rest, "rest");
              return CheckedVolume(mesh, rest);
          }(),
          rest) {}

ValidityCheck::ValidityCheck(CheckedVolume checked, std::span<const Point3> rest)
    : volume_(std::make_shared<const CheckedVolume>(std::move(checked))) {
    const CheckedVolume& volume = *volume_;
    checkPositions(volume.vertexCount(), rest, "rest");
    rest_ = volume.place(rest);
    std::vector<std::int8_t> ofParts(volume.partCount());
    forEachPart(volume, [&](std::size_t, Index part) {
        ofParts[part] = orientationOf(volume, part, rest_);
    });
    std::vector<std::optional<std::int8_t>> ofCells(volume.cellCount());
    for (Index part = 0; part < volume.partCount(); ++part)
        join(ofCells, volume.cellOf(part), ofParts[part]);
    for (const auto& orientation : ofCells) orientation_.push_back(orientation.value_or(0));
    clearMinorityOrientations(volume.orientationGroups(), orientation_);
    for (Index cell = 0; cell < volume.cellCount(); ++cell)
        if (ofCells[cell] && orientation_[cell] == 0) badAtRest_.push_back(cell);
}

PoseValidity ValidityCheck::check(std::span<const Point3> pose) const {
    const CheckedVolume& volume = *volume_;
    checkPositions(volume.vertexCount(), pose, "pose");
    const LimitPositions posed = volume.place(pose);
    std::vector<double> ofParts(volume.partCount());
    forEachPart(volume, [&](std::size_t, Index part) {
        const int orientation = orientation_[volume.cellOf(part)];
        if (orientation != 0) ofParts[part] = leastRatio(volume, part, orientation, rest_, posed);
    });
    PoseValidity result;
    result.comparesNeighbours = volume.usesNeighbours(pose);
    result.ratios.resize(orientation_.size());
    for (Index part = 0; part < volume.partCount(); ++part) {
        const Index cell = volume.cellOf(part);
        if (orientation_[cell] == 0) continue;
        auto& ratio = result.ratios[cell];
        ratio = std::min(ratio.value_or(ofParts[part]), ofParts[part]);
    }
    for (Index cell = 0; cell < volume.cellCount(); ++cell) {
        const auto& ratio = result.ratios[cell];
        if (!ratio) continue;
        if (!(*ratio > 0)) result.inverted.push_back(cell);
        if (!result.smallest || *ratio < result.smallest->value) result.smallest = {cell, *ratio};
    }
    return result;
}

LargestStep ValidityCheck::largestStep(std::span<const Point3> pose, double maxStep) const {
    constexpr double kMaxAsked = 1e6;
    if (!(maxStep > 0 && maxStep <= kMaxAsked))
        throw ArgumentError("", "maxStep", textOf(maxStep), "a number above 0, up to a million");
    const CheckedVolume& volume = *volume_;
    checkPositions(volume.vertexCount(), pose, "pose");
    const auto& rest = rest_.levels.empty() ? rest_.limits : rest_.levels.front();
    // The centres or normals of a mesh, which follow the vertices, are left out.
    std::vector<Point3> ends(rest.begin(), rest.begin() + volume.vertexCount());
    for (std::size_t vertex = 0; vertex < ends.size(); ++vertex)
        for (std::size_t c = 0; c < 3; ++c)
            ends[vertex][c] += maxStep * (pose[vertex][c] - ends[vertex][c]);
    if (volume.usesNeighbours(ends)) return stepByHalving(ends, maxStep);
    const LimitPositions end = volume.place(ends);
    // Each range of parts has its own step, because the last digits of a result depend on how far
    // earlier parts have shortened the step. Lengths are fractions of `maxStep` here.
    std::vector<LargestStep> ofRanges((volume.partCount() + volume.grain() - 1) / volume.grain(),
                                      {1, {}, true});
    forEachPart(volume, [&](std::size_t range, Index part) {
        const int orientation = orientation_[volume.cellOf(part)];
        if (orientation != 0)
            shorten(ofRanges[range], volume, part, orientation, rest_, end, maxStep);
    });
    LargestStep result{1, {}, true};
    for (const LargestStep& step : ofRanges)
        if (step.length < result.length) result = step;
    result.length *= maxStep;
    return result;
}

Index ValidityCheck::isolatedFaces() const {
    return volume_->isolatedFaces();
}

LargestStep ValidityCheck::stepByHalving(std::span<const Point3> end, double maxStep) const {
    const auto firstInverted = [&](double share) -> std::optional<Index> {
        std::vector<Point3> points = rest_.limits;
        points.resize(end.size());
        for (std::size_t point = 0; point < points.size(); ++point)
            for (std::size_t c = 0; c < 3; ++c)
                points[point][c] += share * (end[point][c] - points[point][c]);
        const auto inverted = check(points).inverted;
        return inverted.empty() ? std::nullopt : std::optional(inverted.front());
    };
    constexpr int kHalvings = 20;  // a millionth
    double valid = 0, refused = 1;
    auto limiting = firstInverted(1);
    if (!limiting) return {maxStep, {}, false};
    for (int halving = 0; halving < kHalvings; ++halving) {
        const double middle = (valid + refused) / 2;
        if (const auto inverted = firstInverted(middle)) {
            refused = middle;
            limiting = inverted;
        } else {
            valid = middle;
        }
    }
    return {valid * maxStep, limiting, false};
}

std::vector<Index> cellsBadAtRest(const far::TopologyRefiner& base, std::span<const Point3> rest) {
    // Without boundary control, refinement may leave no cell, and so no bad one.
    const far::Level& level0 = base.level(0);
    bool isLeft = false;
    for (Index vertex = 0; vertex < level0.complex.count(0); ++vertex)
        isLeft = isLeft || !level0.strata.isOpen({0, vertex});
    if (!isLeft) return {};
    far::TopologyRefiner refiner(base);
    refiner.refineUniform(1);
    // In units of the lattice: cubes of very large coordinates would overflow.
    const std::vector<Point3> inUnits = embed::LengthUnit(rest).toUnits(rest);
    const ValidityCheck check(refiner.level(1).complex,
                              stencils::refinePositions(refiner, 1, inUnits));
    std::vector<Index> cells;
    for (const Index cell : check.badAtRest()) cells.push_back(baseCellOf(refiner, 1, cell));
    sortUnique(cells);
    return cells;
}

Index baseCellOf(const far::TopologyRefiner& refiner, int level, Index cell) {
    for (; level > 0; --level) cell = refiner.refinement(level).parentOf({3, cell}).upper.index;
    return cell;
}

}  // namespace espalier::solve
