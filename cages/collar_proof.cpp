// SPDX-License-Identifier: Apache-2.0
#include "collar_proof.h"

#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/embed/box_tree.h>
#include <espalier/embed/cell_solver.h>
#include <espalier/embed/length_unit.h>
#include <espalier/limit/limit_parts.h>
#include <espalier/shapes/refiner_options.h>
#include <espalier/solve/validity.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace espalier::cages {
namespace {

/// Level to which limit::LimitParts refines irregular features for the proof.
constexpr int kLevelOfParts = 2;

/// Distance within which a vertex beside a cell is in it, as a fraction of the lattice: rounding.
constexpr double kTolerance = 1e-9;

/// Returns the cells of a lattice that are bad after one refinement or in the limit, ascending.
std::vector<Index> badCells(const far::TopologyRefiner& base, std::span<const Point3> positions) {
    std::vector<Index> bad = solve::cellsBadAtRest(base, positions);
    const limit::LimitParts parts(base, kLevelOfParts);
    const solve::ValidityCheck check(parts, positions);
    bad.insert(bad.end(), check.badAtRest().begin(), check.badAtRest().end());
    sortUnique(bad);
    return bad;
}

/// Tells for each vertex of a complex whether it is in a boundary face.
std::vector<char> boundaryVertices(const far::CellComplex& complex) {
    std::vector<char> isOnBoundary(std::size_t(complex.count(0)), 0);
    for (Index face = 0; face < complex.count(2); ++face)
        if (complex.relation(2, 3)[face].size() == 1)
            for (const Index vertex : complex.relation(2, 0)[face]) isOnBoundary[vertex] = 1;
    return isOnBoundary;
}

/// Returns the base cells with a boundary vertex of level 1 that is in another cell, and the base
/// cells of these other cells. Two cells of the lattice without the collar do not count.
std::vector<Index> overlappingCells(far::TopologyRefiner base, const Lattice& lattice,
                                    Index firstNewCell) {
    base.refineUniform(1);
    const far::CellComplex& complex = base.level(1).complex;
    const auto refined = stencils::refinePositions(base, 1, lattice.positions);
    const embed::LengthUnit unit(refined);
    const auto positions = unit.toUnits(refined);
    const embed::CellSolver solver(complex, positions,
                                   embed::CellSolver::scaleOf(positions, kTolerance));
    std::vector<embed::BoxTree::Box> boxes;
    for (Index cell = 0; cell < complex.count(3); ++cell)
        boxes.push_back(solver.boxOf(CellId(cell)));
    const embed::BoxTree tree(boxes);
    const auto isOnBoundary = boundaryVertices(complex);
    const auto isNew = [&](Index cell) { return solve::baseCellOf(base, 1, cell) >= firstNewCell; };
    std::vector<Index> cells, others;
    for (Index vertex = 0; vertex < complex.count(0); ++vertex) {
        if (!isOnBoundary[vertex]) continue;
        checkCancelledEvery(std::size_t(vertex), 10);
        const Eigen::Vector3d point(positions[vertex].data());
        const auto own = complex.relation(0, 3)[vertex];
        const bool isOfCollar = std::ranges::any_of(own, isNew);
        others.clear();
        tree.findContaining(point, others);
        std::erase_if(others, [&](Index cell) {
            return std::ranges::find(own, cell) != own.end() || !(isOfCollar || isNew(cell));
        });
        std::ranges::sort(others);
        const auto found = solver.locateIn(point, others);
        if (!found || !found->place) continue;
        cells.push_back(solve::baseCellOf(base, 1, own[0]));
        cells.push_back(solve::baseCellOf(base, 1, found->place->cell.value));
    }
    return cells;
}

}  // namespace

CollarProof::CollarProof(const Lattice& before)
    : before_(before), wasBad_(std::size_t(before.complex.count(3)), 0) {
    const far::TopologyRefiner base(before.complex, refinerOptions(before));
    for (const Index cell : badCells(base, before.positions)) wasBad_[cell] = 1;
}

Index CollarProof::Failure::mostFrequent() const {
    std::vector<Index> ascending = vertices;
    std::ranges::sort(ascending);
    Index result = ascending.front();
    std::ptrdiff_t most = 0;
    for (auto it = ascending.begin(); it != ascending.end();) {
        const auto next = std::upper_bound(it, ascending.end(), *it);
        if (next - it > most) {
            most = next - it;
            result = *it;
        }
        it = next;
    }
    return result;
}

const char* CollarProof::Failure::text() const {
    switch (kind) {
        case FailureKind::Fold:
            return "fold";
        case FailureKind::FoldInLimit:
            return "fold in the limit";
        case FailureKind::Overlap:
            return "overlap";
        case FailureKind::TooThick:
            return "be thicker than twice the reach";
    }
    return "";
}

std::optional<CollarProof::Failure> CollarProof::failure(const Lattice& lattice,
                                                         const CollarCells& cells) const {
    const far::TopologyRefiner base(lattice.complex, refinerOptions(lattice));
    const Index count = before_.complex.count(0);
    const auto fails = [&](std::span<const Index> bad, FailureKind kind) {
        Failure failure{kind};
        for (const Index cell : bad)
            if (cell >= std::ssize(wasBad_) || !wasBad_[cell]) {
                failure.cells.push_back(cell);
                for (const Index vertex : lattice.complex.relation(3, 0)[cell])
                    failure.vertices.push_back(overOf(cells, count, vertex));
            }
        return failure.vertices.empty() ? std::nullopt : std::optional(std::move(failure));
    };
    if (auto failure = fails(solve::cellsBadAtRest(base, lattice.positions), FailureKind::Fold))
        return failure;
    const limit::LimitParts parts(base, kLevelOfParts);
    const solve::ValidityCheck check(parts, lattice.positions);
    if (auto failure = fails(check.badAtRest(), FailureKind::FoldInLimit)) return failure;
    return fails(overlappingCells(base, lattice, before_.complex.count(3)), FailureKind::Overlap);
}

}  // namespace espalier::cages
