// SPDX-License-Identifier: Apache-2.0
#include "cage_surface.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/far/complex_builder.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "bins.h"
#include "left_side.h"
#include "oriented_box.h"
#include "ranked_bits.h"

namespace espalier::cages {
namespace {

/// Renames the columns of a table. The new names must ascend.
stencils::StencilTable<double> withColumns(const stencils::StencilTable<double>& table,
                                           std::span<const Index> names, Index columnCount) {
    Array<Offset> offsets(table.offsets().begin(), table.offsets().end());
    Array<Index> columns;
    columns.reserve(table.columns().size());
    for (const Index column : table.columns()) columns.push_back(names[column]);
    Array<double> weights(table.weights().begin(), table.weights().end());
    return {stencils::Trusted(), columnCount, std::move(offsets), std::move(columns),
            std::move(weights)};
}

/// Returns some rows of a table.
stencils::StencilTable<double> rowsOf(const stencils::StencilTable<double>& table,
                                      std::span<const Index> rows) {
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    for (const Index row : rows) {
        for (const Index column : table.columns(row)) columns.push_back(column);
        for (const double weight : table.weights(row)) weights.push_back(weight);
        offsets.push_back(static_cast<Offset>(columns.size()));
    }
    return {stencils::Trusted(), table.columnCount(), std::move(offsets), std::move(columns),
            std::move(weights)};
}

/// Returns the table of the means of four rows each.
stencils::StencilTable<double> centresOf(const stencils::StencilTable<double>& vertices,
                                         const far::CellComplex& mesh) {
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    std::vector<std::pair<Index, double>> row;
    for (Index face = 0; face < mesh.count(2); ++face) {
        checkCancelledEvery(face, 12);
        row.clear();
        const auto corners = mesh.relation(2, 0)[face];
        for (const Index vertex : corners)
            for (std::size_t i = 0; i < vertices.columns(vertex).size(); ++i)
                row.emplace_back(vertices.columns(vertex)[i],
                                 vertices.weights(vertex)[i] / static_cast<double>(corners.size()));
        std::stable_sort(row.begin(), row.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        for (std::size_t i = 0; i < row.size();) {
            const Index column = row[i].first;
            double total = 0;
            for (; i < row.size() && row[i].first == column; ++i) total += row[i].second;
            columns.push_back(column);
            weights.push_back(total);
        }
        offsets.push_back(static_cast<Offset>(columns.size()));
    }
    return {stencils::Trusted(), vertices.columnCount(), std::move(offsets), std::move(columns),
            std::move(weights)};
}

}  // namespace

CageSurface::CageSurface(const far::TopologyRefiner& lattice) {
    const far::CellComplex& complex = lattice.level(0).complex;
    const far::Strata& strata = lattice.level(0).strata;
    if (strata.hasSemiSharp())
        throw Error("fitting a cage: the lattice has semi-sharp marks; expected sharp ones only");
    std::vector<std::vector<Index>> loops;
    std::vector<Index> names, cells;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const auto faces = complex.relation(3, 2)[cell];
        for (std::size_t i = 0; i < faces.size(); ++i) {
            if (complex.relation(2, 3)[faces[i]].size() != 1) continue;
            const auto loop = complex.relation(2, 0)[faces[i]];
            loops.emplace_back(loop.begin(), loop.end());
            if (complex.boundary(3).signs(cell)[i] < 0)
                std::reverse(loops.back().begin(), loops.back().end());
            cells.push_back(cell);
            names.insert(names.end(), loop.begin(), loop.end());
        }
    }
    sortUnique(names);
    for (auto& loop : loops)
        for (Index& vertex : loop) vertex = indexIn(names, vertex);
    far::RefinerOptions options;
    far::CellComplex mesh = far::buildMesh(static_cast<Index>(names.size()), loops);
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        if (strata.of({1, edge}) != 1 || strata.smoothStratum({1, edge}) != 2) continue;
        const auto ends = complex.relation(1, 0)[edge];
        options.marks.edges.push_back({{indexIn(names, ends[0]), indexIn(names, ends[1])}});
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        const auto vertex = static_cast<Index>(i);
        if (strata.of({0, names[i]}) == 0)
            options.marks.vertices.push_back({vertex});
        else if (mesh.relation(0, 1)[vertex].size() < 3)
            throw Error(concat("vertex ", names[i], " of the lattice has ",
                               mesh.relation(0, 1)[vertex].size(),
                               " edges on the boundary; expected at least 3 at a smooth vertex"));
    }
    far::TopologyRefiner refiner(std::move(mesh), options);
    refiner.refineUniform(kLevel + 1);
    const auto coarse =
        withColumns(stencils::buildStencils(refiner, kLevel - 1), names, complex.count(0));
    coarseCentres_ = centresOf(coarse, refiner.level(kLevel - 1).complex);
    fineTable_ = stencils::multiply(stencils::buildLevelTable(refiner, kLevel), coarse);
    fineCentres_ = centresOf(fineTable_, refiner.level(kLevel).complex);

    for (Index face = 0; face < refiner.level(kLevel).complex.count(2); ++face)
        coarseOfFine_.push_back(refiner.refinement(kLevel).parentOf({2, face}).upper.index);
    const auto cellsOf = [&](int level) {
        std::vector<Index> result;
        for (Index face = 0; face < refiner.level(level).complex.count(2); ++face) {
            Index base = face;
            for (int k = level; k > 0; --k)
                base = refiner.refinement(k).parentOf({2, base}).upper.index;
            result.push_back(cells[base]);
        }
        return result;
    };
    cellOfCoarse_ = cellsOf(kLevel - 1);
    finestTable_ = stencils::buildLevelTable(refiner, kLevel + 1);
    fineFaces_.emplace(refiner.level(kLevel), cellsOf(kLevel));
    finestFaces_.emplace(refiner.level(kLevel + 1), cellsOf(kLevel + 1));
    // A face has four children, which follow each other.
    irregularHulls_ = far::buildRows<Index>(
        refiner.level(kLevel).complex.count(2), [&](Index face, std::vector<Index>& out) {
            if (fineFaces_->isPatch[face] != 0) return;
            std::vector<Index> hull;
            for (Index child = 4 * face; child < 4 * face + 4; ++child) {
                const auto ofChild = finestFaces_->hull(child);
                hull.insert(hull.end(), ofChild.begin(), ofChild.end());
            }
            sortUnique(hull);
            out.insert(out.end(), hull.begin(), hull.end());
        });
    std::vector<Index> rows(irregularHulls_.values.begin(), irregularHulls_.values.end());
    sortUnique(rows);
    irregularTable_ = rowsOf(finestTable_, rows);
    for (Index& vertex : irregularHulls_.values) vertex = indexIn(rows, vertex);
}

std::vector<Point3> CageSurface::fineVertices(std::span<const Point3> positions) const {
    return stencils::applyLevelTable(fineTable_, positions);
}

std::vector<Point3> CageSurface::finestVertices(std::span<const Point3> fineVertices) const {
    return stencils::applyLevelTable(finestTable_, fineVertices);
}

std::vector<Point3> CageSurface::irregularVertices(std::span<const Point3> fineVertices) const {
    return stencils::applyLevelTable(irregularTable_, fineVertices);
}

namespace {

/// Returns a box around the hull of a face. The low side along its last axis is the inner one.
/// \param hull points whose convex hull counts
OrientedBox boxAround(std::span<const Point3> hull, const std::array<Index, 4>& face,
                      std::span<const Point3> vertices) {
    const Point3 along = difference(vertices[face[2]], vertices[face[0]]);
    return {axesAround(cross(along, difference(vertices[face[3]], vertices[face[1]])), along),
            hull};
}

/// Counts how often triangles wind around points.
class Winding {
public:
    /// \param used the cubes of the grid that hold points
    Winding(std::span<const std::array<Index, 4>> faces, std::span<const Point3> vertices,
            const CubeGrid& grid, const RankedBits& used)
        : faces_(faces),
          vertices_(vertices),
          grid_(grid),
          bounds_(faces.size()),
          columns_(grid.counts[0] * grid.counts[1], columnsOfFaces(used)) {}

    /// Follows the ray from `point` upwards. The point must not be on a triangle.
    int turnsAround(const Point3& point) const {
        const auto place = grid_.coordinatesOf(point);
        int count = 0;
        for (const Index face : columns_[place[1] * grid_.counts[0] + place[0]]) {
            const BoundingBox& box = bounds_[face];
            if (point[0] < box.min[0] || point[0] > box.max[0] || point[1] < box.min[1] ||
                point[1] > box.max[1] || point[2] > box.max[2])
                continue;
            const auto& f = faces_[face];
            count += crossing(vertices_[f[0]], vertices_[f[1]], vertices_[f[2]], point);
            count += crossing(vertices_[f[0]], vertices_[f[2]], vertices_[f[3]], point);
        }
        return count;
    }

private:
    /// Measures the faces. Returns the columns of cubes with points that they reach into.
    std::vector<Bins::Entry> columnsOfFaces(const RankedBits& used) {
        const Index width = grid_.counts[0], columnCount = width * grid_.counts[1];
        std::vector<char> isUsedColumn(columnCount, 0);
        used.forEach([&](std::size_t cube) { isUsedColumn[cube % isUsedColumn.size()] = 1; });
        std::vector<Bins::Entry> entries;
        for (Index face = 0; face < std::ssize(faces_); ++face) {
            for (const Index vertex : faces_[face]) bounds_[face].include(vertices_[vertex]);
            const auto from = grid_.coordinatesOf(bounds_[face].min);
            const auto to = grid_.coordinatesOf(bounds_[face].max);
            for (Index y = from[1]; y <= to[1]; ++y)
                for (Index x = from[0]; x <= to[0]; ++x)
                    if (isUsedColumn[y * width + x] != 0) entries.push_back({y * width + x, face});
        }
        return entries;
    }

    static int crossing(const Point3& a, const Point3& b, const Point3& c, const Point3& p) {
        const bool first = isLeft(a, b, p);
        if (isLeft(b, c, p) != first || isLeft(c, a, p) != first) return 0;
        const Point3 normal = cross(difference(b, a), difference(c, a));
        const double height = dot(normal, difference(p, a));  // × the sign of normal[2]
        return first ? (height < 0 ? 1 : 0) : (height > 0 ? -1 : 0);
    }

    std::span<const std::array<Index, 4>> faces_;
    std::span<const Point3> vertices_;
    const CubeGrid& grid_;
    std::vector<BoundingBox> bounds_;  ///< the box of each face
    Bins columns_;
};

/// A box is put around each face. It contains the hull of the face, which holds all further levels;
/// its four corners; or its corners and its limit.
enum class Enclosed { Hull, Corners, Limit };

/// Groups of points that are not proved to be inside, and the faces that may be near them.
struct NearGroups {
    std::vector<Uncovered> groups;  ///< ascending
    std::vector<Index> faces;       ///< ascending
};

/// Returns the groups in `tried` that have a point within `margin` of a box around a face in
/// `near`, or a point around which the triangles of all faces do not wind once.
/// \param namesOnly only the names of the groups are wanted; faster
NearGroups findNear(const CageSurface::Faces& surface, Enclosed enclosed,
                    std::span<const Index> near, std::span<const Point3> vertices,
                    const PointGroups& points, std::span<const Index> tried, double margin,
                    bool namesOnly = false) {
    const std::span<const std::array<Index, 4>> faces = surface.loops;
    const CubeGrid& grid = points.grid();
    const auto groups = points.groups();
    RankedBits used(grid.cubeCount());
    for (const Index group : tried) used.insert(groups[group].cube);
    std::vector<OrientedBox> boxes(near.size());
    std::vector<Bins::Entry> entries;
    std::vector<Point3> hull;
    for (Index number = 0; number < std::ssize(near); ++number) {
        const Index face = near[number];
        checkCancelledEvery(number, 12);
        if (enclosed == Enclosed::Limit) {
            surface.limitHull(face, vertices, hull);
        } else {
            hull.clear();
            for (const Index vertex : enclosed == Enclosed::Hull
                                          ? surface.hull(face)
                                          : std::span<const Index>(faces[face]))
                hull.push_back(vertices[vertex]);
        }
        const BoundingBox bounds(hull);
        // Enlarged by more than rounding.
        const double reach = margin + 1e-6 * grid.size;
        const auto from = grid.coordinatesOf(difference(bounds.min, {reach, reach, reach}));
        const auto to = grid.coordinatesOf(sum(bounds.max, {reach, reach, reach}));
        for (Index z = from[2]; z <= to[2]; ++z)
            for (Index y = from[1]; y <= to[1]; ++y)
                for (Index x = from[0]; x <= to[0]; ++x)
                    if (const Index cube = grid.cubeAt({x, y, z}); used[cube])
                        entries.push_back({cube, number});
        boxes[number] = boxAround(hull, faces[face], vertices);
    }
    const Bins cubes(grid.cubeCount(), entries);
    const Winding winding(faces, vertices, grid, used);
    const auto findBoxes = [&](Index group, std::vector<Index>& found) {
        const double apart = margin + 1e-9 * grid.size;
        const OrientedBox& box = groups[group].box;
        found.clear();
        for (const Index number : cubes[groups[group].cube])
            if (!boxes[number].isApart(box, apart) && !box.isApart(boxes[number], apart))
                found.push_back(number);
    };
    std::vector<Uncovered> ofGroups(tried.size());
    parallelFor(std::ssize(tried), 256, [&](Offset first, Offset last) {
        std::vector<Index> nearBoxes;
        for (Offset t = first; t < last; ++t) {
            const Index g = tried[t];
            const PointGroups::Group& group = groups[g];
            Uncovered& worst = ofGroups[t];
            worst = {g, group.first, -1, std::nullopt, 1};
            findBoxes(g, nearBoxes);
            const Index end = nearBoxes.empty() ? group.first + 1 : group.last;
            for (Index i = group.first; i < end; ++i) {
                checkCancelledEvery(i, 8);
                const Point3& point = points.points()[i];
                double depth = -1;
                std::optional<Index> deepest;
                for (const Index number : nearBoxes) {
                    const OrientedBox& box = boxes[number];
                    if (!box.isNear(point, margin)) continue;
                    const double here = dot(box.axes[2], point) - box.low[2] + margin;
                    if (here <= depth) continue;
                    depth = here;
                    deepest = surface.cells[near[number]];
                }
                int turns = 1;
                if (depth < 0) {
                    turns = winding.turnsAround(point);
                    if (turns != 1) depth = 0.5 * grid.size;
                }
                if (depth > worst.depth) worst = {g, i, depth, deepest, turns};
                if (namesOnly && worst.depth >= 0) break;
            }
        }
    });
    std::erase_if(ofGroups, [](const Uncovered& group) { return group.depth < 0; });
    NearGroups result{std::move(ofGroups), {}};
    std::vector<Index> nearBoxes;
    for (const Uncovered& group : result.groups) {
        findBoxes(group.group, nearBoxes);
        for (const Index number : nearBoxes) result.faces.push_back(near[number]);
    }
    sortUnique(result.faces);
    return result;
}

}  // namespace

double workOfCoverage(const CageSurface& surface, const PointGroups& points) {
    constexpr double kPerGroup = 500, kPerPoint = 20, kPerFace = 2000, kPerCube = 1;
    return kPerGroup * static_cast<double>(points.groups().size()) +
           kPerPoint * static_cast<double>(points.points().size()) +
           kPerFace * static_cast<double>(surface.fineFaces().loops.size()) +
           kPerCube * points.grid().cubeCount();
}

std::vector<Uncovered> findUncovered(const CageSurface& surface, std::span<const Point3> positions,
                                     const PointGroups& points, double margin) {
    const auto allOf = [](std::size_t count) {
        std::vector<Index> numbers(count);
        std::iota(numbers.begin(), numbers.end(), 0);
        return numbers;
    };
    const CageSurface::Faces& faces = surface.fineFaces();
    const std::vector<Point3> fine = surface.fineVertices(positions);
    const NearGroups found = findNear(faces, Enclosed::Hull, allOf(faces.loops.size()), fine,
                                      points, allOf(points.groups().size()), margin, true);
    std::vector<Index> groups, children;
    for (const Uncovered& group : found.groups) groups.push_back(group.group);
    if (groups.empty()) return {};
    // All other faces are apart from these groups. The hulls of the children of a face are in its
    // own hull.
    for (const Index face : found.faces)
        for (Index child = 4 * face; child < 4 * face + 4; ++child) children.push_back(child);
    const auto atLevel =
        findNear(faces, Enclosed::Corners, found.faces, fine, points, groups, margin).groups;
    const auto inLimit = findNear(surface.finestFaces(), Enclosed::Limit, children,
                                  surface.finestVertices(fine), points, groups, margin)
                             .groups;
    std::vector<Uncovered> result;
    for (auto a = atLevel.begin(), b = inLimit.begin(); a != atLevel.end() || b != inLimit.end();) {
        if (b == inLimit.end() || (a != atLevel.end() && a->group < b->group)) {
            result.push_back(*a++);
        } else if (a == atLevel.end() || b->group < a->group) {
            result.push_back(*b++);
        } else {
            result.push_back(a->depth > b->depth ? *a : *b);
            ++a;
            ++b;
        }
    }
    return result;
}

}  // namespace espalier::cages
