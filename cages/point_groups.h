// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/index.h>
#include <espalier/base/point.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "bins.h"
#include "oriented_box.h"
#include "ranked_bits.h"

namespace espalier::cages {

/// A uniform grid of cubes over a box.
struct CubeGrid {
    Point3 origin = {};
    double size = 1;  ///< edge of a cube
    std::array<Index, 3> counts = {1, 1, 1};

    /// Makes a grid over the box from `low` to `high` and one layer of cubes around it. The cubes
    /// have the edge `size`, or a longer one if there would be more than 30 million of them.
    CubeGrid(const Point3& low, const Point3& high, double size);

    /// Returns the corner opposite to `origin`.
    Point3 end() const;

    Index cubeCount() const { return counts[0] * counts[1] * counts[2]; }

    /// Returns the coordinates of the cube of a point; of the nearest cube for a point outside.
    std::array<Index, 3> coordinatesOf(const Point3& point) const;

    std::array<Index, 3> coordinatesOf(Index cube) const {
        const Index row = cube / counts[0];
        return {cube % counts[0], row % counts[1], row / counts[1]};
    }

    Index cubeAt(const std::array<Index, 3>& coordinates) const {
        return (coordinates[2] * counts[1] + coordinates[1]) * counts[0] + coordinates[0];
    }
    Index cubeOf(const Point3& point) const { return cubeAt(coordinatesOf(point)); }

    /// Calls visit(cube) for the cubes at the distance `ring` (in cubes, largest coordinate) from
    /// `centre`.
    template <class Visit>
    void forEachInRing(const std::array<Index, 3>& centre, Index ring, Visit visit) const {
        forEachRunInRing(
            centre, ring, [](int, Index) { return 0.0; }, [](double) { return true; },
            [&](Index first, Index last) {
                for (Index cube = first; cube <= last; ++cube) visit(cube);
            });
    }

    /// Returns the item nearest to a point, the one with the lowest number if there are several;
    /// none if there is none within `rings` rings of cubes.
    /// \param forEachIn forEachIn(first, last, visit) calls visit(item) for the items in the cubes
    ///        `first` to `last`, which are in one row
    /// \param placeOf placeOf(item) is the place of an item; its cube is the cube of this place
    /// \param accept items without accept(item) do not count
    /// \param guess an item that may be the nearest one. A good guess saves time, and has no other
    ///        effect
    template <class ForEachIn, class PlaceOf, class Accept>
    std::optional<Index> nearest(const Point3& point, Index rings, ForEachIn forEachIn,
                                 PlaceOf placeOf, Accept accept,
                                 std::optional<Index> guess = std::nullopt) const {
        const auto centre = coordinatesOf(point);
        Point3 inside;  // the cube `centre`
        double wall = size;
        for (int axis = 0; axis < 3; ++axis) {
            inside[axis] = point[axis] - origin[axis] - centre[axis] * size;
            wall = std::min({wall, inside[axis], size - inside[axis]});
        }
        // Items may be outside their cubes by rounding.
        const double slack = 1e-9 * size;
        const auto squareTo = [&](int axis, Index coordinate) {
            const Index steps = coordinate - centre[axis];
            if (steps == 0) return 0.0;
            const double way =
                steps > 0 ? steps * size - inside[axis] : inside[axis] - (steps + 1) * size;
            return way > slack ? (way - slack) * (way - slack) : 0.0;
        };
        std::optional<Index> best;
        double least = std::numeric_limits<double>::infinity();
        if (guess && ringBetween(centre, coordinatesOf(placeOf(*guess))) <= rings &&
            accept(*guess)) {
            best = guess;
            const Point3 way = difference(placeOf(*guess), point);
            least = dot(way, way);
        }
        const auto isWanted = [&](double square) { return square <= least; };
        const auto visitRun = [&](Index first, Index last) {
            forEachIn(first, last, [&](Index item) {
                const Point3 way = difference(placeOf(item), point);
                const double distance = dot(way, way);
                if (distance > least || (distance == least && best && item > *best)) return;
                if (!accept(item)) return;
                best = item;
                least = distance;
            });
        };
        const double reachOfBest = (std::sqrt(least) + slack) / size + 1;
        const Index ringsToVisit = reachOfBest < rings ? static_cast<Index>(reachOfBest) : rings;
        // Rows of a few rings take less time than ring after ring.
        if (ringsToVisit <= kFewRings) {
            forEachRunInBox(centre, ringsToVisit, squareTo, isWanted, visitRun);
            return best;
        }
        for (Index ring = 0; ring <= rings; ++ring) {
            const double reach = (ring - 1) * size + wall - slack;
            if (best && reach > 0 && reach * reach > least) break;
            forEachRunInRing(centre, ring, squareTo, isWanted, visitRun);
        }
        return best;
    }

    /// Returns the number of the ring around one cube in which another cube is.
    static Index ringBetween(const std::array<Index, 3>& a, const std::array<Index, 3>& b) {
        return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
    }

private:
    static constexpr Index kFewRings = 3;

    /// As forEachRunInRing(), for the cubes up to the distance `rings`, from the middle outwards.
    /// \param rings at most kFewRings
    template <class SquareTo, class IsWanted, class Visit>
    void forEachRunInBox(const std::array<Index, 3>& centre, Index rings, SquareTo squareTo,
                         IsWanted isWanted, Visit visit) const {
        std::array<Index, 3> low, high;
        std::array<std::array<double, 2 * kFewRings + 1>, 3> squares;  // of low to high
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::max(centre[axis] - rings, 0);
            high[axis] = std::min(centre[axis] + rings, counts[axis] - 1);
            for (Index i = low[axis]; i <= high[axis]; ++i)
                squares[axis][i - low[axis]] = squareTo(axis, i);
        }
        const auto forEachNear = [&](int axis, auto visitPlace) {
            for (Index i = 0; i <= 2 * rings; ++i) {
                const Index coordinate = centre[axis] + (i % 2 == 0 ? i / 2 : -(i + 1) / 2);
                if (coordinate >= low[axis] && coordinate <= high[axis])
                    visitPlace(coordinate, squares[axis][coordinate - low[axis]]);
            }
        };
        forEachNear(2, [&](Index z, double ofZ) {
            if (!isWanted(ofZ)) return;
            forEachNear(1, [&](Index y, double ofY) {
                const double ofRow = ofZ + ofY;
                Index first = low[0], last = high[0];
                while (first <= last && !isWanted(ofRow + squares[0][first - low[0]])) ++first;
                while (first <= last && !isWanted(ofRow + squares[0][last - low[0]])) --last;
                if (first <= last) visit(cubeAt({first, y, z}), cubeAt({last, y, z}));
            });
        });
    }

    /// Calls visit(first, last) for runs of cubes along the first axis. Leaves out cubes for which
    /// isWanted(square) is false.
    /// \param squareTo squareTo(axis, coordinate) is a part of `square` for each axis
    template <class SquareTo, class IsWanted, class Visit>
    void forEachRunInRing(const std::array<Index, 3>& centre, Index ring, SquareTo squareTo,
                          IsWanted isWanted, Visit visit) const {
        std::array<Index, 3> low, high;
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::max(centre[axis] - ring, 0);
            high[axis] = std::min(centre[axis] + ring, counts[axis] - 1);
        }
        for (Index z = low[2]; z <= high[2]; ++z) {
            const double ofZ = squareTo(2, z);
            if (!isWanted(ofZ)) continue;
            const bool isEndZ = z == centre[2] - ring || z == centre[2] + ring;
            for (Index y = low[1]; y <= high[1]; ++y) {
                const double ofRow = ofZ + squareTo(1, y);
                if (!isWanted(ofRow)) continue;
                const auto visitFrom = [&](Index first, Index last) {
                    while (first <= last && !isWanted(ofRow + squareTo(0, first))) ++first;
                    while (first <= last && !isWanted(ofRow + squareTo(0, last))) --last;
                    if (first <= last) visit(cubeAt({first, y, z}), cubeAt({last, y, z}));
                };
                if (isEndZ || y == centre[1] - ring || y == centre[1] + ring) {
                    visitFrom(low[0], high[0]);
                    continue;
                }
                // Only the first and the last cube of the row are in the ring.
                for (const Index x : {centre[0] - ring, centre[0] + ring})
                    if (x == std::clamp(x, low[0], high[0])) visitFrom(x, x);
            }
        }
    }
};

/// A point of a model.
struct FitPoint {
    Point3 position = {};

    /// Direction away from the solid, a unit vector; zero: not known.
    std::array<float, 3> normal = {0, 0, 0};

    /// The cell of the lattice that the point belongs to, if it is known. Cells that are far away
    /// from this cell along the lattice are not fitted to the point, even if they are close to it.
    /// So the cells of parts that are close to each other may overlap before the fit.
    std::optional<Index> cell = {};

    /// True: the point is inside the solid. The boundary is not fitted to the point, but must
    /// contain it.
    bool isInner = false;

    // Not a default <=>: the standard library of WebAssembly's compiler has none for optionals.
    friend bool operator==(const FitPoint&, const FitPoint&) = default;
    friend bool operator<(const FitPoint& a, const FitPoint& b) {
        return std::tie(a.position, a.normal, a.cell, a.isInner) <
               std::tie(b.position, b.normal, b.cell, b.isInner);
    }
};

/// Points of a model, grouped by the cubes of a grid and by the cells that they belong to. Inner
/// points form groups of their own.
class PointGroups {
public:
    struct Group {
        Index cube = 0;
        std::optional<Index> cell = {};
        bool isInner = false;
        Index first = 0, last = 0;  ///< points first to last − 1
        BoundingBox bounds = {};
        Point3 centre = {};    ///< mean of the points
        Point3 normal = {};    ///< a unit vector, or zero if the normals are not known or differ
        OrientedBox box = {};  ///< around the points; its last axis is the normal, if it is known
    };

    /// Sorts and groups points. Their order has no effect.
    PointGroups(std::span<const FitPoint> points, const CubeGrid& grid);

    const CubeGrid& grid() const { return grid_; }
    std::span<const Point3> points() const { return points_; }
    std::span<const Group> groups() const { return groups_; }

    /// Calls visit(group) for the groups in a cube, by ascending cells.
    template <class Visit>
    void forEachInCube(Index cube, Visit visit) const {
        if (!cubes_[cube]) return;
        const std::size_t rank = cubes_.rank(cube);
        for (Index group = firstOfCube_[rank]; group < firstOfCube_[rank + 1]; ++group)
            visit(group);
    }

    /// Returns the point of a group that is farthest along `direction`.
    const Point3& farthest(const Group& group, const Point3& direction) const;

    /// Returns the group whose centre is nearest to a point, among the groups that have points
    /// which are not inner, with acceptCell(cell of the group) and accept(group); none if there is
    /// none within `rings` rings of cubes.
    /// \param visits is increased by the number of groups, lists and blocks of cubes that are
    ///        visited
    /// \param guess a group that may be the nearest one. A good guess saves time and visits, and
    ///        has no other effect
    template <class AcceptCell, class Accept>
    std::optional<Index> nearest(const Point3& point, Index rings, AcceptCell acceptCell,
                                 Accept accept, Offset& visits,
                                 std::optional<Index> guess = std::nullopt) const {
        if (guess && !acceptCell(groups_[*guess].cell)) guess.reset();
        const auto centre = grid_.coordinatesOf(point);
        // A point outside the grid may be in a block beyond the block of its nearest cube.
        const Index ringsOfBlocks = rings / kCubesPerBlock + 2;
        return blocks_.nearest(
            point, ringsOfBlocks,
            [&](Index first, Index last, auto visit) {
                visits += last - first + 1;
                for (const Index list : listsOfBlocks_.itemsIn(first, last)) {
                    ++visits;
                    if (!acceptCell(lists_[list].cell)) continue;
                    for (Index i = lists_[list].first; i < lists_[list].last; ++i) {
                        ++visits;
                        visit(groupsByBlock_[i]);
                    }
                }
            },
            [&](Index group) -> const Point3& { return centres_[group]; },
            [&](Index group) {
                return accept(group) &&
                       CubeGrid::ringBetween(grid_.coordinatesOf(groups_[group].cube), centre) <=
                           rings;
            },
            guess);
    }

private:
    void makeBlocks();

    CubeGrid grid_;
    std::vector<Point3> points_;
    std::vector<Group> groups_;
    RankedBits cubes_;                ///< the cubes with points
    std::vector<Index> firstOfCube_;  ///< the first group of each of them; the number of groups

    // Lists of the groups in each block of cubes. Groups that nearest() may return can be far away,
    // behind many empty cubes and many groups that it may not return. So each block has one list
    // for each cell: a whole list is left out at once.
    struct GroupList {
        std::optional<Index> cell;
        Index first, last;  ///< groupsByBlock_[first] to [last − 1]
    };
    static constexpr Index kCubesPerBlock = 4;  ///< along each axis
    CubeGrid blocks_;
    Bins listsOfBlocks_;
    std::vector<GroupList> lists_;
    std::vector<Index> groupsByBlock_;
    std::vector<Point3> centres_;  ///< the centres of the groups: nearest() reads little else
};

}  // namespace espalier::cages
