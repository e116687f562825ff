// SPDX-License-Identifier: Apache-2.0
#include "cage_surface.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/far/complex_builder.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "left_side.h"

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

/// Returns the table of the means of four rows each.
stencils::StencilTable<double> centresOf(const stencils::StencilTable<double>& vertices,
                                         const far::CellComplex& mesh) {
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    std::vector<std::pair<Index, double>> row;
    for (Index face = 0; face < mesh.count(2); ++face) {
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
        for (Index& vertex : loop) vertex = placeIn(names, vertex);
    far::RefinerOptions options;
    far::CellComplex mesh = far::buildMesh(static_cast<Index>(names.size()), loops);
    for (Index edge = 0; edge < complex.count(1); ++edge) {
        if (strata.of({1, edge}) != 1 || strata.smoothStratum({1, edge}) != 2) continue;
        const auto ends = complex.relation(1, 0)[edge];
        options.marks.edges.push_back({{placeIn(names, ends[0]), placeIn(names, ends[1])}});
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
    fineTable_ = withColumns(stencils::buildStencils(refiner, kLevel), names, complex.count(0));
    fineCentres_ = centresOf(fineTable_, refiner.level(kLevel).complex);
    coarseCentres_ = centresOf(
        withColumns(stencils::buildStencils(refiner, kLevel - 1), names, complex.count(0)),
        refiner.level(kLevel - 1).complex);

    const auto parents = [&](int level) {
        std::vector<Index> result;
        for (Index face = 0; face < refiner.level(level).complex.count(2); ++face)
            result.push_back(refiner.refinement(level).parentOf({2, face}).upper.index);
        return result;
    };
    coarseOfFine_ = parents(kLevel);
    fineOfFinest_ = parents(kLevel + 1);
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
}

CageSurface::Faces::Faces(const far::Level& level, std::vector<Index> cellsOfFaces)
    : cells(std::move(cellsOfFaces)) {
    const far::CellComplex& mesh = level.complex;
    const auto& edgesOfFace = mesh.relation(2, 1);
    const auto& facesOfEdge = mesh.relation(1, 2);
    const auto& endsOfEdge = mesh.relation(1, 0);
    for (Index face = 0; face < mesh.count(2); ++face) {
        const auto loop = mesh.relation(2, 0)[face];
        loops.push_back({loop[0], loop[1], loop[2], loop[3]});
    }
    // The faces around each corner of a face count, up to the sharp edges: the limit of the face
    // does not depend on the faces beyond them.
    std::vector<Index> hull;
    for (Index face = 0; face < mesh.count(2); ++face) {
        hull.clear();
        for (std::size_t corner = 0; corner < 4; ++corner) {
            const Index vertex = loops[face][corner];
            for (const std::size_t side : {corner, (corner + 3) % 4}) {
                Index at = face, edge = edgesOfFace[face][side];
                for (;;) {
                    hull.insert(hull.end(), loops[at].begin(), loops[at].end());
                    if (level.strata.of({1, edge}) < 2) break;
                    const auto pair = facesOfEdge[edge];
                    at = pair[0] == at ? pair[1] : pair[0];
                    if (at == face) break;
                    // The other edge of the next face at the vertex.
                    const auto edges = edgesOfFace[at];
                    for (std::size_t i = 0; i < 4; ++i) {
                        const auto ends = endsOfEdge[edges[i]];
                        if (edges[i] != edge && (ends[0] == vertex || ends[1] == vertex)) {
                            edge = edges[i];
                            break;
                        }
                    }
                }
            }
        }
        sortUnique(hull);
        hulls.insert(hulls.end(), hull.begin(), hull.end());
        hullOffsets.push_back(static_cast<Offset>(hulls.size()));
    }
}

std::span<const Index> CageSurface::Faces::hull(Index face) const {
    return std::span(hulls).subspan(hullOffsets[face], hullOffsets[face + 1] - hullOffsets[face]);
}

std::vector<Point3> CageSurface::fineVertices(std::span<const Point3> positions) const {
    return stencils::applyLevelTable(fineTable_, positions);
}

std::vector<Point3> CageSurface::finestVertices(std::span<const Point3> fineVertices) const {
    return stencils::applyLevelTable(finestTable_, fineVertices);
}

namespace {

/// A box around the hull of a face, with its own axes; `low[2]` is its inner side.
struct HullBox {
    std::array<Point3, 3> axes;  ///< the last one is the normal
    std::array<double, 3> low, high;

    /// Returns true if the distance of a point from the box is at most `margin`.
    bool isNear(const Point3& point, double margin) const {
        double square = 0;
        for (int axis = 2; axis >= 0; --axis) {
            const double value = dot(axes[axis], point);
            const double away = std::max({low[axis] - value, value - high[axis], 0.0});
            if (away > margin) return false;
            square += away * away;
        }
        return square <= margin * margin;
    }
};

HullBox boxAround(std::span<const Index> hull, const std::array<Index, 4>& face,
                  std::span<const Point3> vertices) {
    const Point3 along = difference(vertices[face[2]], vertices[face[0]]);
    Point3 normal = cross(along, difference(vertices[face[3]], vertices[face[1]]));
    const double size = length(normal);
    HullBox box;
    if (size > 0) {
        box.axes[2] = scaled(normal, 1 / size);
        box.axes[0] = normalised(along);
        box.axes[1] = cross(box.axes[2], box.axes[0]);
    } else {
        box.axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    }
    BoundingBox bounds;
    for (const Index vertex : hull) {
        const Point3& at = vertices[vertex];
        bounds.include({dot(box.axes[0], at), dot(box.axes[1], at), dot(box.axes[2], at)});
    }
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = bounds.min[axis];
        box.high[axis] = bounds.max[axis];
    }
    return box;
}

/// Lists, for each of some bins, the items that may be in it.
class Bins {
public:
    /// \param forEachBin calls visit(bin) for the bins of an item
    template <class ForEachBin>
    Bins(Index binCount, Index itemCount, ForEachBin forEachBin) : offsets_(binCount + 1, 0) {
        for (Index item = 0; item < itemCount; ++item)
            forEachBin(item, [&](Index bin) { ++offsets_[bin + 1]; });
        for (Index bin = 0; bin < binCount; ++bin) offsets_[bin + 1] += offsets_[bin];
        items_.resize(offsets_.back());
        std::vector<Offset> next(offsets_.begin(), offsets_.end() - 1);
        for (Index item = 0; item < itemCount; ++item)
            forEachBin(item, [&](Index bin) { items_[next[bin]++] = item; });
    }

    std::span<const Index> operator[](Index bin) const {
        return std::span(items_).subspan(offsets_[bin], offsets_[bin + 1] - offsets_[bin]);
    }

private:
    std::vector<Offset> offsets_;
    std::vector<Index> items_;
};

/// Counts how often triangles wind around points.
class Winding {
public:
    Winding(std::span<const std::array<Index, 4>> faces, std::span<const Point3> vertices,
            const CubeGrid& grid)
        : faces_(faces),
          vertices_(vertices),
          grid_(grid),
          bounds_(boundsOf(faces, vertices)),
          columns_(grid.counts[0] * grid.counts[1], static_cast<Index>(faces.size()),
                   [&](Index face, auto visit) {
                       const auto from = grid.coordinatesOf(bounds_[face].min);
                       const auto to = grid.coordinatesOf(bounds_[face].max);
                       for (Index y = from[1]; y <= to[1]; ++y)
                           for (Index x = from[0]; x <= to[0]; ++x) visit(y * grid.counts[0] + x);
                   }) {}

    /// Follows the ray from `point` upwards. The point must not be on a triangle.
    int around(const Point3& point) const {
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
    static std::vector<BoundingBox> boundsOf(std::span<const std::array<Index, 4>> faces,
                                             std::span<const Point3> vertices) {
        std::vector<BoundingBox> bounds(faces.size());
        for (std::size_t face = 0; face < faces.size(); ++face)
            for (const Index vertex : faces[face]) bounds[face].include(vertices[vertex]);
        return bounds;
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
    std::vector<BoundingBox> bounds_;  ///< of each face
    Bins columns_;
};

/// The boxes to use: around the hull of each face, or around its four corners.
enum class Around { Hull, Corners };

/// Returns the groups in `tried` that have a point within `margin` of a box, or a point around
/// which the triangles of the faces do not wind once.
/// \param namesOnly only the names of the groups are wanted; faster
std::vector<Uncovered> findNear(const CageSurface::Faces& surface, Around around,
                                std::span<const Point3> vertices, const PointGroups& points,
                                std::span<const Index> tried, double margin,
                                bool namesOnly = false) {
    const std::span<const std::array<Index, 4>> faces = surface.loops;
    const auto faceCount = static_cast<Index>(faces.size());
    const CubeGrid& grid = points.grid();
    std::vector<HullBox> boxes(faceCount);
    std::vector<std::array<Index, 3>> from(faceCount), to(faceCount);
    for (Index face = 0; face < faceCount; ++face) {
        boxes[face] = boxAround(
            around == Around::Hull ? surface.hull(face) : std::span<const Index>(faces[face]),
            faces[face], vertices);
        Point3 centre = {0, 0, 0}, reach = {margin, margin, margin};
        for (int k = 0; k < 3; ++k)
            for (int axis = 0; axis < 3; ++axis) {
                const Point3& way = boxes[face].axes[k];
                centre[axis] += way[axis] * (boxes[face].low[k] + boxes[face].high[k]) / 2;
                reach[axis] += std::abs(way[axis]) * (boxes[face].high[k] - boxes[face].low[k]) / 2;
            }
        // Enlarged by more than rounding.
        reach = sum(reach, scaled({1, 1, 1}, 1e-6 * grid.size));
        from[face] = grid.coordinatesOf(difference(centre, reach));
        to[face] = grid.coordinatesOf(sum(centre, reach));
    }
    std::vector<char> isUsed(grid.cubeCount(), 0);
    const auto groups = points.groups();
    for (const Index group : tried) isUsed[groups[group].cube] = 1;
    const Bins cubes(grid.cubeCount(), faceCount, [&](Index face, auto visit) {
        for (Index z = from[face][2]; z <= to[face][2]; ++z)
            for (Index y = from[face][1]; y <= to[face][1]; ++y)
                for (Index x = from[face][0]; x <= to[face][0]; ++x)
                    if (const Index cube = grid.cubeAt({x, y, z}); isUsed[cube]) visit(cube);
    });
    const Winding winding(faces, vertices, grid);
    std::vector<Uncovered> ofGroups(tried.size());
    parallelFor(std::ssize(tried), 256, [&](Offset first, Offset last) {
        std::vector<Index> near;
        for (Offset t = first; t < last; ++t) {
            const Index g = tried[t];
            const PointGroups::Group& group = groups[g];
            Uncovered& worst = ofGroups[t];
            worst = {g, group.first, -1, std::nullopt, 1};
            const Point3 middle = scaled(sum(group.low, group.high), 0.5);
            const Point3 half = scaled(difference(group.high, group.low), 0.5);
            near.clear();
            for (const Index face : cubes[group.cube]) {
                const HullBox& box = boxes[face];
                bool isApart = false;
                for (int k = 2; k >= 0 && !isApart; --k) {
                    const Point3& way = box.axes[k];
                    const double value = dot(way, middle);
                    const double reach = std::abs(way[0]) * half[0] + std::abs(way[1]) * half[1] +
                                         std::abs(way[2]) * half[2] + margin + 1e-9 * grid.size;
                    isApart = value + reach < box.low[k] || value - reach > box.high[k];
                }
                if (!isApart) near.push_back(face);
            }
            const Index end = near.empty() ? group.first + 1 : group.last;
            for (Index i = group.first; i < end; ++i) {
                const Point3& point = points.points()[i];
                double depth = -1;
                std::optional<Index> deepest;
                for (const Index face : near) {
                    if (!boxes[face].isNear(point, margin)) continue;
                    const double here =
                        dot(boxes[face].axes[2], point) - boxes[face].low[2] + margin;
                    if (here <= depth) continue;
                    depth = here;
                    deepest = surface.cells[face];
                }
                int turns = 1;
                if (depth < 0) {
                    turns = winding.around(point);
                    if (turns != 1) depth = 0.5 * grid.size;
                }
                if (depth > worst.depth) worst = {g, i, depth, deepest, turns};
                if (namesOnly && worst.depth >= 0) break;
            }
        }
    });
    std::erase_if(ofGroups, [](const Uncovered& group) { return group.depth < 0; });
    return ofGroups;
}

}  // namespace

std::vector<Uncovered> findUncovered(const CageSurface& surface, std::span<const Point3> positions,
                                     const PointGroups& points, double margin) {
    std::vector<Index> groups(points.groups().size());
    std::iota(groups.begin(), groups.end(), 0);
    const std::vector<Point3> fine = surface.fineVertices(positions);
    const auto namesOf = [&](const std::vector<Uncovered>& uncovered) {
        groups.clear();
        for (const Uncovered& group : uncovered) groups.push_back(group.group);
    };
    namesOf(findNear(surface.fineFaces(), Around::Hull, fine, points, groups, margin, true));
    if (groups.empty()) return {};
    auto atLevel = findNear(surface.fineFaces(), Around::Corners, fine, points, groups, margin);
    auto inLimit = findNear(surface.finestFaces(), Around::Hull, surface.finestVertices(fine),
                            points, groups, margin);
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
