// SPDX-License-Identifier: Apache-2.0
#include "point_groups.h"

#include <espalier/base/cancellable_sort.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
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

Point3 CubeGrid::end() const {
    Point3 end;
    for (int axis = 0; axis < 3; ++axis) end[axis] = origin[axis] + counts[axis] * size;
    return end;
}

std::array<Index, 3> CubeGrid::coordinatesOf(const Point3& point) const {
    std::array<Index, 3> result;
    for (int axis = 0; axis < 3; ++axis) {
        const double place = (point[axis] - origin[axis]) / size;
        result[axis] = static_cast<Index>(std::clamp(place, 0.0, counts[axis] - 1.0));
    }
    return result;
}

PointGroups::PointGroups(std::span<const FitPoint> points, const CubeGrid& grid)
    : grid_(grid),
      cubes_(grid.cubeCount()),
      blocks_(grid.origin, grid.end(), kCubesPerBlock * grid.size) {
    // Numbers are sorted instead of the points, which take twelve times the memory: first by cubes.
    // Until all groups are made, firstOfCube_ holds the end of the numbers of each cube.
    std::vector<std::uint32_t> numbers(points.size());
    const auto forEachPoint = [&](auto visit) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            checkCancelledEvery(i, 16);
            visit(i, grid.cubeOf(points[i].position));
        }
    };
    forEachPoint([&](std::size_t, Index cube) { cubes_.insert(cube); });
    cubes_.makeRanks();
    firstOfCube_.assign(cubes_.count() + 1, 0);
    forEachPoint([&](std::size_t, Index cube) { ++firstOfCube_[cubes_.rank(cube) + 1]; });
    std::partial_sum(firstOfCube_.begin(), firstOfCube_.end(), firstOfCube_.begin());
    forEachPoint([&](std::size_t i, Index cube) {
        numbers[firstOfCube_[cubes_.rank(cube)]++] = static_cast<std::uint32_t>(i);
    });

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
        // Points of a smooth surface are in a thin box.
        const Point3& n = group.normal;
        const Point3 along = std::abs(n[0]) < 0.5 ? cross(n, {1, 0, 0}) : cross(n, {0, 1, 0});
        group.box = {axesAround(n, along),
                     std::span(points_).subspan(group.first, group.last - group.first)};
        normalCount = 0;
    };
    const FitPoint* last = nullptr;
    const auto add = [&](Index cube, const FitPoint& at) {
        const auto number = static_cast<Index>(points_.size());
        if (last == nullptr || groups_.back().cube != cube || last->cell != at.cell ||
            last->isInner != at.isInner) {
            endGroup();
            groups_.push_back({.cube = cube,
                               .cell = at.cell,
                               .isInner = at.isInner,
                               .first = number,
                               .last = number});
            last = nullptr;
        }
        Group& group = groups_.back();
        if (at.normal != std::array<float, 3>{0, 0, 0}) {
            group.normal = sum(group.normal, {at.normal[0], at.normal[1], at.normal[2]});
            ++normalCount;
        }
        const bool isNew = last == nullptr || last->position != at.position;
        last = &at;
        if (!isNew) return;
        ++group.last;
        group.bounds.include(at.position);
        group.centre = sum(group.centre, at.position);
        points_.push_back(at.position);
    };
    const auto isBefore = [&](std::uint32_t a, std::uint32_t b) {
        const auto key = [&](std::uint32_t number) {
            const FitPoint& point = points[number];
            return std::tie(point.cell, point.isInner, point.position, point.normal);
        };
        return key(a) < key(b);
    };
    auto begin = numbers.begin();
    std::size_t rank = 0;
    cubes_.forEach([&](std::size_t cube) {
        checkCancelledEvery(rank, 8);
        Index& first = firstOfCube_[rank++];
        const auto end = numbers.begin() + first;
        first = static_cast<Index>(groups_.size());
        sortCancellably(begin, end, isBefore);
        for (; begin != end; ++begin) add(static_cast<Index>(cube), points[*begin]);
    });
    firstOfCube_.back() = static_cast<Index>(groups_.size());
    endGroup();

    makeBlocks();
}

void PointGroups::makeBlocks() {
    std::vector<Index> blockOf(groups_.size());
    for (std::size_t group = 0; group < groups_.size(); ++group) {
        centres_.push_back(groups_[group].centre);
        blockOf[group] = blocks_.cubeOf(centres_.back());
        if (!groups_[group].isInner) groupsByBlock_.push_back(static_cast<Index>(group));
    }
    const auto key = [&](Index group) {
        return std::tuple(blockOf[group], groups_[group].cell, group);
    };
    sortCancellably(groupsByBlock_.begin(), groupsByBlock_.end(),
                    [&](Index a, Index b) { return key(a) < key(b); });
    std::vector<Bins::Entry> blockOfList;
    for (const Index group : groupsByBlock_) {
        const std::optional<Index>& cell = groups_[group].cell;
        if (blockOfList.empty() || blockOfList.back().bin != blockOf[group] ||
            lists_.back().cell != cell) {
            const Index first = lists_.empty() ? 0 : lists_.back().last;
            blockOfList.push_back({blockOf[group], static_cast<Index>(lists_.size())});
            lists_.push_back({cell, first, first});
        }
        ++lists_.back().last;
    }
    listsOfBlocks_ = Bins(blocks_.cubeCount(), blockOfList);
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
