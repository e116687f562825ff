// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/point_location.h>

#include <algorithm>
#include <vector>

namespace espalier::embed {

using Eigen::Vector3d;

namespace {

Array<BoxTree::Box> cellBoxes(const CellSolver& solver, Index cellCount) {
    Array<BoxTree::Box> boxes(cellCount);
    parallelFor(cellCount, 4096, [&](Offset first, Offset last) {
        for (Offset cell = first; cell < last; ++cell)
            boxes[cell] = solver.boxOf(CellId(static_cast<Index>(cell)));
    });
    return boxes;
}

}  // namespace

PointLocator::PointLocator(const far::CellComplex& complex, std::span<const Point3> positions,
                           double tolerance)
    : PointLocator(complex, positions, CellSolver::scaleOf(positions, tolerance)) {}

PointLocator::PointLocator(const far::CellComplex& complex, std::span<const Point3> positions,
                           CellSolver::Scale scale)
    : unit_(positions),
      solver_(complex, unit_.toUnits(positions),
              {unit_.toUnits(scale.size), unit_.toUnits(scale.tolerance)}),
      tree_(cellBoxes(solver_, complex.count(3))),
      vertex_(unit_.toUnits(positions.front())),
      size_(unit_.toUnits(scale.size)) {}

LocatedPoint PointLocator::locate(const Point3& position, bool seekNearest) const {
    LocatedPoint located = locateInUnits(unit_.toUnits(position), seekNearest);
    located.distance = unit_.fromUnits(located.distance);
    located.residual = unit_.fromUnits(located.residual);
    located.away = unit_.fromUnits(located.away);
    return located;
}

LocatedPoint PointLocator::locateInUnits(const Point3& position, bool seekNearest) const {
    const Vector3d point(position.data());
    if (const auto unreachable = CellSolver::resultIfUnreachable(point, vertex_, size_))
        return *unreachable;

    std::vector<Index> candidates;
    tree_.findContaining(point, candidates);
    std::sort(candidates.begin(), candidates.end());
    if (const auto found = solver_.locateIn(point, candidates)) return *found;
    // A gap is in the convex hull of the face beside it, and so in the boxes of the cells at the
    // face: a point in no box is outside.
    LocatedPoint located{PointStatus::Outside, {}, 0, 0};
    if (candidates.empty() && !seekNearest) return located;
    const CellId nearest(
        tree_.findNearest(point, [&](Index cell) { return solver_.distance(point, CellId(cell)); })
            .index);
    if (!candidates.empty()) located = solver_.locateInGap(point, nearest);
    if (located.status == PointStatus::Outside && seekNearest)
        located = solver_.carry(point, nearest);
    return located;
}

}  // namespace espalier::embed
