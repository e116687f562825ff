// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/array.h>
#include <espalier/base/sort_unique.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/point_descent.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/far/star.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace espalier::embed {

using Eigen::Vector3d;
using Bound = std::optional<CellBound>;

namespace {

/// Margin of boxes: the box of a child may exceed the parent's by the rounding of sums, which is
/// relative to the lattice's distance from the origin: about 100 times 1e-16 per level.
constexpr double kSlack = 1e-12;

/// The descendants of a cell mostly exceed it by at most this fraction of its size.
constexpr double kEstimatedGrowth = 0.25;

double largestCoordinate(std::span<const Point3> positions) {
    double largest = 0;
    for (const Point3& position : positions)
        for (const double coordinate : position) largest = std::max(largest, std::abs(coordinate));
    return largest;
}

/// Returns the cells that have a bound, or the cells that have none; without the cells that shrink
/// away under Boundary::Open.
std::vector<Index> cellsWith(const far::Level& base, const std::vector<Bound>& bounds, bool bound) {
    std::vector<Index> cells;
    for (Index cell = 0; cell < base.complex.count(3); ++cell)
        if (bounds[cell].has_value() == bound && remainsInLimit(base, cell)) cells.push_back(cell);
    return cells;
}

std::vector<BoxTree::Box> boxesOf(const std::vector<Bound>& bounds, const std::vector<Index>& cells,
                                  double margin) {
    std::vector<BoxTree::Box> boxes;
    boxes.reserve(cells.size());
    for (const Index cell : cells) {
        boxes.push_back(bounds[cell]->box);
        boxes.back().min().array() -= margin;
        boxes.back().max().array() += margin;
    }
    return boxes;
}

/// The points that are sought in a cell, to be tested against the boxes of its children. Each
/// coordinate has an array of its own, so that several points are tested at a time.
class PointsOfCell {
public:
    /// \param all must outlive this
    explicit PointsOfCell(std::span<const Point3> all) : all_(all) {}

    void assign(std::span<const Index> numbers) {
        numbers_ = numbers;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            coordinates_[axis].resize(numbers.size());
            for (std::size_t i = 0; i < numbers.size(); ++i)
                coordinates_[axis][i] = all_[numbers[i]][axis];
        }
    }

    /// Appends the numbers of the points that are in a hull and within a distance of a box, or a
    /// little farther from its edges.
    void appendPointsIn(const Eigen::AlignedBox3d& box, double margin, const AffineHull& hull,
                        std::vector<Index>& found) {
        const std::size_t count = numbers_.size();
        isOutside_.resize(count);
        const Eigen::Array3d low = box.min().array() - margin, high = box.max().array() + margin;
        const double *x = coordinates_[0].data(), *y = coordinates_[1].data(),
                     *z = coordinates_[2].data();
        // The comparisons are such that a NaN is inside. They have no branches: which side fails
        // first is unpredictable. GCC tests several points at a time if the flags have the type of
        // the coordinates.
        const auto isLess = [](double a, double b) { return static_cast<unsigned>(a < b); };
        for (std::size_t i = 0; i < count; ++i) {
            const unsigned isOutside = isLess(x[i], low[0]) | isLess(high[0], x[i]) |
                                       isLess(y[i], low[1]) | isLess(high[1], y[i]) |
                                       isLess(z[i], low[2]) | isLess(high[2], z[i]);
            isOutside_[i] = isOutside != 0 ? 1.0 : 0.0;
        }
        for (std::size_t i = 0; i < count; ++i)
            if (isOutside_[i] == 0 && hull.contains({x[i], y[i], z[i]}))
                found.push_back(numbers_[i]);
    }

private:
    std::span<const Point3> all_;
    std::span<const Index> numbers_;
    std::array<Array<double>, 3> coordinates_;  ///< the coordinates of the points, by axis
    Array<double> isOutside_;                   ///< whether each point is outside the box: 0 or 1
};

/// Returns a distance from a point within which the cell certainly has a descendant.
double reach(const far::CellComplex& complex, std::span<const Point3> positions, Index cell,
             const Bound& bound, const Vector3d& point) {
    if (!bound) return std::numeric_limits<double>::infinity();
    if (!bound->drift) {
        // Distance to the far corner of the box.
        const Vector3d low = (point - bound->box.min()).cwiseAbs();
        return low.cwiseMax((bound->box.max() - point).cwiseAbs()).norm();
    }
    double nearest = std::numeric_limits<double>::infinity();
    for (const Index vertex : complex.relation(3, 0)[cell])
        nearest = std::min(nearest, (Vector3d(positions[vertex].data()) - point).norm());
    return nearest + bound->drift->norm();
}

}  // namespace

PointDescent::PointDescent(const RestLattice& lattice, CellSolver::Scale scale)
    : lattice_(lattice),
      rounding_(kSlack * (scale.size + largestCoordinate(lattice.positions))),
      margin_(scale.tolerance + rounding_),
      bounds_([&] {
          CellBounds bounds(lattice.base.level(0), lattice.positions,
                            lattice.base.options().creasing);
          std::vector<Bound> result;
          result.reserve(lattice.base.level(0).complex.count(3));
          for (Index cell = 0; cell < lattice.base.level(0).complex.count(3); ++cell)
              result.push_back(bounds.boundOf(cell, std::nullopt));
          return result;
      }()),
      bounded_(cellsWith(lattice.base.level(0), bounds_, true)),
      unbounded_(cellsWith(lattice.base.level(0), bounds_, false)),
      tree_(boxesOf(bounds_, bounded_, margin_)) {}

/// Returns the base cells that may contain a point or have descendants that do.
Candidates PointDescent::baseCandidates(std::span<const Point3> points, SoughtCells sought) const {
    std::vector<std::pair<Index, Index>> pairs;         // Cell and point, by point.
    std::vector<Offset> begins(bounds_.size() + 1, 0);  // First the number of pairs of each cell.
    const auto add = [&](std::size_t point, Index cell) {
        pairs.emplace_back(cell, static_cast<Index>(point));
        ++begins[cell + 1];
    };
    const auto addAll = [&](std::size_t point, std::span<const Index> found) {
        for (const Index cell : unbounded_) add(point, cell);
        for (const Index i : found) add(point, bounded_[i]);
    };
    if (sought == SoughtCells::Containing) {
        tree_.findContaining(points, addAll);
    } else {
        std::vector<Index> found;
        for (std::size_t point = 0; point < points.size(); ++point) {
            const Vector3d position(points[point].data());
            const auto reachOf = [&](Index i) {
                const Index cell = bounded_[i];
                return reach(lattice_.base.level(0).complex, lattice_.positions, cell,
                             bounds_[cell], position);
            };
            found.clear();
            tree_.findWithin(position, tree_.findNearest(position, reachOf).distance + margin_,
                             found);
            addAll(point, found);
        }
    }
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    Candidates candidates;
    candidates.points.resize(pairs.size());
    for (const auto& [cell, point] : pairs) candidates.points[begins[cell]++] = point;
    // Now begins[cell] is the end of the cell's points.
    for (std::size_t cell = 0; cell < bounds_.size(); ++cell)
        if (begins[cell] > candidates.offsets.back()) {
            candidates.cells.push_back(static_cast<Index>(cell));
            candidates.bounds.push_back(bounds_[cell]);
            candidates.offsets.push_back(begins[cell]);
        }
    return candidates;
}

Descent PointDescent::begin(std::span<const Point3> points, SoughtCells sought) const {
    const far::Level& base = lattice_.base.level(0);
    Candidates candidates = baseCandidates(points, sought);
    std::vector<Index> corners;
    for (const Index cell : candidates.cells) {
        const auto row = base.complex.relation(3, 0)[cell];
        corners.insert(corners.end(), row.begin(), row.end());
    }
    sortUnique(corners);
    far::RefinerOptions options = lattice_.base.options();
    far::Star star = far::starOf(base, corners, far::ringsAround(base, options.creasing));
    for (Index& cell : candidates.cells) cell = indexIn(star.entities[3], cell);
    // The strata contain the marks, which have the numbers of the base.
    options.marks = {};
    return {stencils::Levels(far::TopologyRefiner(std::move(star.level), options),
                             chosenPoints(lattice_.positions, star.entities[0])),
            std::move(star.entities[0]), std::move(candidates), margin_};
}

void PointDescent::keepNearest(Descent& descent, std::span<const Point3> points,
                               std::span<double> nearest) const {
    const far::CellComplex& complex = descent.levels.finestLevel().complex;
    Candidates& candidates = descent.candidates;
    for (std::size_t i = 0; i < candidates.cells.size(); ++i)
        for (const Index point : candidates.pointsOf(i)) {
            double& best = nearest[point];
            best =
                std::min(best, reach(complex, descent.levels.finestPositions(), candidates.cells[i],
                                     candidates.bounds[i], Vector3d(points[point].data())));
        }
    candidates.filter([&](std::size_t i, Index point) {
        const Bound& bound = candidates.bounds[i];
        // The comparison is such that a NaN keeps the cell.
        return !bound || !(bound->box.exteriorDistance(Vector3d(points[point].data())) >
                           nearest[point] + descent.margin);
    });
}

void PointDescent::refine(Descent& descent, std::span<const Point3> points, SoughtCells sought,
                          Extent extent, Bounding bounding) const {
    const far::CellComplex parent = descent.levels.finestLevel().complex;
    descent.levels.refineAround(descent.candidates.cells, extent);
    const far::Refinement& refinement =
        descent.levels.refiner().refinement(descent.levels.finest());
    CellBounds bounds(descent.levels.finestLevel(), descent.levels.finestPositions(),
                      lattice_.base.options().creasing);
    const Candidates parents = std::exchange(descent.candidates, {});
    Candidates& children = descent.candidates;
    PointsOfCell ofParent(points);
    for (std::size_t i = 0; i < parents.cells.size(); ++i) {
        const Index cell = parents.cells[i];
        ofParent.assign(parents.pointsOf(i));
        const Bound& bound = parents.bounds[i];
        for (const Index vertex : parent.relation(3, 0)[cell]) {
            const auto child = refinement.childOf({{0, vertex}, {3, cell}});
            if (!child) continue;  // The child is outside the open boundary.
            const Bound ofChild =
                bounding == Bounding::AllLevels
                    ? bounds.boundOf(child->index, bound ? bound->drift : std::nullopt)
                    : bounds.ownBox(child->index,
                                    bounding == Bounding::Estimate ? kEstimatedGrowth : 0);
            const AffineHull hull =
                sought == SoughtCells::Containing && bounding == Bounding::Estimate
                    ? bounds.ownHull(child->index, kEstimatedGrowth)
                    : AffineHull();
            if (sought == SoughtCells::Nearest || !ofChild) {
                const auto all = parents.pointsOf(i);
                children.points.insert(children.points.end(), all.begin(), all.end());
            } else {
                ofParent.appendPointsIn(ofChild->box, descent.margin, hull, children.points);
            }
            children.endCell(child->index, ofChild);
        }
    }
}

namespace {

/// Returns the number of cells that Extent::Ring refines around the candidates: all cells [v, c]
/// with v a vertex of a candidate.
Offset ringCellCount(const Descent& descent) {
    const far::CellComplex& complex = descent.levels.finestLevel().complex;
    std::vector<Index> corners;
    for (const Index cell : descent.candidates.cells) {
        const auto row = complex.relation(3, 0)[cell];
        corners.insert(corners.end(), row.begin(), row.end());
    }
    sortUnique(corners);
    Offset count = 0;
    for (const Index corner : corners) count += std::ssize(complex.relation(0, 3)[corner]);
    return count;
}

/// Estimates the number of cells of the levels from the next one to `level`.
/// \param growth number of candidates for each candidate of the level before
double expectedCellCount(const Descent& descent, std::size_t pointCount, double growth, int level) {
    auto candidates = static_cast<double>(descent.candidates.cells.size());
    // On fine levels, each point has a cell of its own.
    const double maxCandidates = std::max(candidates, static_cast<double>(pointCount));
    auto ring = static_cast<double>(ringCellCount(descent));
    double sum = 0;
    for (int k = descent.levels.finest() + 1; k < level; ++k) {
        sum += ring;
        const double next = std::min(growth * candidates, maxCandidates);
        ring *= next / candidates;
        candidates = next;
    }
    // The last level has only the children of its candidates, mostly hexahedra.
    return sum + 8 * candidates;
}

}  // namespace

void PointDescent::descend(std::span<const Point3> points, int level, SoughtCells sought,
                           Extent extent, Use use) const {
    constexpr Offset kMinPoints = 16;
    const Offset pointCount = std::ssize(points);
    Offset partCount = 1;
    auto found = descendAtOnce(points, level, sought, extent,
                               pointCount > kMinPoints ? &partCount : nullptr);
    if (partCount == 1) return use(0, points, found);
    const Offset partSize = std::max(kMinPoints, (pointCount + partCount - 1) / partCount);
    for (Offset begin = 0; begin < pointCount; begin += partSize)
        descend(points.subspan(begin, std::min(partSize, pointCount - begin)), level, sought,
                extent,
                [&](Offset first, auto part, auto& ofPart) { use(begin + first, part, ofPart); });
}

/// Refines down to a level as descend(), for all points at once.
/// \param partCount null if the points may not be divided. Otherwise the function sets it to the
///        number of parts that keep the levels small enough. If this number is not 1, the function
///        stops and returns nothing
std::optional<Descent> PointDescent::descendAtOnce(std::span<const Point3> points, int level,
                                                   SoughtCells sought, Extent extent,
                                                   Offset* partCount) const {
    // A cell takes about 1.5 kB, with its share of faces, edges, vertices, relations and weights.
    constexpr double kMaxCells = 10'000;
    Descent descent = begin(points, sought);
    double cellCount = 0, growth = 1;
    for (int k = 1; k <= level; ++k) {
        if (sought == SoughtCells::Nearest) {
            std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
            keepNearest(descent, points, nearest);
        }
        if (descent.candidates.cells.empty()) return std::nullopt;
        if (partCount != nullptr) {
            cellCount += descent.levels.finestLevel().complex.count(3);
            const double expected =
                cellCount + expectedCellCount(descent, points.size(), growth, level);
            *partCount =
                std::max(Offset{1}, static_cast<Offset>(std::lround(expected / kMaxCells)));
            if (*partCount > 1) return std::nullopt;
        }
        const bool isLast = k == level;
        const auto parentCount = static_cast<double>(descent.candidates.cells.size());
        refine(descent, points, sought, isLast ? extent : Extent::Ring,
               isLast ? Bounding::Corners : Bounding::AllLevels);
        growth = static_cast<double>(descent.candidates.cells.size()) / parentCount;
    }
    return descent;
}

}  // namespace espalier::embed
