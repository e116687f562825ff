// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/base/hash.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "weld.h"

namespace espalier::shapes {
namespace {

/// Stores the welded points by the boxes of a grid, in a hash table.
class PointGrid {
public:
    /// \param origin lower bound of all points, in each coordinate
    PointGrid(const Point3& origin, double boxSize) : origin_(origin), boxSize_(boxSize) {}

    void insert(Index index, const Point3& point) {
        boxes_[boxOf(point)].push_back({index, point});
    }

    /// Returns the point nearest to `point` within `distance`. If several are equally near, returns
    /// the one that was inserted first.
    std::optional<Index> nearest(const Point3& point, double distance) const {
        const Point3 reach = {distance, distance, distance};
        const Box low = boxOf(difference(point, reach));
        const Box high = boxOf(sum(point, reach));
        std::optional<Index> best;
        double bestDistance = std::numeric_limits<double>::infinity();
        for (std::int64_t x = low[0]; x <= high[0]; ++x)
            for (std::int64_t y = low[1]; y <= high[1]; ++y)
                for (std::int64_t z = low[2]; z <= high[2]; ++z) {
                    const auto box = boxes_.find({x, y, z});
                    if (box == boxes_.end()) continue;
                    for (const auto& [index, position] : box->second) {
                        const double apart = length(difference(position, point));
                        if (apart > distance || apart > bestDistance) continue;
                        if (apart == bestDistance && index > *best) continue;
                        best = index;
                        bestDistance = apart;
                    }
                }
        return best;
    }

private:
    using Box = std::array<std::int64_t, 3>;

    struct Hash {
        std::size_t operator()(const Box& box) const {
            // Odd multipliers spread neighbouring boxes over the table.
            std::uint64_t hash = 0;
            for (const std::int64_t coordinate : box)
                hash = (hash ^ static_cast<std::uint64_t>(coordinate)) * kHashFactor;
            return hash ^ (hash >> 32U);
        }
    };

    Box boxOf(const Point3& point) const {
        Box box;
        for (std::size_t axis = 0; axis < 3; ++axis)
            box[axis] =
                static_cast<std::int64_t>(std::floor((point[axis] - origin_[axis]) / boxSize_));
        return box;
    }

    Point3 origin_;
    double boxSize_;
    std::unordered_map<Box, std::vector<std::pair<Index, Point3>>, Hash> boxes_;
};

}  // namespace

Welding weld(std::span<const Point3> points, double distance) {
    Welding welding;
    if (points.empty()) return welding;
    // A box is at least four times as wide as the distance, so that most searches read one box
    // only. A box is also at least kFinest times the size of the whole, so that the numbers of
    // boxes do not overflow.
    constexpr double kFinest = 1.0 / (1 << 20);
    const BoundingBox bounds(points);
    const double diagonal = bounds.diagonal();
    const double boxSize = diagonal > 0 ? std::max(4 * distance, diagonal * kFinest) : 1;
    PointGrid grid(bounds.min, boxSize);
    for (const Point3& point : points) {
        std::optional<Index> same = grid.nearest(point, distance);
        if (!same) {
            same = static_cast<Index>(welding.positions.size());
            welding.positions.push_back(point);
            grid.insert(*same, point);
        }
        welding.newIndex.push_back(*same);
    }
    return welding;
}

}  // namespace espalier::shapes
