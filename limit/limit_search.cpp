// SPDX-License-Identifier: Apache-2.0
#include "limit_search.h"

#include <espalier/base/sort_unique.h>
#include <espalier/embed/continuation.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/stencils/composition.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

#include "patch_solver.h"

namespace espalier::limit {

using Eigen::Vector3d;
using Extent = far::TopologyRefiner::Extent;

namespace {

/// A cell with an edge of this part of the lattice's size is not refined, however long it is: its
/// children would differ by little more than rounding.
constexpr double kThinnest = 1e-13;

/// From this level on cells are so small that the nearest place of a patch is taken as it is, and
/// what no patch gives back is left to the nearest place.
constexpr int kMaxLevelOfPatches = 12;

/// How many cells of a level a point is sought in: more hold it only where the lattice is folded.
constexpr std::size_t kMaxContaining = 48;

/// How many cells of a level may become the nearest one of a point: those around a vertex are all
/// as near.
constexpr std::size_t kMaxNearest = 24;

}  // namespace

/// The candidates of a level that need not be refined.
class LimitSearch::Cells {
public:
    Cells(const LimitSearch& search, const embed::Descent& descent, embed::Sought sought)
        : level_(descent.levels.finestLevel()),
          positions_(descent.levels.finestPositions().begin(),
                     descent.levels.finestPositions().end()) {
        const auto& cells = descent.candidates.cells;
        const int level = descent.levels.finest();
        patches_.resize(cells.size());
        frames_.resize(cells.size());
        for (std::size_t i = 0; i < cells.size(); ++i) {
            if (!embed::isRegularCell(level_, cells[i])) continue;
            frames_[i] = *embed::frameOf(level_.complex, cells[i]);
            patches_[i].emplace(TricubicPatch(level_, frames_[i]).controlPoints(positions_));
        }
        isBlended_.assign(cells.size(), 0);
        if (level > 0 && (search.isFineEnough(level) || sought == embed::Sought::Nearest))
            findBlended(search, descent);
    }

    /// The polynomial of candidate i; null if the cell is not regular.
    const PatchSolver* patch(std::size_t i) const { return patches_[i] ? &*patches_[i] : nullptr; }
    const embed::CellFrame& frame(std::size_t i) const { return frames_[i]; }

    /// Whether candidate i is so small that the limits of its vertices are blended.
    bool isBlended(std::size_t i) const { return isBlended_[i] != 0; }
    /// The same for a point that is so far from the candidate that it hardly matters.
    bool isBlended(std::size_t i, const Vector3d& point) const {
        return isBlended(i) ||
               (blend_ && boxes_[i].exteriorDistance(point) > kFar * boxes_[i].diagonal().norm());
    }
    /// \pre a candidate is blended
    const embed::CellSolver& blend() const { return *blend_; }

private:
    /// In diagonals of a cell. The place of a point that is so far outside is the nearest but for
    /// some 1/8 of the cell squared, and far from what would lose digits: thousands of cells.
    static constexpr double kFar = 8;

    void findBlended(const LimitSearch& search, const embed::Descent& descent) {
        const int level = descent.levels.finest();
        std::vector<Index> corners;
        for (const Index cell : descent.candidates.cells) {
            const auto row = level_.complex.relation(3, 0)[cell];
            corners.insert(corners.end(), row.begin(), row.end());
        }
        sortUnique(corners);
        if (corners.empty()) return;
        if (search.isFineEnough(level)) {
            // What is only far away may be blended of the vertices as they are.
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
        if (!search.isFineEnough(level)) return;
        isBlended_ = areSmall(descent.levels, descent.candidates.cells, search.tolerance_);
        for (std::size_t i = 0; i < isBlended_.size(); ++i)
            isBlended_[i] |=
                isThin(level_.complex.relation(3, 0)[descent.candidates.cells[i]], search.scale_);
    }

    bool isThin(std::span<const Index> vertices, const embed::CellSolver::Scale& scale) const {
        for (const Index v : vertices)
            for (const Index w : vertices)
                if (w < v &&
                    (Vector3d(positions_[v].data()) - Vector3d(positions_[w].data())).norm() <=
                        kThinnest * scale.size)
                    return true;
        return false;
    }

    const far::Level& level_;
    std::vector<Point3> positions_;  ///< limits at the corners of what is blended
    std::vector<std::optional<PatchSolver>> patches_;
    std::vector<embed::CellFrame> frames_;
    std::vector<std::uint8_t> isBlended_;
    std::vector<Eigen::AlignedBox3d> boxes_;  ///< of the candidates, in the limit
    std::optional<embed::CellSolver> blend_;
};

LimitSearch::LimitSearch(const embed::RestLattice& lattice, const LimitOptions& options)
    : tolerance_(options.tolerance),
      seekNearest_(options.embedding.outside == embed::OutsidePolicy::Nearest),
      scale_(embed::CellSolver::scaleOf(lattice.positions, options.embedding.tolerance)),
      finestLevel_(leastLevelOfSmall(options.tolerance)),
      descent_(lattice, scale_) {}

/// \param settle is called for each level: settle(descent, cells) leaves the candidates that are to
///        be refined
template <class Settle>
FoundPoints LimitSearch::search(std::span<const Point3> points, embed::Sought sought,
                                Settle settle) const {
    const bool isNearest = sought == embed::Sought::Nearest;
    FoundPoints found{descent_.begin(points, sought), {}};
    found.points.assign(points.size(), {embed::PointStatus::Outside, {}, 0, 0});
    for (;;) {
        settle(found, Cells(*this, found.descent, sought));
        if (found.descent.candidates.cells.empty()) return found;
        keepFew(found.descent, points, isNearest ? kMaxNearest : kMaxContaining);
        // Boxes allow for a part of a cell, which is more, until cells are as small.
        found.descent.margin = isNearest ? descent_.rounding() : 0;
        descent_.refine(found.descent, points, sought, Extent::Ring, embed::Bounding::Estimate);
    }
}

FoundPoints LimitSearch::findInside(std::span<const Point3> points,
                                    std::vector<Index>& unsettled) const {
    auto result =
        search(points, embed::Sought::Containing, [&](FoundPoints& found, const Cells& cells) {
            const int level = found.descent.levels.finest();
            found.descent.candidates.filter([&](std::size_t i, Index p) {
                LocatedInLimit& located = found.points[p];
                if (located.place) return false;
                const Vector3d point(points[p].data());
                if (!point.allFinite()) return false;
                if (const PatchSolver* patch = cells.patch(i)) {
                    const auto [answer, uvw] = patch->find(point);
                    if (answer == PatchSolver::Answer::Here) {
                        located = {
                            embed::PointStatus::Inside,
                            LimitPlace{level,
                                       FramePlace{cells.frame(i), embed::toArray(uvw), {}, false}},
                            0, (patch->map().position(uvw) - point).norm()};
                        return false;
                    }
                    return answer == PatchSolver::Answer::Undecided && level < kMaxLevelOfPatches;
                }
                if (!cells.isBlended(i)) return true;
                const Index cell = found.descent.candidates.cells[i];
                auto inside = cells.blend().locateIn(point, {&cell, 1});
                if (!inside) {
                    // So small a cell may miss a point on its faces by the rounding of that.
                    inside = cells.blend().locateOutsideCells(point, CellId(cell), true);
                    if (!(inside->distance <= descent_.rounding())) return false;
                }
                if (inside->place)
                    located = {embed::PointStatus::Inside, LimitPlace{level, *inside->place}, 0,
                               inside->residual};
                return false;
            });
        });
    for (std::size_t p = 0; p < points.size(); ++p) {
        LocatedInLimit& located = result.points[p];
        if (located.place) continue;
        const auto beyond =
            embed::CellSolver::resultIfUnreachable(Vector3d(points[p].data()), seekNearest_);
        if (beyond)
            located.status = beyond->status;
        else
            unsettled.push_back(static_cast<Index>(p));
    }
    return result;
}

/// Leaves of each point's cells no more than so many, the nearest ones as they are, whatever they
/// may become.
void LimitSearch::keepFew(embed::Descent& descent, std::span<const Point3> points,
                          std::size_t most) const {
    embed::Candidates& candidates = descent.candidates;
    std::vector<std::vector<std::pair<double, Index>>> cellsOf(points.size());
    for (std::size_t i = 0; i < candidates.cells.size(); ++i)
        for (const Index p : candidates.pointsOf(i))
            cellsOf[p].emplace_back(0, candidates.cells[i]);
    const bool areFew = std::all_of(cellsOf.begin(), cellsOf.end(),
                                    [&](const auto& cells) { return cells.size() <= most; });
    // Base cells may be of any kind, and have no distances yet.
    if (areFew || descent.levels.finest() == 0) return;
    const embed::CellSolver solver(descent.levels.finestLevel().complex,
                                   descent.levels.finestPositions(), scale_);
    for (std::size_t p = 0; p < points.size(); ++p) {
        auto& cells = cellsOf[p];
        if (cells.size() <= most) continue;
        for (auto& [distance, cell] : cells)
            distance = solver.distance(Vector3d(points[p].data()), CellId(cell));
        std::nth_element(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(most),
                         cells.end());
        cells.resize(most);
        std::sort(cells.begin(), cells.end(),
                  [](const auto& a, const auto& b) { return a.second < b.second; });
    }
    candidates.filter([&](std::size_t i, Index p) {
        // Ascending, as they were given.
        const auto& cells = cellsOf[p];
        const auto found =
            std::lower_bound(cells.begin(), cells.end(), candidates.cells[i],
                             [](const auto& cell, Index number) { return cell.second < number; });
        return found != cells.end() && found->second == candidates.cells[i];
    });
}

FoundPoints LimitSearch::findNearest(std::span<const Point3> points) const {
    // If points outside stay, only what is in the gaps is of interest.
    std::vector<double> nearest(points.size(),
                                seekNearest_ ? std::numeric_limits<double>::infinity() : gap());
    auto result =
        search(points, embed::Sought::Nearest, [&](FoundPoints& found, const Cells& cells) {
            const int level = found.descent.levels.finest();
            found.descent.candidates.filter([&](std::size_t i, Index p) {
                const PatchSolver* patch = cells.patch(i);
                const Vector3d point(points[p].data());
                const bool isPatch =
                    patch && (patch->isNearlyLinear() || level >= kMaxLevelOfPatches);
                if (!isPatch && !cells.isBlended(i, point)) return true;
                const Index cell = found.descent.candidates.cells[i];
                LocatedInLimit& located = found.points[p];
                LimitPlace place{level, {}};
                double distance = 0;
                if (patch) {
                    const Vector3d uvw = patch->nearest(point);
                    distance = (patch->map().position(uvw) - point).norm();
                    place.where = FramePlace{cells.frame(i), embed::toArray(uvw), {}, false};
                } else {
                    const auto there = cells.blend().locateOutsideCells(point, CellId(cell), true);
                    if (!there.place) return false;
                    distance = there.distance;
                    place.where = *there.place;
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
    for (std::size_t p = 0; p < points.size(); ++p) {
        LocatedInLimit& located = result.points[p];
        // Nothing is as near as a gap is wide.
        if (!located.place && !seekNearest_) continue;
        located = continued(located, result.descent.levels, Vector3d(points[p].data()));
    }
    return result;
}

/// A point that is in no cell, with its nearest place continued to it along the tangent.
LocatedInLimit LimitSearch::continued(const LocatedInLimit& nearest, const stencils::Levels& levels,
                                      const Vector3d& point) const {
    if (!nearest.place) return {embed::PointStatus::NotConverged, {}, 0, 0};
    const double distance = nearest.distance;
    // In the gap between a patch and what is blended, or as good as on the boundary.
    const bool isInside = distance <= gap();
    const embed::PointStatus status =
        isInside ? embed::PointStatus::Inside : embed::PointStatus::Outside;
    if (!isInside && !seekNearest_) return {status, {}, distance, 0};
    LimitPlace place = *nearest.place;
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
    const auto continued =
        embed::continueTo(point, jacobian, scale_.size, [&](const Vector3d& offset) {
            setOffset(offset);
            return sum(kPosition);
        });
    if (continued) {
        setOffset(continued->offset);
        if (embed::isSettled(continued->position, point, scale_.size))
            return {status, place, distance, (continued->position.sum - point).norm()};
    }
    if (!isInside) return {embed::PointStatus::NotConverged, {}, distance, 0};
    setOffset(Vector3d::Zero());
    return {embed::PointStatus::Inside, place, distance, (sum(kPosition).sum - point).norm()};
}

}  // namespace espalier::limit
