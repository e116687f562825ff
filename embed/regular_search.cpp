// SPDX-License-Identifier: Apache-2.0
#include <espalier/embed/cell_solver.h>
#include <espalier/embed/patch_solver.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/regular_search.h>

#include <algorithm>
#include <optional>
#include <unordered_map>

namespace espalier::embed {

using Eigen::Vector3d;

namespace {

std::vector<Index> regularCells(const PointDescent& descent) {
    const auto bounds = descent.baseBounds();
    std::vector<Index> cells;
    for (std::size_t cell = 0; cell < bounds.size(); ++cell)
        if (bounds[cell] && bounds[cell]->drift) cells.push_back(static_cast<Index>(cell));
    return cells;
}

std::vector<BoxTree::Box> boxesOf(const PointDescent& descent, std::span<const Index> cells) {
    std::vector<BoxTree::Box> boxes;
    boxes.reserve(cells.size());
    for (const Index cell : cells) {
        boxes.push_back(descent.baseBounds()[cell]->box);
        boxes.back().min().array() -= descent.rounding();
        boxes.back().max().array() += descent.rounding();
    }
    return boxes;
}

}  // namespace

RegularSearch::RegularSearch(const RestLattice& lattice, const PointDescent& descent,
                             double spacing)
    : lattice_(lattice),
      spacing_(spacing),
      size_(CellSolver::scaleOf(lattice.positions, 0).size),
      cells_(regularCells(descent)),
      tree_(boxesOf(descent, cells_)) {}

RegularPlaces RegularSearch::locate(std::span<const Point3> points) const {
    // How far u, v and w may be outside 0 to 1: their rounding. Points farther outside are left to
    // the other search.
    constexpr double kPlaceRounding = 1e-14;
    // Largest residual, as a fraction of coordinates: their rounding. Newton's last step, of up to
    // 1e-9, may start on the other side of a face between cells of the level, where the slopes
    // differ. Then the residual is larger, and the point is left to the other search.
    constexpr double kPointRounding = 2e-15;
    struct Cell {
        TricubicPatch patch;
        std::optional<PatchSolver> solver = {};  ///< nothing if the cell is left to other searches
        Index number = kMaxIndex;  ///< the number in RegularPlaces::patches; kMaxIndex: none yet
    };
    const far::Level& base = lattice_.base.level(0);
    const auto make = [&](Index cell) {
        Cell made{TricubicPatch(base, *frameOf(base.complex, cell))};
        if (made.patch.hasRepeatedVertex()) return made;
        made.solver.emplace(made.patch.controlPoints(lattice_.positions), spacing_);
        if (!made.solver->isOneToOne()) made.solver.reset();
        return made;
    };

    RegularPlaces result;
    result.places.resize(points.size());
    std::unordered_map<Index, Cell> cells;
    tree_.findContaining(points, [&](std::size_t p, std::span<const Index> found) {
        const Vector3d point(points[p].data());
        for (const Index i : found) {
            auto known = cells.find(i);
            if (known == cells.end()) known = cells.emplace(i, make(cells_[i])).first;
            auto& [patch, solver, number] = known->second;
            if (!solver) continue;
            const auto [answer, uvw] = solver->find(point);
            if (answer != PatchSolver::Answer::Inside || !isInUnitCube(uvw, kPlaceRounding))
                continue;
            const double residual = solver->distance(uvw, point);
            if (!(residual <= kPointRounding * std::max(size_, point.norm()))) continue;
            if (number == kMaxIndex) {
                number = static_cast<Index>(result.patches.size());
                result.patches.push_back(patch);
            }
            result.places[p] = {toArray(uvw), number,
                                TricubicPatch::rowLength(patch.axisWeights(uvw, spacing_))};
            result.largestResidual = std::max(result.largestResidual, residual);
            break;
        }
    });
    return result;
}

}  // namespace espalier::embed
