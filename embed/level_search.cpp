// SPDX-License-Identifier: Apache-2.0
#include "level_search.h"

#include <espalier/base/progress.h>
#include <espalier/embed/place_points.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace espalier::embed {

using Eigen::Vector3d;

namespace {

LocatedPart partOf(std::size_t pointCount) {
    LocatedPart part;
    part.points.resize(pointCount);
    std::iota(part.points.begin(), part.points.end(), Index{0});
    return part;
}

}  // namespace

LevelSearch::LevelSearch(const RestLattice& lattice, int level, const EmbeddingOptions& options)
    : level_(level),
      seekNearest_(options.outside == OutsidePolicy::Nearest),
      scale_(CellSolver::scaleOf(lattice.positions, options.tolerance)),
      vertex_(lattice.positions.front()),
      descent_(lattice, scale_) {}

void LevelSearch::locate(std::span<const Point3> points, Extent extent,
                         FunctionRef<void(LocatedPart)> use) const {
    std::vector<Index> unsettled;
    descent_.descend(points, level_, SoughtCells::Containing, extent,
                     [&](Offset first, auto part, auto& found) {
                         std::vector<Index> left;
                         LocatedPart located = locateInside(part, found, left);
                         for (Index& point : located.points) point += static_cast<Index>(first);
                         for (const Index point : left)
                             unsettled.push_back(point + static_cast<Index>(first));
                         use(std::move(located));
                     });
    if (unsettled.empty()) return;
    // Extent::Ring also refines the neighbours of a cell: they tell which faces of the cell are on
    // the boundary.
    descent_.descend(chosenPoints(points, unsettled), level_, SoughtCells::Nearest, Extent::Ring,
                     [&](Offset first, auto part, auto& found) {
                         LocatedPart located = locateOutsideCells(part, *found);
                         for (Index& point : located.points) point = unsettled[first + point];
                         use(std::move(located));
                     });
}

/// Locates the points that are in a cell. Returns in `unsettled` the points that may be in a gap
/// between cells, and the points outside that the nearest cell should carry.
/// \param found the descent of the points
LocatedPart LevelSearch::locateInside(std::span<const Point3> points, std::optional<Descent>& found,
                                      std::vector<Index>& unsettled) const {
    LocatedPart part = partOf(points.size());
    std::optional<CellSolver> solver;
    CellsOfPoints cells;
    if (found) {
        const far::CellComplex& complex = found->levels.finestLevel().complex;
        part.embedding.vertexCount = complex.count(0);
        solver.emplace(complex, found->levels.finestPositions(), scale_);
        cells = found->candidates.cellsOfPoints(points.size(), [&](Index cell, Index point) {
            return solver->boxOf(CellId(cell)).contains(Vector3d(points[point].data()));
        });
    }
    for (const Index i : part.points) {
        checkCancelledEvery(part.embedding.points.size(), 4);
        const Vector3d point(points[i].data());
        const auto near = found ? cells.of(i) : std::span<const Index>();
        auto located = CellSolver::resultIfUnreachable(point, vertex_, scale_.size);
        if (!located && found) located = solver->locateIn(point, near);
        // A gap is inside the boxes of the cells beside it, so a point in no box is outside.
        if (!located && (seekNearest_ || !near.empty())) unsettled.push_back(i);
        part.embedding.points.push_back(
            located.value_or(LocatedPoint{PointStatus::Outside, {}, 0, 0}));
    }
    if (found) {
        part.levels = std::move(found->levels);
        part.baseVertices = std::move(found->baseVertices);
    }
    return part;
}

/// Locates points that are in no cell, by the nearest cell. The candidates of a point include all
/// cells whose boxes contain the point (SoughtCells::Nearest).
LocatedPart LevelSearch::locateOutsideCells(std::span<const Point3> points, Descent& found) const {
    LocatedPart part = partOf(points.size());
    const far::CellComplex& complex = found.levels.finestLevel().complex;
    part.embedding.vertexCount = complex.count(0);
    const CellSolver solver(complex, found.levels.finestPositions(), scale_);
    const auto cells =
        found.candidates.cellsOfPoints(points.size(), [](Index, Index) { return true; });
    for (const Index i : part.points) {
        checkCancelledEvery(part.embedding.points.size(), 4);
        const Vector3d point(points[i].data());
        std::pair nearest(std::numeric_limits<double>::infinity(), kMaxIndex);
        for (const Index cell : cells.of(i))
            nearest = std::min(nearest, {solver.distance(point, CellId(cell)), cell});
        const CellId cell(nearest.second);
        // As in locateInside(), a point in no box is outside.
        const bool mayBeInGap = std::ranges::any_of(
            cells.of(i), [&](Index near) { return solver.boxOf(CellId(near)).contains(point); });
        LocatedPoint located{PointStatus::Outside, {}, nearest.first, 0};
        if (mayBeInGap) located = solver.locateInGap(point, cell);
        if (located.status == PointStatus::Outside && seekNearest_)
            located = solver.carry(point, cell);
        part.embedding.points.push_back(located);
    }
    part.levels = std::move(found.levels);
    part.baseVertices = std::move(found.baseVertices);
    return part;
}

}  // namespace espalier::embed
