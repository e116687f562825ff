// SPDX-License-Identifier: Apache-2.0
#include "limit_search.h"

#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/embed/continuation.h>
#include <espalier/embed/patch_solver.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "edge_search.h"

namespace espalier::limit {

using Eigen::Vector3d;
using embed::CellSolver;
using embed::PatchSolver;
using embed::TricubicPatch;
using Extent = far::TopologyRefiner::Extent;

namespace {

/// A cell with an edge shorter than this fraction of the lattice's size is not refined, however
/// long the cell is: its children would differ by little more than rounding.
constexpr double kThinnest = 1e-13;

/// From this level on, cells are very small. findNearest() then accepts the place that
/// PatchSolver::nearest() gives, and findInside() gives up on cells for which PatchSolver is
/// Undecided.
constexpr int kMaxLevelOfPatches = 12;

/// Level on which most points are found or share no cells.
constexpr int kDeepLevel = 8;
constexpr int kNoMaxLevel = std::numeric_limits<int>::max();

/// Maximum number of cells of a level that are searched for a point. More cells contain the point
/// only where the lattice is folded.
constexpr std::size_t kMaxContaining = 48;

/// Maximum number of cells of a level kept as candidates for the nearest one: the cells around a
/// vertex are all equally near.
constexpr std::size_t kMaxNearest = 24;

}  // namespace

/// Solvers for the candidates of a level: patches for regular cells, a blend for cells that need no
/// further refinement.
class LimitSearch::Cells {
public:
    /// \param blendLevel the next level on which a cell may be small enough to be blended; raised
    ///        if it is the level of the candidates. It is the same for all points of a group, so a
    ///        cell that shrinks unusually fast may be blended a level later because of the others;
    ///        its error is within the tolerance in both cases
    Cells(const LimitSearch& search, const embed::Descent& descent, embed::SoughtCells sought,
          int& blendLevel)
        : level_(descent.levels.finestLevel()),
          positions_(descent.levels.finestPositions().begin(),
                     descent.levels.finestPositions().end()),
          edges_(level_, descent.levels.finestPositions(), search.refinements_,
                 search.tolerance_ * search.scale_.size) {
        const auto& cells = descent.candidates.cells;
        const int level = descent.levels.finest();
        patches_.resize(cells.size());
        frames_.resize(cells.size());
        std::vector<std::optional<bool>> isRegular(level_.complex.count(0));
        const auto isRegularVertex = [&](Index vertex) {
            auto& known = isRegular[vertex];
            if (!known) known = embed::isRegularVertex(level_, vertex);
            return *known;
        };
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const auto vertices = level_.complex.relation(3, 0)[cells[i]];
            if (!std::all_of(vertices.begin(), vertices.end(), isRegularVertex)) continue;
            frames_[i] = *embed::frameOf(level_.complex, cells[i]);
            patches_[i].emplace(TricubicPatch(level_, frames_[i]).controlPoints(positions_));
        }
        if (sought == embed::SoughtCells::Containing)
            for (std::size_t i = 0; i < cells.size(); ++i)
                if (!patches_[i]) edges_.add(i, cells[i]);
        isBlended_.assign(cells.size(), 0);
        if (level > 0 && (level >= blendLevel || sought == embed::SoughtCells::Nearest))
            findBlended(search, descent, blendLevel);
    }

    /// Returns the solver of candidate i, or null if the cell is not regular.
    const PatchSolver* patch(std::size_t i) const { return patches_[i] ? &*patches_[i] : nullptr; }
    const embed::CellFrame& frame(std::size_t i) const { return frames_[i]; }

    /// True if candidate i is so small that the limits of its vertices are blended.
    bool isBlended(std::size_t i) const { return isBlended_[i] != 0; }
    /// True also if the point is so far from the candidate that the error of blending hardly
    /// matters.
    bool isBlended(std::size_t i, const Vector3d& point) const {
        return isBlended(i) ||
               (blend_ && boxes_[i].exteriorDistance(point) > kFar * boxes_[i].diagonal().norm());
    }
    /// \pre isBlended() is true for some candidate
    const CellSolver& blend() const { return *blend_; }

    /// Returns the rows of a point on the limit of an irregular edge of candidate i: see
    /// EdgeSearch::find(). Null if the nearest cell is sought.
    std::shared_ptr<const EdgeRows> onEdge(std::size_t i, const Vector3d& point) {
        return edges_.find(i, point);
    }

private:
    /// Distance from a cell, in diagonals of the cell, beyond which a blend is used. At this
    /// distance the nearest place of the blend is wrong by about 1/8 of the cell's size squared.
    /// Precision is lost only at thousands of cell sizes.
    static constexpr double kFar = 8;

    void findBlended(const LimitSearch& search, const embed::Descent& descent, int& blendLevel) {
        const int level = descent.levels.finest();
        const bool isFineEnough = level >= blendLevel;
        std::vector<Index> corners;
        for (const Index cell : descent.candidates.cells) {
            const auto row = level_.complex.relation(3, 0)[cell];
            corners.insert(corners.end(), row.begin(), row.end());
        }
        sortUnique(corners);
        if (corners.empty()) return;
        if (isFineEnough) {
            // On coarser levels a cell is blended only for points far away, and the vertices are
            // near enough to their limits.
            const auto limits = blendedRows(descent.levels, level, corners);
            const auto places = stencils::applyLevelTable(limits, positions_);
            for (std::size_t i = 0; i < corners.size(); ++i) positions_[corners[i]] = places[i];
        }
        blend_.emplace(level_.complex, positions_, search.scale_);

        for (const Index cell : descent.candidates.cells) {
            boxes_.emplace_back();
            for (const Index vertex : level_.complex.relation(3, 0)[cell])
                boxes_.back().extend(Vector3d(positions_[vertex].data()));
        }
        if (!isFineEnough) return;
        const auto sizes = cellSizes(descent.levels, descent.candidates.cells);
        const double thinnest = kThinnest * search.scale_.size;
        int levelsLeft = std::numeric_limits<int>::max();
        for (std::size_t i = 0; i < isBlended_.size(); ++i) {
            const double shortest =
                shortestSide(level_.complex.relation(3, 0)[descent.candidates.cells[i]]);
            isBlended_[i] = sizes[i] <= search.tolerance_ || shortest <= thinnest;
            if (isBlended_[i] || patches_[i]) continue;
            levelsLeft = std::min({levelsLeft, levelsToShrink(sizes[i], search.tolerance_),
                                   levelsToShrink(shortest, thinnest)});
        }
        if (levelsLeft < std::numeric_limits<int>::max()) blendLevel = level + levelsLeft;
    }

    /// Returns the smallest distance between two vertices of a cell.
    double shortestSide(std::span<const Index> vertices) const {
        double shortest = std::numeric_limits<double>::infinity();
        for (const Index v : vertices)
            for (const Index w : vertices)
                if (w < v)
                    shortest = std::min(
                        shortest,
                        (Vector3d(positions_[v].data()) - Vector3d(positions_[w].data())).norm());
        return shortest;
    }

    const far::Level& level_;
    std::vector<Point3> positions_;  ///< vertices; corners of blended cells are at their limits
    std::vector<std::optional<PatchSolver>> patches_;
    std::vector<embed::CellFrame> frames_;
    std::vector<std::uint8_t> isBlended_;
    std::vector<Eigen::AlignedBox3d> boxes_;  ///< contain the candidates, in the limit
    std::optional<CellSolver> blend_;
    EdgeSearch edges_;
};

LimitSearch::LimitSearch(const embed::RestLattice& lattice, const LimitOptions& options)
    : tolerance_(options.tolerance),
      scale_(CellSolver::scaleOf(lattice.positions, options.embedding.tolerance)),
      vertex_(lattice.positions.front()),
      descent_(lattice, scale_),
      refinements_(lattice.base.rules()) {}

/// Refines around the candidates until none is left, or up to a level.
/// \param settle is called on each level: settle(found, cells) removes the candidates that need no
///        refinement
template <class Settle>
FoundPoints LimitSearch::search(std::span<const Point3> points, embed::SoughtCells sought,
                                int maxLevel, Settle settle) const {
    const bool isNearest = sought == embed::SoughtCells::Nearest;
    FoundPoints found{descent_.begin(points, sought), {}};
    found.points.assign(points.size(), {embed::PointStatus::Outside, {}, 0, 0});
    int blendLevel = levelsToShrink(1, tolerance_);
    for (;;) {
        Cells cells(*this, found.descent, sought, blendLevel);
        settle(found, cells);
        if (found.descent.candidates.cells.empty() || found.descent.levels.finest() == maxLevel)
            return found;
        limitCandidates(found.descent, points, isNearest ? kMaxNearest : kMaxContaining);
        // A search for containing cells needs no margin: a bounding box exceeds its cell by a
        // fraction of the cell's size, which is larger than the rounding error of all but the
        // smallest cells.
        found.descent.margin = isNearest ? descent_.rounding() : 0;
        descent_.refine(found.descent, points, sought, Extent::Ring, embed::Bounding::Estimate);
    }
}

FoundPoints LimitSearch::findInside(std::span<const Point3> points, std::vector<Index>& unsettled,
                                    std::vector<Index>& deep) const {
    const int maxLevel = points.size() > kMaxDeepPoints ? kDeepLevel : kNoMaxLevel;
    auto result = search(
        points, embed::SoughtCells::Containing, maxLevel, [&](FoundPoints& found, Cells& cells) {
            const int level = found.descent.levels.finest();
            found.descent.candidates.filter([&](std::size_t i, Index p) {
                LocatedInLimit& located = found.points[p];
                if (located.place) return false;
                const Vector3d point(points[p].data());
                if (!point.allFinite()) return false;
                if (const PatchSolver* patch = cells.patch(i)) {
                    const auto [answer, uvw] = patch->find(point);
                    if (answer == PatchSolver::Answer::Inside) {
                        located = {
                            embed::PointStatus::Inside,
                            LimitPlace{level,
                                       FramePlace{cells.frame(i), embed::toArray(uvw), {}, false}},
                            0, patch->distance(uvw, point)};
                        return false;
                    }
                    return answer == PatchSolver::Answer::Undecided && level < kMaxLevelOfPatches;
                }
                if (auto rows = cells.onEdge(i, point)) {
                    const ContinuedPlace there =
                        continued({level, EdgePlace{std::move(rows), {}}}, found.descent.levels,
                                  point, CellSolver::kMaxGap);
                    if (there.isSettled) {
                        located = {embed::PointStatus::Inside, there.place, 0, there.residual};
                        return false;
                    }
                }
                if (!cells.isBlended(i)) return true;
                const Index cell = found.descent.candidates.cells[i];
                auto inside = cells.blend().locateIn(point, {&cell, 1});
                if (!inside) {
                    // The cell is so small that rounding may put a point on its faces outside.
                    const auto nearest = cells.blend().nearestIn(CellId(cell), point);
                    if (!(nearest.distance <= descent_.rounding())) return false;
                    inside = cells.blend().settle(point, nearest, descent_.rounding());
                }
                located = {embed::PointStatus::Inside, LimitPlace{level, *inside->place}, 0,
                           inside->residual};
                return false;
            });
        });
    // Candidates also remain of points that another cell contains.
    deep.clear();
    for (const Index p : result.descent.candidates.points)
        if (!result.points[p].place) deep.push_back(p);
    sortUnique(deep);
    for (std::size_t p = 0; p < points.size(); ++p) {
        LocatedInLimit& located = result.points[p];
        if (located.place || std::binary_search(deep.begin(), deep.end(), static_cast<Index>(p)))
            continue;
        const auto beyond =
            CellSolver::resultIfUnreachable(Vector3d(points[p].data()), vertex_, scale_.size);
        if (beyond)
            located.status = beyond->status;
        else
            unsettled.push_back(static_cast<Index>(p));
    }
    return result;
}

/// Keeps at most `maxCells` cells for each point: the nearest ones, measured before refinement.
void LimitSearch::limitCandidates(embed::Descent& descent, std::span<const Point3> points,
                                  std::size_t maxCells) const {
    // Base cells may be of any type; CellSolver has no distances for them.
    if (descent.levels.finest() == 0) return;
    embed::Candidates& candidates = descent.candidates;
    std::vector<std::size_t> counts(points.size(), 0);
    for (const Index p : candidates.points) ++counts[p];
    if (std::all_of(counts.begin(), counts.end(),
                    [&](std::size_t count) { return count <= maxCells; }))
        return;
    std::vector<std::vector<std::pair<double, Index>>> cellsOf(points.size());
    for (std::size_t i = 0; i < candidates.cells.size(); ++i)
        for (const Index p : candidates.pointsOf(i))
            cellsOf[p].emplace_back(0, candidates.cells[i]);
    const CellSolver solver(descent.levels.finestLevel().complex, descent.levels.finestPositions(),
                            scale_);
    for (std::size_t p = 0; p < points.size(); ++p) {
        checkCancelledEvery(p, 4);
        auto& cells = cellsOf[p];
        if (cells.size() <= maxCells) continue;
        for (auto& [distance, cell] : cells)
            distance = solver.distance(Vector3d(points[p].data()), CellId(cell));
        std::nth_element(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(maxCells),
                         cells.end());
        cells.resize(maxCells);
        std::sort(cells.begin(), cells.end(),
                  [](const auto& a, const auto& b) { return a.second < b.second; });
    }
    candidates.filter([&](std::size_t i, Index p) {
        // The cells are sorted by number.
        const auto& cells = cellsOf[p];
        const auto found =
            std::lower_bound(cells.begin(), cells.end(), candidates.cells[i],
                             [](const auto& cell, Index number) { return cell.second < number; });
        return found != cells.end() && found->second == candidates.cells[i];
    });
}

/// Finds the nearest place of each point, among the places that are at most `reach` away. The
/// places have no offset yet.
FoundPoints LimitSearch::findNearest(std::span<const Point3> points, double reach) const {
    std::vector<double> nearest(points.size(), reach);
    return search(
        points, embed::SoughtCells::Nearest, kNoMaxLevel, [&](FoundPoints& found, Cells& cells) {
            const int level = found.descent.levels.finest();
            found.descent.candidates.filter([&](std::size_t i, Index p) {
                const PatchSolver* patch = cells.patch(i);
                const Vector3d point(points[p].data());
                const bool isPatch =
                    patch && (patch->isNearlyLinear() || level >= kMaxLevelOfPatches);
                if (!isPatch && !cells.isBlended(i, point)) return true;
                LocatedInLimit& located = found.points[p];
                LimitPlace place{level, {}};
                double distance = 0;
                if (patch) {
                    const Vector3d uvw = patch->nearest(point);
                    distance = patch->distance(uvw, point);
                    place.where = FramePlace{cells.frame(i), embed::toArray(uvw), {}, false};
                } else {
                    const auto there =
                        cells.blend().nearestIn(CellId(found.descent.candidates.cells[i]), point);
                    distance = there.distance;
                    place.where = there.place;
                }
                if (!located.place || distance < located.distance) {
                    located = {embed::PointStatus::Outside, place, distance, 0};
                    double& known = nearest[p];
                    known = std::min(known, distance);
                }
                return false;
            });
            descent_.keepNearest(found.descent, points, nearest);
        });
}

FoundPoints LimitSearch::findBeside(std::span<const Point3> points,
                                    std::vector<Index>& outside) const {
    FoundPoints result = findNearest(points, gap());
    for (std::size_t p = 0; p < points.size(); ++p) {
        LocatedInLimit& located = result.points[p];
        checkCancelledEvery(p, 4);
        if (!located.place || !(located.distance <= gap())) {
            located.place.reset();
            outside.push_back(static_cast<Index>(p));
            continue;
        }
        const ContinuedPlace there = continued(*located.place, result.descent.levels,
                                               Vector3d(points[p].data()), CellSolver::kMaxGap);
        located = {embed::PointStatus::Inside, there.place, located.distance, there.residual};
    }
    return result;
}

FoundPoints LimitSearch::carry(std::span<const Point3> points) const {
    constexpr double kAnyDistance = std::numeric_limits<double>::infinity();
    FoundPoints result = findNearest(points, kAnyDistance);
    for (std::size_t p = 0; p < points.size(); ++p) {
        checkCancelledEvery(p, 4);
        LocatedInLimit& located = result.points[p];
        if (!located.place) continue;
        const ContinuedPlace there = continued(*located.place, result.descent.levels,
                                               Vector3d(points[p].data()), kAnyDistance);
        if (there.isSettled)
            located = {located.status, there.place, located.distance, there.residual, there.away};
        else
            located.place.reset();
    }
    return result;
}

/// Continues a place along the tangent, up to a point.
/// \param maxOffset largest coordinate of the offset
LimitSearch::ContinuedPlace LimitSearch::continued(LimitPlace place, const stencils::Levels& levels,
                                                   const Vector3d& point, double maxOffset) const {
    const PlaceRows rows(levels, place.level, {&place, 1});
    const auto sum = [&](const Orders& orders) {
        return embed::weightedSum(rows.weights(0, orders), [&](Index vertex) {
            return Vector3d(levels.positions(place.level)[vertex].data());
        });
    };
    const auto setOffset = [&](const Vector3d& offset) {
        std::visit([&](auto& where) { where.offset = embed::toArray(offset); }, place.where);
    };
    setOffset(Vector3d::Zero());
    Eigen::Matrix3d jacobian;
    for (std::size_t axis = 0; axis < 3; ++axis)
        jacobian.col(static_cast<Eigen::Index>(axis)) = sum(kFirst[axis]).sum;
    const Point3 away = embed::toArray(point - sum(kPosition).sum);
    const auto continuation =
        embed::continueTo(point, jacobian, scale_.size, [&](const Vector3d& offset) {
            setOffset(offset);
            return sum(kPosition);
        });
    if (continuation && embed::isWithin(embed::toArray(continuation->offset), maxOffset)) {
        setOffset(continuation->offset);
        if (embed::isSettled(continuation->position, point, scale_.size))
            return {place, (continuation->position.sum - point).norm(), true, away};
    }
    setOffset(Vector3d::Zero());
    return {place, (sum(kPosition).sum - point).norm(), false, away};
}

}  // namespace espalier::limit
