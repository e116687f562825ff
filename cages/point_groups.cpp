// SPDX-License-Identifier: Apache-2.0
#include "point_groups.h"

#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <utility>

namespace espalier::cages {

CubeGrid::CubeGrid(const Point3& low, const Point3& high, double wanted) : size(wanted) {
    constexpr double kMaxCubes = 3e7;
    for (;; size *= 1.25) {
        double total = 1;
        for (int axis = 0; axis < 3; ++axis)
            total *= std::floor((high[axis] - low[axis]) / size) + 3;
        if (total <= kMaxCubes) break;
    }
    for (int axis = 0; axis < 3; ++axis) {
        counts[axis] = static_cast<Index>(std::floor((high[axis] - low[axis]) / size)) + 3;
        origin[axis] = low[axis] - size;
    }
}

std::array<Index, 3> CubeGrid::coordinatesOf(const Point3& point) const {
    std::array<Index, 3> result;
    for (int axis = 0; axis < 3; ++axis) {
        const double place = std::floor((point[axis] - origin[axis]) / size);
        result[axis] = static_cast<Index>(std::clamp(place, 0.0, counts[axis] - 1.0));
    }
    return result;
}

PointGroups::PointGroups(std::span<const FitPoint> points, const CubeGrid& grid) : grid_(grid) {
    // Keys are sorted instead of the points, which take four times the memory.
    struct Key {
        Index cube;
        std::optional<Index> cell;
        std::uint32_t number;
    };
    std::vector<Key> keys;
    keys.reserve(points.size());
    for (const FitPoint& point : points)
        keys.push_back(
            {grid.cubeOf(point.position), point.cell, static_cast<std::uint32_t>(keys.size())});
    const auto rest = [&](const Key& key) {
        const FitPoint& point = points[key.number];
        return std::tie(point.isInner, point.position, point.normal);
    };
    std::sort(keys.begin(), keys.end(), [&](const Key& a, const Key& b) {
        if (a.cube != b.cube) return a.cube < b.cube;
        if (a.cell != b.cell) return a.cell < b.cell;
        return rest(a) < rest(b);
    });
    firstOfCube_.assign(grid.cubeCount(), -1);

    Index normalCount = 0;
    const auto endGroup = [&] {
        if (groups_.empty()) return;
        Group& group = groups_.back();
        group.centre = scaled(group.centre, 1.0 / (group.last - group.first));
        // The mean of unit vectors is short if they differ.
        constexpr double kShort = 0.5;
        const double size = length(group.normal);
        group.normal = normalCount > 0 && size > kShort * normalCount
                           ? scaled(group.normal, 1 / size)
                           : Point3{0, 0, 0};
        normalCount = 0;
    };
    const FitPoint* last = nullptr;
    for (const Key& key : keys) {
        const FitPoint& at = points[key.number];
        const auto number = static_cast<Index>(points_.size());
        if (last == nullptr || groups_.back().cube != key.cube || last->cell != at.cell ||
            last->isInner != at.isInner) {
            endGroup();
            if (firstOfCube_[key.cube] < 0)
                firstOfCube_[key.cube] = static_cast<Index>(groups_.size());
            groups_.push_back(
                {key.cube, at.cell, at.isInner, number, number, at.position, at.position});
            last = nullptr;
        }
        Group& group = groups_.back();
        if (at.normal != std::array<float, 3>{0, 0, 0}) {
            group.normal = sum(group.normal, {at.normal[0], at.normal[1], at.normal[2]});
            ++normalCount;
        }
        const bool isNew = last == nullptr || last->position != at.position;
        last = &at;
        if (!isNew) continue;
        ++group.last;
        for (int axis = 0; axis < 3; ++axis) {
            group.low[axis] = std::min(group.low[axis], at.position[axis]);
            group.high[axis] = std::max(group.high[axis], at.position[axis]);
        }
        group.centre = sum(group.centre, at.position);
        points_.push_back(at.position);
    }
    endGroup();
}

const Point3& PointGroups::farthest(const Group& group, const Point3& direction) const {
    Index best = group.first;
    double most = dot(points_[best], direction);
    for (Index i = group.first + 1; i < group.last; ++i) {
        const double value = dot(points_[i], direction);
        if (value > most) {
            most = value;
            best = i;
        }
    }
    return points_[best];
}

}  // namespace espalier::cages
