// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/cancellable_sort.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "weld.h"

namespace espalier::shapes {
namespace {

/// A box of a grid, by its numbers along the axes.
using Box = std::array<double, 3>;

/// Finds the welded points near a point. They are stored by the boxes of a grid that is four times
/// as wide as the distance. So a search reads few boxes, mostly one; and a box holds few points,
/// wherever the points are, since welded points are more than the distance apart. The boxes are
/// sorted and not hashed, so no choice of points makes the search slow.
class PointGrid {
public:
    PointGrid(std::span<const Point3> points, double distance)
        : distance_(distance), boxSize_(4 * distance) {
        boxes_.reserve(points.size());
        for (const Point3& point : points) boxes_.push_back(boxOf(point));
        sortCancellably(boxes_.begin(), boxes_.end());
        boxes_.erase(std::unique(boxes_.begin(), boxes_.end()), boxes_.end());
        first_.assign(boxes_.size(), -1);
    }

    /// Adds the next welded point.
    /// \param point one of the points of the grid
    void add(const Point3& point) {
        Index& first = first_[*find(boxOf(point))];
        next_.push_back(first);
        first = static_cast<Index>(positions_.size());
        positions_.push_back(point);
    }

    /// Returns the welded point nearest to `point` within the distance. If several are equally
    /// near, returns the one that was added first.
    std::optional<Index> nearest(const Point3& point) const {
        const Point3 reach = {distance_, distance_, distance_};
        const std::array<Box, 3> near = {boxOf(difference(point, reach)), boxOf(point),
                                         boxOf(sum(point, reach))};
        std::optional<Index> best;
        double bestDistance = std::numeric_limits<double>::infinity();
        const auto visit = [&](const Box& box) {
            const auto place = find(box);
            for (Index index = place ? first_[*place] : -1; index >= 0; index = next_[index]) {
                const double apart = length(difference(positions_[index], point));
                if (apart > distance_ || apart > bestDistance) continue;
                if (apart == bestDistance && index > *best) continue;
                best = index;
                bestDistance = apart;
            }
        };
        // Along each axis the distance reaches two boxes at most, three if rounding moves a wall.
        const auto isNew = [&](std::size_t axis, std::size_t i) {
            return i == 0 || near[i][axis] != near[i - 1][axis];
        };
        for (std::size_t x = 0; x < 3; ++x)
            for (std::size_t y = 0; y < 3 && isNew(0, x); ++y)
                for (std::size_t z = 0; z < 3 && isNew(1, y); ++z)
                    if (isNew(2, z)) visit({near[x][0], near[y][1], near[z][2]});
        return best;
    }

    std::vector<Point3> takePositions() { return std::move(positions_); }

private:
    Box boxOf(const Point3& point) const {
        Box box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double place = std::floor(point[axis] / boxSize_);
            // Without a distance, or if it is far below the rounding of the coordinate, only equal
            // coordinates are near. Adding 0 turns −0 into 0.
            box[axis] = std::isfinite(place) ? place : point[axis] + 0.0;
        }
        return box;
    }

    /// Returns the place of a box in the lists; nothing if it has none of the points.
    std::optional<std::size_t> find(const Box& box) const {
        const auto at = std::lower_bound(boxes_.begin(), boxes_.end(), box);
        if (at == boxes_.end() || *at != box) return std::nullopt;
        return at - boxes_.begin();
    }

    double distance_, boxSize_;
    std::vector<Box> boxes_;    ///< those with points, ascending
    std::vector<Index> first_;  ///< the welded point that was added last to each box; −1: none
    std::vector<Index> next_;   ///< the point before each welded point in its box; −1: none
    std::vector<Point3> positions_;
};

}  // namespace

Welding weld(std::span<const Point3> points, double distance) {
    Welding welding;
    PointGrid grid(points, distance);
    Index count = 0;
    for (const Point3& point : points) {
        checkCancelledEvery(welding.newIndex.size(), 12);
        const std::optional<Index> same = grid.nearest(point);
        if (!same) grid.add(point);
        welding.newIndex.push_back(same ? *same : count++);
    }
    welding.positions = grid.takePositions();
    return welding;
}

}  // namespace espalier::shapes
