// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>

#include <array>
#include <span>
#include <vector>

namespace espalier::cages {

/// A uniform grid of cubes over a box.
struct CubeGrid {
    Point3 origin = {};
    double size = 1;  ///< edge of a cube
    std::array<Index, 3> counts = {1, 1, 1};

    /// Makes a grid over the box from `low` to `high` and one layer of cubes around it. The cubes
    /// have the edge `size`, or a longer one if there would be more than 30 million of them.
    CubeGrid(const Point3& low, const Point3& high, double size);

    Index cubeCount() const { return counts[0] * counts[1] * counts[2]; }

    /// Returns the coordinates of the cube of a point; of the nearest cube for a point outside.
    std::array<Index, 3> coordinatesOf(const Point3& point) const;

    Index cubeAt(const std::array<Index, 3>& coordinates) const {
        return (coordinates[2] * counts[1] + coordinates[1]) * counts[0] + coordinates[0];
    }
    Index cubeOf(const Point3& point) const { return cubeAt(coordinatesOf(point)); }

    /// Calls visit(cube) for the cubes at the distance `ring` (in cubes, largest coordinate) from
    /// `centre`.
    template <class Visit>
    void forEachInRing(const std::array<Index, 3>& centre, Index ring, Visit visit) const {
        std::array<Index, 3> low, high;
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::max(centre[axis] - ring, 0);
            high[axis] = std::min(centre[axis] + ring, counts[axis] - 1);
        }
        for (Index z = low[2]; z <= high[2]; ++z) {
            const bool isEndZ = z == centre[2] - ring || z == centre[2] + ring;
            for (Index y = low[1]; y <= high[1]; ++y) {
                const bool isEnd = isEndZ || y == centre[1] - ring || y == centre[1] + ring;
                if (isEnd) {
                    for (Index x = low[0]; x <= high[0]; ++x) visit(cubeAt({x, y, z}));
                } else {
                    if (centre[0] - ring >= 0) visit(cubeAt({centre[0] - ring, y, z}));
                    if (centre[0] + ring < counts[0]) visit(cubeAt({centre[0] + ring, y, z}));
                }
            }
        }
    }
};

/// Points of a model, grouped by the cubes of a grid.
class PointGroups {
public:
    struct Group {
        Index cube = 0;
        Index first = 0, last = 0;  ///< points first to last − 1
        Point3 low = {}, high = {};
        Point3 centre = {};  ///< mean of the points
    };

    /// Sorts and groups points. The order of `points` has no effect.
    PointGroups(std::span<const Point3> points, const CubeGrid& grid);

    const CubeGrid& grid() const { return grid_; }
    std::span<const Point3> points() const { return points_; }
    std::span<const Group> groups() const { return groups_; }

    /// Returns the group of a cube; −1 if the cube is empty.
    Index inCube(Index cube) const { return groupOfCube_[cube]; }

    /// Returns the point of a group that is farthest along `direction`.
    const Point3& farthest(const Group& group, const Point3& direction) const;

    /// Returns the group whose centre is nearest to a point; −1 if none is within `rings` rings of
    /// cubes.
    Index nearest(const Point3& point, Index rings) const;

private:
    CubeGrid grid_;
    std::vector<Point3> points_;
    std::vector<Group> groups_;
    std::vector<Index> groupOfCube_;  ///< −1 for an empty cube
};

}  // namespace espalier::cages
