// SPDX-License-Identifier: Apache-2.0
#include "point_groups.h"

#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
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

PointGroups::PointGroups(std::span<const Point3> points, const CubeGrid& grid,
                         std::span<const Index> cells)
    : grid_(grid) {
    struct Keyed {
        Index cube, cell;
        Point3 point;
        auto operator<=>(const Keyed&) const = default;
    };
    std::vector<Keyed> keyed;
    keyed.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        keyed.push_back({grid.cubeOf(points[i]), cells.empty() ? -1 : cells[i], points[i]});
    std::sort(keyed.begin(), keyed.end());
    keyed.erase(std::unique(keyed.begin(), keyed.end()), keyed.end());
    firstOfCube_.assign(grid.cubeCount(), -1);
    points_.reserve(keyed.size());
    for (const auto& [cube, cell, point] : keyed) {
        const auto number = static_cast<Index>(points_.size());
        if (groups_.empty() || groups_.back().cube != cube || groups_.back().cell != cell) {
            if (firstOfCube_[cube] < 0) firstOfCube_[cube] = static_cast<Index>(groups_.size());
            groups_.push_back({cube, cell, number, number, point, point, {0, 0, 0}});
        }
        Group& group = groups_.back();
        ++group.last;
        for (int axis = 0; axis < 3; ++axis) {
            group.low[axis] = std::min(group.low[axis], point[axis]);
            group.high[axis] = std::max(group.high[axis], point[axis]);
        }
        group.centre = sum(group.centre, point);
        points_.push_back(point);
    }
    for (Group& group : groups_)
        group.centre = scaled(group.centre, 1.0 / (group.last - group.first));
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
