// SPDX-License-Identifier: Apache-2.0
#include "point_descent.h"

#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace espalier::stencils {

using Eigen::Vector3d;
using Bound = std::optional<CellBound>;
using Extent = far::TopologyRefiner::Extent;

namespace {

Vector3d at(std::span<const Point3> positions, Index index) {
    return Vector3d(positions[static_cast<std::size_t>(index)].data());
}

/// The boxes of a level may miss those of the last one by the rounding of the sums between, which
/// is relative to where the lattice lies: some 100 times 1e-16 a level.
constexpr double kSlack = 1e-12;

double largestCoordinate(std::span<const Point3> positions) {
    double largest = 0;
    for (const Point3& position : positions)
        for (const double coordinate : position) largest = std::max(largest, std::abs(coordinate));
    return largest;
}

/// The cells that have a bound, or those that have none.
std::vector<Index> cellsWith(const std::vector<Bound>& bounds, bool bound) {
    std::vector<Index> cells;
    for (std::size_t cell = 0; cell < bounds.size(); ++cell)
        if (bounds[cell].has_value() == bound) cells.push_back(static_cast<Index>(cell));
    return cells;
}

std::vector<BoxTree::Box> boxesOf(const std::vector<Bound>& bounds, const std::vector<Index>& cells,
                                  double margin) {
    std::vector<BoxTree::Box> boxes;
    for (const Index cell : cells) {
        boxes.push_back(bounds[static_cast<std::size_t>(cell)]->box);
        boxes.back().min().array() -= margin;
        boxes.back().max().array() += margin;
    }
    return boxes;
}

/// A distance from a point within which there is something that the cell becomes.
double reach(const far::CellComplex& complex, std::span<const Point3> positions, Index cell,
             const Bound& bound, const Vector3d& point) {
    if (!bound) return std::numeric_limits<double>::infinity();
    if (!bound->drift) {
        // The far corner of the box.
        const Vector3d low = (point - bound->box.min()).cwiseAbs();
        return low.cwiseMax((bound->box.max() - point).cwiseAbs()).norm();
    }
    double nearest = std::numeric_limits<double>::infinity();
    for (const Index vertex : complex.relation(3, 0)[cell])
        nearest = std::min(nearest, (at(positions, vertex) - point).norm());
    return nearest + bound->drift->norm();
}

/// Whether a cell becomes anything: without boundary control, a vertex must be left.
bool isLeft(const far::Level& level, Index cell) {
    const auto vertices = level.complex.relation(3, 0)[cell];
    return std::any_of(vertices.begin(), vertices.end(), [&](Index vertex) {
        return !level.strata.isOpen({0, vertex});
    });
}

}  // namespace

/// Cells of a level, each with its bound and the points that it may become a sought cell of.
struct PointDescent::Candidates {
    std::vector<Index> cells;
    std::vector<Bound> bounds;
    std::vector<Offset> offsets = {0};
    std::vector<Index> points;

    std::span<const Index> pointsOf(std::size_t i) const {
        return std::span(points).subspan(static_cast<std::size_t>(offsets[i]),
                                         static_cast<std::size_t>(offsets[i + 1] - offsets[i]));
    }

    /// Ends the cell whose points were appended last; without any it is left out.
    void endCell(Index cell, const Bound& bound) {
        if (static_cast<Offset>(points.size()) == offsets.back()) return;
        cells.push_back(cell);
        bounds.push_back(bound);
        offsets.push_back(static_cast<Offset>(points.size()));
    }

    /// Leaves the pairs of which keep(i, point) is true, with i the position of the cell.
    template <class Keep>
    void filter(Keep keep) {
        Candidates kept;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            for (const Index point : pointsOf(i))
                if (keep(i, point)) kept.points.push_back(point);
            kept.endCell(cells[i], bounds[i]);
        }
        *this = std::move(kept);
    }
};

namespace {

/// Leaves the cells that may become the nearest one of a point, or one that it is in.
template <class Candidates>
void keepNearest(const far::CellComplex& complex, std::span<const Point3> positions,
                 std::span<const Point3> points, double margin, Candidates& candidates) {
    std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < candidates.cells.size(); ++i)
        for (const Index point : candidates.pointsOf(i)) {
            double& best = nearest[static_cast<std::size_t>(point)];
            best = std::min(best, reach(complex, positions, candidates.cells[i],
                                        candidates.bounds[i], at(points, point)));
        }
    candidates.filter([&](std::size_t i, Index point) {
        const Bound& bound = candidates.bounds[i];
        // Written so that what is not a number stays.
        return !bound || !(bound->box.exteriorDistance(at(points, point)) >
                           nearest[static_cast<std::size_t>(point)] + margin);
    });
}

}  // namespace

PointDescent::PointDescent(const far::TopologyRefiner& base, std::span<const Point3> positions,
                           Rules rules, CellSolver::Scale scale)
    : base_(base),
      positions_(positions),
      rules_(rules),
      margin_(scale.tolerance + kSlack * (scale.size + largestCoordinate(positions))),
      bounds_([&] {
          const CellBounds bounds(base.level(0), positions, base.options().creasing);
          std::vector<Bound> result;
          for (Index cell = 0; cell < base.level(0).complex.count(3); ++cell)
              result.push_back(bounds.boundOf(cell, std::nullopt));
          return result;
      }()),
      bounded_(cellsWith(bounds_, true)),
      unbounded_(cellsWith(bounds_, false)),
      tree_(boxesOf(bounds_, bounded_, margin_)) {}

PointDescent::Candidates PointDescent::baseCandidates(std::span<const Point3> points,
                                                      Sought sought) const {
    std::vector<std::vector<Index>> pointsOf(bounds_.size());
    std::vector<Index> found;
    for (std::size_t point = 0; point < points.size(); ++point) {
        const auto add = [&](Index cell) {
            pointsOf[static_cast<std::size_t>(cell)].push_back(static_cast<Index>(point));
        };
        for (const Index cell : unbounded_) add(cell);
        found.clear();
        const Vector3d position(points[point].data());
        if (sought == Sought::Containing) {
            tree_.findContaining(position, found);
        } else {
            const auto reachOf = [&](Index i) {
                const Index cell = bounded_[static_cast<std::size_t>(i)];
                if (!isLeft(base_.level(0), cell)) return std::numeric_limits<double>::infinity();
                return reach(base_.level(0).complex, positions_, cell,
                             bounds_[static_cast<std::size_t>(cell)], position);
            };
            tree_.findWithin(position, tree_.findNearest(position, reachOf).distance + margin_,
                             found);
        }
        for (const Index i : found) add(bounded_[static_cast<std::size_t>(i)]);
    }
    Candidates candidates;
    for (std::size_t cell = 0; cell < bounds_.size(); ++cell) {
        candidates.points.insert(candidates.points.end(), pointsOf[cell].begin(),
                                 pointsOf[cell].end());
        candidates.endCell(static_cast<Index>(cell), bounds_[cell]);
    }
    return candidates;
}

std::optional<FoundCells> PointDescent::descend(std::span<const Point3> points, int level,
                                                Sought sought, Extent extent) const {
    FoundCells found{base_, {}, {positions_.begin(), positions_.end()}, {}, {}, {}};
    Candidates candidates = baseCandidates(points, sought);
    candidates.filter(
        [&](std::size_t i, Index) { return isLeft(base_.level(0), candidates.cells[i]); });
    for (int k = 0; k < level; ++k) {
        const far::CellComplex parent = found.refiner.level(k).complex;
        if (sought == Sought::Nearest)
            keepNearest(parent, found.positions, points, margin_, candidates);
        if (candidates.cells.empty()) return std::nullopt;
        found.refiner.refineAround(candidates.cells, k + 1 == level ? extent : Extent::Ring);
        found.tables.push_back(buildLevelTable(found.refiner, k + 1, rules_));
        found.positions = applyLevelTable(found.tables.back(), found.positions);

        const far::Level& next = found.refiner.level(k + 1);
        const CellBounds bounds(next, found.positions, base_.options().creasing);
        Candidates children;
        for (std::size_t i = 0; i < candidates.cells.size(); ++i) {
            const Index cell = candidates.cells[i];
            const Bound& bound = candidates.bounds[i];
            for (const Index vertex : parent.relation(3, 0)[cell]) {
                const auto child =
                    found.refiner.refinement(k + 1).childOf({{0, vertex}, {3, cell}});
                if (!child) continue;  // It is beyond the open boundary.
                const Bound ofChild =
                    k + 1 == level
                        ? bounds.ownBox(child->index)
                        : bounds.boundOf(child->index, bound ? bound->drift : std::nullopt);
                for (const Index point : candidates.pointsOf(i))
                    if (sought == Sought::Nearest || !ofChild ||
                        !(ofChild->box.exteriorDistance(at(points, point)) > margin_))
                        children.points.push_back(point);
                children.endCell(child->index, ofChild);
            }
        }
        candidates = std::move(children);
    }
    found.cells = std::move(candidates.cells);
    found.offsets = std::move(candidates.offsets);
    found.points = std::move(candidates.points);
    return found;
}

}  // namespace espalier::stencils
