// SPDX-License-Identifier: Apache-2.0
#include "model_voxels.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/cancellable_sort.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "left_side.h"
#include "voxel_set.h"

namespace espalier::cages {
namespace {

CubeGrid gridAround(std::span<const Point3> points, double size, double padding,
                    const MirrorPlanes& mirrors) {
    Point3 low = points.front(), high = low;
    for (const Point3& point : points)
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], point[axis]);
            high[axis] = std::max(high[axis], point[axis]);
        }
    // Odd parts of a voxel, so that columns of centres do not pass through the corners of a model
    // with round coordinates.
    Point3 pad = {padding, padding, padding}, odd = {0.2127, 0.3391, 0.1459};
    for (int axis = 0; axis < 3; ++axis) {
        const std::optional<double>& plane = mirrors[axis];
        if (!plane) continue;
        const double half = std::max(*plane - low[axis], high[axis] - *plane);
        low[axis] = *plane - half;
        high[axis] = *plane + half;
        odd[axis] = 0;
    }
    CubeGrid grid(difference(difference(low, pad), scaled(odd, size)), sum(high, pad), size);
    for (int axis = 0; axis < 3; ++axis) {
        if (!mirrors[axis]) continue;
        grid.counts[axis] += grid.counts[axis] % 2;
        grid.origin[axis] = *mirrors[axis] - grid.counts[axis] / 2 * grid.size;
    }
    return grid;
}

/// Returns bits in the opposite order.
std::uint64_t reversed(std::uint64_t bits) {
    std::uint64_t result = 0;
    for (int i = 0; i < 64; ++i, bits >>= 1) result = result << 1 | (bits & 1);
    return result;
}

/// Returns true if a triangle meets a cube, by the separating axes of the two. The cube is a little
/// larger than its size, by more than rounding.
bool meetsCube(const std::array<Point3, 3>& triangle, const Point3& centre, double size) {
    const double half = size / 2 * (1 + 1e-9);
    std::array<Point3, 3> corners, ways;
    for (int i = 0; i < 3; ++i) corners[i] = difference(triangle[i], centre);
    for (int i = 0; i < 3; ++i) ways[i] = difference(corners[(i + 1) % 3], corners[i]);
    const auto isApart = [&](const Point3& axis) {
        const double reach = half * (std::abs(axis[0]) + std::abs(axis[1]) + std::abs(axis[2]));
        const double a = dot(axis, corners[0]), b = dot(axis, corners[1]),
                     c = dot(axis, corners[2]);
        return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
    };
    for (int axis = 0; axis < 3; ++axis) {
        const double a = corners[0][axis], b = corners[1][axis], c = corners[2][axis];
        if (std::min({a, b, c}) > half || std::max({a, b, c}) < -half) return false;
    }
    if (isApart(cross(ways[0], ways[1]))) return false;
    for (const Point3& way : ways)
        if (isApart({0, -way[2], way[1]}) || isApart({way[2], 0, -way[0]}) ||
            isApart({-way[1], way[0], 0}))
            return false;
    return true;
}

/// Returns the box around the part of a triangle with coordinates `from` to `to` along an axis; an
/// empty box if there is no such part.
BoundingBox partBetween(const std::array<Point3, 3>& triangle, int axis, double from, double to) {
    BoundingBox box;
    for (int i = 0; i < 3; ++i) {
        const Point3 &a = triangle[i], &b = triangle[(i + 1) % 3];
        if (a[axis] >= from && a[axis] <= to) box.include(a);
        for (const double plane : {from, to})
            if ((a[axis] < plane) != (b[axis] < plane))
                box.include(between(a, b, (plane - a[axis]) / (b[axis] - a[axis])));
    }
    return box;
}

/// Finds the cubes of a grid that a triangle may meet: row by row of cubes, and in each row column
/// by column.
class TriangleColumns {
public:
    /// \param triangle in cubes, from the origin of the grid
    explicit TriangleColumns(const std::array<Point3, 3>& triangle) : triangle_(triangle) {
        const Point3 normal =
            cross(difference(triangle[1], triangle[0]), difference(triangle[2], triangle[0]));
        const auto largest = [](const Point3& v) {
            int axis = 0;
            for (const int other : {1, 2})
                if (std::abs(v[other]) > std::abs(v[axis])) axis = other;
            return axis;
        };
        BoundingBox box;
        for (const Point3& corner : triangle) box.include(corner);
        const Point3 sides = box.size();
        const double extent = sides[largest(sides)];
        const int steepest = largest(normal);
        // The normal of a needle is rounded too much. It is followed along its longest extent,
        // where each row has a few cubes of it.
        constexpr double kHeightError = 1e-3, kRounding = 1e-15;
        const bool hasPlane =
            kRounding * extent * extent * extent < kHeightError * std::abs(normal[steepest]);
        heights = hasPlane ? steepest : largest(sides) == 2 ? 1 : 2;
        // Neighbours along the first axis are neighbours in memory.
        columns = heights == 0 ? 1 : 0;
        rows = 3 - heights - columns;
        if (!hasPlane) {
            if (largest(sides) == columns) std::swap(rows, columns);
            return;
        }
        slopes_ = {-normal[columns] / normal[heights], -normal[rows] / normal[heights]};
        half_ = (std::abs(slopes_[0]) + std::abs(slopes_[1])) / 2 + kMore;
    }

    int rows, columns, heights;  ///< axes

    /// Calls visit(column, low, high) for the columns in a row: the triangle is between the heights
    /// `low` and `high` there, in cubes.
    /// \param first, last columns that count
    template <class Visit>
    void forEachColumn(Index row, Index first, Index last, Visit visit) const {
        const BoundingBox part = partBetween(triangle_, rows, row - kMore, row + 1 + kMore);
        if (part.min[rows] > part.max[rows]) return;
        first = std::max(first, static_cast<Index>(std::floor(part.min[columns] - kMore)));
        last = std::min(last, static_cast<Index>(std::floor(part.max[columns] + kMore)));
        const double low = part.min[heights] - kMore, high = part.max[heights] + kMore;
        const Point3& on = triangle_[0];
        const double ofRow = on[heights] + slopes_[1] * (row + 0.5 - on[rows]);
        for (Index column = first; column <= last; ++column) {
            const double middle = ofRow + slopes_[0] * (column + 0.5 - on[columns]);
            visit(column, std::max(low, middle - half_), std::min(high, middle + half_));
        }
    }

private:
    static constexpr double kMore = 2e-3;  ///< more than all rounding, in cubes

    const std::array<Point3, 3>& triangle_;
    std::array<double, 2> slopes_ = {0, 0};  ///< slopes of the heights along and across rows
    double half_ = std::numeric_limits<double>::infinity();  ///< half the range of heights
};

/// Marks the cubes that a triangle meets.
void markTriangle(const CubeGrid& grid, const std::array<Point3, 3>& triangle, RankedBits& marks) {
    BoundingBox box;
    for (const Point3& corner : triangle) box.include(corner);
    const double around = 1e-9 * grid.size;
    const auto from = grid.coordinatesOf(difference(box.min, {around, around, around}));
    const auto to = grid.coordinatesOf(sum(box.max, {around, around, around}));
    if (from == to) {
        marks.insert(grid.cubeAt(from));
        return;
    }
    std::array<Point3, 3> inCubes;
    for (std::size_t i = 0; i < 3; ++i)
        inCubes[i] = scaled(difference(triangle[i], grid.origin), 1 / grid.size);
    const TriangleColumns in(inCubes);
    const std::array<Offset, 3> strides = {1, grid.counts[0],
                                           Offset{grid.counts[0]} * grid.counts[1]};
    for (Index row = from[in.rows]; row <= to[in.rows]; ++row)
        in.forEachColumn(
            row, from[in.columns], to[in.columns], [&](Index column, double low, double high) {
                const auto first = static_cast<Index>(std::max<double>(low, from[in.heights]));
                const auto last = static_cast<Index>(std::min<double>(high, to[in.heights]));
                const Offset ofColumn = row * strides[in.rows] + column * strides[in.columns];
                for (Index height = first; height <= last; ++height) {
                    const Offset number = ofColumn + height * strides[in.heights];
                    if (marks[number]) continue;
                    std::array<Index, 3> cube;
                    cube[in.rows] = row;
                    cube[in.columns] = column;
                    cube[in.heights] = height;
                    Point3 centre;
                    for (int axis = 0; axis < 3; ++axis)
                        centre[axis] = grid.origin[axis] + (cube[axis] + 0.5) * grid.size;
                    if (meetsCube(triangle, centre, grid.size)) marks.insert(number);
                }
            });
}

void markTriangles(const CubeGrid& grid, std::span<const Triangle> triangles,
                   std::span<const Point3> points, RankedBits& marks) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        checkCancelledEvery(i, 6);
        const Triangle& t = triangles[i];
        markTriangle(grid, {points[t[0]], points[t[1]], points[t[2]]}, marks);
    }
}

/// A ray from below passes through a triangle in a column of cubes: all centres up to `height`
/// are below the triangle.
struct Crossing {
    Index column = 0, height = 0;
    Index piece = 0;
    int sign = 0;
    friend auto operator<=>(const Crossing&, const Crossing&) = default;
};

void addCrossings(const CubeGrid& grid, const std::array<Point3, 3>& triangle, Index piece,
                  std::vector<Crossing>& crossings) {
    const auto& [a, b, c] = triangle;
    std::array<Index, 2> from, to;
    for (int axis = 0; axis < 2; ++axis) {
        const double low = std::min({a[axis], b[axis], c[axis]});
        const double high = std::max({a[axis], b[axis], c[axis]});
        const auto place = [&](double value) {
            return std::clamp((value - grid.origin[axis]) / grid.size - 0.5, 0.0,
                              grid.counts[axis] - 1.0);
        };
        from[axis] = static_cast<Index>(std::floor(place(low)));
        to[axis] = static_cast<Index>(std::ceil(place(high)));
    }
    const Point3 normal = cross(difference(b, a), difference(c, a));
    for (Index y = from[1]; y <= to[1]; ++y)
        for (Index x = from[0]; x <= to[0]; ++x) {
            const Point3 p = {grid.origin[0] + (x + 0.5) * grid.size,
                              grid.origin[1] + (y + 0.5) * grid.size, 0};
            const bool first = isLeft(a, b, p);
            if (isLeft(b, c, p) != first || isLeft(c, a, p) != first) continue;
            double z = std::max({a[2], b[2], c[2]});
            if (normal[2] != 0) {
                const double plane =
                    a[2] - (normal[0] * (p[0] - a[0]) + normal[1] * (p[1] - a[1])) / normal[2];
                z = std::clamp(plane, std::min({a[2], b[2], c[2]}), z);
            }
            const double height = std::ceil((z - grid.origin[2]) / grid.size - 0.5) - 1;
            if (height < 0) continue;
            crossings.push_back({y * grid.counts[0] + x,
                                 static_cast<Index>(std::min(height, grid.counts[2] - 1.0)), piece,
                                 first ? 1 : -1});
        }
}

}  // namespace

ModelVoxels::ModelVoxels(const ModelSurface& surface, std::span<const Point3> points,
                         const VoxelOptions& options)
    : grid_(
          gridAround(points, options.size, std::max(options.around, options.gap), options.mirrors)),
      used_(grid_.cubeCount()),
      signs_(surface.closedPieces().size(), 1) {
    markTriangles(grid_, surface.triangles(), points, used_);
    if (!options.isShell) {
        markClosed(surface, points);
        if (!surface.openTriangles().empty()) markEnclosed(surface, points, options.gap);
    }
    for (int axis = 0; axis < 3; ++axis)
        if (options.mirrors[axis]) addMirrored(used_, axis);
    if (!options.isShell) solid_ = used_;
    if (options.around > 0)
        VoxelSet(grid_.counts, used_).within(options.around / grid_.size).forEach([&](Index voxel) {
            used_.insert(voxel);
        });
    used_.makeRanks();
}

bool ModelVoxels::isInner(const Point3& point) const {
    if (solid_.size() == 0) return false;
    const auto place = grid_.coordinatesOf(point);
    for (Index z = place[2] - 2; z <= place[2] + 2; ++z)
        for (Index y = place[1] - 2; y <= place[1] + 2; ++y)
            for (Index x = place[0] - 2; x <= place[0] + 2; ++x) {
                const bool isInGrid = x >= 0 && y >= 0 && z >= 0 && x < grid_.counts[0] &&
                                      y < grid_.counts[1] && z < grid_.counts[2];
                if (!isInGrid || !solid_[grid_.cubeAt({x, y, z})]) return false;
            }
    return true;
}

/// Adds the mirror images of voxels, row by row.
void ModelVoxels::addMirrored(RankedBits& voxels, int axis) const {
    const auto& n = grid_.counts;
    const RankedBits before = voxels;
    std::array<Index, 3> place = {0, 0, 0};
    for (place[2] = 0; place[2] < n[2]; ++place[2])
        for (place[1] = 0; place[1] < n[1]; ++place[1]) {
            std::array<Index, 3> image = place;
            if (axis > 0) image[axis] = n[axis] - 1 - place[axis];
            const std::size_t from = grid_.cubeAt(place), to = grid_.cubeAt(image);
            if (!before.hasAny(from, from + n[0])) continue;
            for (Index x = 0; x < n[0]; x += 64) {
                const Index count = std::min(64, n[0] - x);
                const std::uint64_t bits =
                    before.from(from + x) & ~std::uint64_t{0} >> (64 - count);
                if (bits == 0) continue;
                if (axis > 0)
                    voxels.insertBits(to + x, bits);
                else
                    voxels.insertBits(to + n[0] - x - count, reversed(bits) >> (64 - count));
            }
        }
}

void ModelVoxels::markClosed(const ModelSurface& surface, std::span<const Point3> points) {
    const auto& pieces = surface.closedPieces();
    std::vector<Crossing> crossings;
    for (std::size_t piece = 0; piece < pieces.size(); ++piece) {
        const std::vector<Triangle>& triangles = pieces[piece].triangles;
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            checkCancelledEvery(i, 6);
            const Triangle& t = triangles[i];
            addCrossings(grid_, {points[t[0]], points[t[1]], points[t[2]]},
                         static_cast<Index>(piece), crossings);
        }
    }
    sortCancellably(crossings.begin(), crossings.end());
    const Index plane = grid_.counts[0] * grid_.counts[1];
    // A piece that is wound inwards is a cavity if most of it lies in pieces that are wound
    // outwards.
    const auto isInOthers = [&](const Point3& point) {
        const Index cube = grid_.cubeOf(point);
        const Crossing first{cube % plane, cube / plane, 0, std::numeric_limits<int>::min()};
        int winding = 0;
        for (auto at = std::lower_bound(crossings.begin(), crossings.end(), first);
             at != crossings.end() && at->column == first.column; ++at)
            if (pieces[at->piece].winding >= 0) winding += at->sign;
        return winding != 0;
    };
    for (std::size_t piece = 0; piece < pieces.size(); ++piece) {
        if (pieces[piece].winding >= 0) continue;
        Offset count = 0, total = 0;
        for (const Triangle& t : pieces[piece].triangles)
            for (const Index corner : t) {
                ++total;
                count += isInOthers(points[corner]) ? 1 : 0;
            }
        if (4 * count > 3 * total) signs_[piece] = -1;
    }
    for (std::size_t last = crossings.size(); last > 0;) {
        const Index column = crossings[last - 1].column;
        int winding = 0;
        while (last > 0 && crossings[last - 1].column == column) {
            const Crossing& above = crossings[--last];
            winding += signs_[above.piece] * above.sign;
            if (winding == 0) continue;
            const Index end =
                last > 0 && crossings[last - 1].column == column ? crossings[last - 1].height : -1;
            for (Index z = above.height; z > end; --z) used_.insert(z * plane + column);
        }
    }
}

void ModelVoxels::markEnclosed(const ModelSurface& surface, std::span<const Point3> points,
                               double gap) {
    RankedBits walls(used_.size());
    markTriangles(grid_, surface.openTriangles(), points, walls);
    // The voxels of the border are free: the grid is wider than the model by the gap.
    const double radius = gap / 2 / grid_.size;
    const VoxelSet free = VoxelSet(grid_.counts, walls).within(radius).complement();
    free.connectedWithFirst().within(radius).complement().forEach(
        [&](Index voxel) { used_.insert(voxel); });
}

}  // namespace espalier::cages
