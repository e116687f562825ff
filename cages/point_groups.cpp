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

PointGroups::PointGroups(std::span<const FitPoint> points, const CubeGrid& grid) : grid_(grid) {
    struct Keyed {
        Index cube, cell;
        bool isInner;
        Point3 point;
        std::array<float, 3> normal;
        auto operator<=>(const Keyed&) const = default;
    };
    std::vector<Keyed> keyed;
    keyed.reserve(points.size());
    for (const FitPoint& point : points)
        keyed.push_back(
            {grid.cubeOf(point.position), point.cell, point.isInner, point.position, point.normal});
    std::sort(keyed.begin(), keyed.end());
    firstOfCube_.assign(grid.cubeCount(), -1);
    points_.reserve(keyed.size());
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
    const Keyed* last = nullptr;
    for (const Keyed& at : keyed) {
        const auto number = static_cast<Index>(points_.size());
        if (last == nullptr || last->cube != at.cube || last->cell != at.cell ||
            last->isInner != at.isInner) {
            endGroup();
            if (firstOfCube_[at.cube] < 0)
                firstOfCube_[at.cube] = static_cast<Index>(groups_.size());
            groups_.push_back({at.cube, at.cell, at.isInner, number, number, at.point, at.point});
            last = nullptr;
        }
        Group& group = groups_.back();
        if (at.normal != std::array<float, 3>{0, 0, 0}) {
            group.normal = sum(group.normal, {at.normal[0], at.normal[1], at.normal[2]});
            ++normalCount;
        }
        const bool isNew = last == nullptr || last->point != at.point;
        last = &at;
        if (!isNew) continue;
        ++group.last;
        for (int axis = 0; axis < 3; ++axis) {
            group.low[axis] = std::min(group.low[axis], at.point[axis]);
            group.high[axis] = std::max(group.high[axis], at.point[axis]);
        }
        group.centre = sum(group.centre, at.point);
        points_.push_back(at.point);
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
