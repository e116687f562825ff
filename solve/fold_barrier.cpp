// SPDX-License-Identifier: Apache-2.0
#include "fold_barrier.h"

#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/base/sort_unique.h>
#include <espalier/base/vector3.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace espalier::solve {
namespace {

// A cell at half of kActive has about the elastic energy of a cell of that height.
constexpr double kStrength = 2;

using Tetrahedron = std::array<Index, 4>;

/// Calls visit(tetrahedron) for each tetrahedron of three edges at a vertex of a refined cell.
template <class Visit>
void visitTetrahedra(const far::CellComplex& complex, Index cell, const Visit& visit) {
    /// A vertex, and its two neighbours in a face of the cell.
    struct Corner {
        Index vertex, before, after;
    };
    std::vector<Corner> corners;
    for (const Index face : complex.relation(3, 2)[cell]) {
        const auto loop = complex.relation(2, 0)[face];
        for (std::size_t i = 0; i < loop.size(); ++i)
            corners.push_back(
                {loop[i], loop[(i + loop.size() - 1) % loop.size()], loop[(i + 1) % loop.size()]});
    }
    std::stable_sort(corners.begin(), corners.end(),
                     [](const Corner& a, const Corner& b) { return a.vertex < b.vertex; });
    // In a type-n cell with n > 3, two vertices have n faces: they are opposite.
    Index sumOfOpposites = 0;
    const auto facesAt = [&](std::size_t first) {
        std::size_t last = first;
        while (last < corners.size() && corners[last].vertex == corners[first].vertex) ++last;
        return last - first;
    };
    for (std::size_t first = 0; first < corners.size(); first += facesAt(first))
        if (facesAt(first) > 3) sumOfOpposites += corners[first].vertex;
    for (std::size_t first = 0; first < corners.size();) {
        const std::size_t count = facesAt(first);
        const Corner& corner = corners[first];
        if (count == 3) {
            const Corner& next = corners[first + 1];
            const bool isSeen = next.before == corner.before || next.before == corner.after;
            visit(Tetrahedron{corner.vertex, corner.before, corner.after,
                              isSeen ? next.after : next.before});
        } else {
            for (std::size_t i = first; i < first + count; ++i)
                visit(Tetrahedron{corner.vertex, corners[i].before, corners[i].after,
                                  sumOfOpposites - corner.vertex});
        }
        first += count;
    }
}

/// The three edges of a tetrahedron at its corner.
struct Edges {
    Point3 a, b, c;

    Edges(std::span<const Point3> points, const Tetrahedron& tetrahedron)
        : a(difference(points[tetrahedron[1]], points[tetrahedron[0]])),
          b(difference(points[tetrahedron[2]], points[tetrahedron[0]])),
          c(difference(points[tetrahedron[3]], points[tetrahedron[0]])) {}

    double volume() const { return dot(cross(a, b), c); }
};

}  // namespace

FoldBarrier::FoldBarrier(const far::TopologyRefiner& base, std::span<const Point3> rest,
                         std::span<const char> isFixed) {
    far::TopologyRefiner refiner(base);
    refiner.refineUniform(2);
    /// Returns the cells of a level that have a vertex of a coarser level. Both have its number.
    const auto cellsAt = [&](int level, int coarser) {
        const auto& complex = refiner.level(level).complex;
        std::vector<Index> cells;
        for (Index vertex = 0; vertex < refiner.level(coarser).complex.count(0); ++vertex)
            for (const Index cell : complex.relation(0, 3)[vertex]) cells.push_back(cell);
        sortUnique(cells);
        return cells;
    };
    refiner.refineAround(cellsAt(2, 0), far::TopologyRefiner::Extent::Cells);
    // Relative to a vertex, so that a lattice far from the origin loses no digits.
    std::vector<Point3> relative;
    for (const Point3& point : rest) relative.push_back(difference(point, rest[0]));
    for (const int level : {1, 2, 3}) {
        const auto& complex = refiner.level(level).complex;
        const Index coarseCount = refiner.level(1).complex.count(0);
        std::vector<Tetrahedron> found;
        for (const Index cell : cellsAt(level, level == 2 ? 1 : 0)) {
            checkCancelledEvery(cell, 10);
            visitTetrahedra(complex, cell, [&](const Tetrahedron& tetrahedron) {
                if (level != 2 || tetrahedron[0] < coarseCount) found.push_back(tetrahedron);
            });
        }
        std::vector<Index> vertices;
        for (const Tetrahedron& each : found)
            vertices.insert(vertices.end(), each.begin(), each.end());
        sortUnique(vertices);
        Part part;
        part.scale = std::pow(8.0, level - 1);
        part.table = stencils::buildStencils(refiner, level, vertices);
        part.rest = stencils::applyLevelTable(part.table, relative);
        std::vector<char> stays(vertices.size());
        for (Index row = 0; row < part.table.rowCount(); ++row)
            stays[row] = std::ranges::all_of(part.table.columns(row),
                                             [&](Index vertex) { return isFixed[vertex] != 0; });
        // A tetrahedron that is flatter is not the shape that the refined cell has around it.
        constexpr double kFlat = 1e-3;
        for (const Tetrahedron& each : found) {
            Tetrahedron own;
            for (std::size_t i = 0; i < 4; ++i) own[i] = indexIn(vertices, each[i]);
            const Edges edges(part.rest, own);
            const double volume = edges.volume();
            if (std::abs(volume) <= kFlat * length(edges.a) * length(edges.b) * length(edges.c) ||
                std::ranges::all_of(own, [&](Index point) { return stays[point] != 0; }))
                continue;
            part.tetrahedra.push_back(own);
            part.volumes.push_back(volume);
        }
        keepUsedRows(part);
        parts_.push_back(std::move(part));
    }
}

/// Removes the points that no tetrahedron has: half of the lattice may stay.
void FoldBarrier::keepUsedRows(Part& part) {
    std::vector<Index> used;
    for (const Tetrahedron& each : part.tetrahedra)
        used.insert(used.end(), each.begin(), each.end());
    sortUnique(used);
    part.table = stencils::selectRows(part.table, used);
    std::vector<Point3> kept;
    for (const Index point : used) kept.push_back(part.rest[point]);
    part.rest = std::move(kept);
    for (Tetrahedron& each : part.tetrahedra)
        for (Index& point : each) point = indexIn(used, point);
}

double FoldBarrier::energy(const Columns& moved, Columns* gradient) const {
    double total = 0;
    for (const Part& part : parts_) {
        total += energy(part, moved, gradient);
        if (!std::isfinite(total)) break;
    }
    return total;
}

double FoldBarrier::energy(const Part& part, const Columns& moved, Columns* gradient) const {
    std::vector<Point3> points = part.rest;
    constexpr Offset kRows = 256, kTetrahedra = 1024;
    parallelFor(part.table.rowCount(), kRows, [&](Offset first, Offset last) {
        for (auto row = static_cast<Index>(first); row < last; ++row) {
            const auto columns = part.table.columns(row);
            const auto weights = part.table.weights(row);
            for (std::size_t i = 0; i < columns.size(); ++i)
                for (Index c = 0; c < 3; ++c) points[row][c] += weights[i] * moved(columns[i], c);
        }
    });
    std::vector<double> ratios(part.tetrahedra.size());
    parallelFor(std::ssize(ratios), kTetrahedra, [&](Offset first, Offset last) {
        for (Offset i = first; i < last; ++i)
            ratios[i] = Edges(points, part.tetrahedra[i]).volume() / part.volumes[i];
    });
    double total = 0;
    std::vector<Point3> slopes;  // derivatives by the points
    if (gradient != nullptr) slopes.resize(points.size(), Point3{});
    for (std::size_t i = 0; i < ratios.size(); ++i) {
        const double ratio = ratios[i];
        if (ratio >= kActive) continue;
        if (!(ratio > 0)) return std::numeric_limits<double>::infinity();
        const double weight = kStrength * part.scale * std::abs(part.volumes[i]);
        const double near = kActive / ratio - 1;
        total += weight * near * near;
        if (gradient == nullptr) continue;
        const Tetrahedron& own = part.tetrahedra[i];
        const Edges edges(points, own);
        const double slope = -2 * weight * near * kActive / (ratio * ratio) / part.volumes[i];
        const Point3 byEdge[] = {scaled(cross(edges.b, edges.c), slope),
                                 scaled(cross(edges.c, edges.a), slope),
                                 scaled(cross(edges.a, edges.b), slope)};
        for (std::size_t e = 0; e < 3; ++e) {
            slopes[own[e + 1]] = sum(slopes[own[e + 1]], byEdge[e]);
            slopes[own[0]] = difference(slopes[own[0]], byEdge[e]);
        }
    }
    if (gradient != nullptr && total > 0)
        for (Index row = 0; row < part.table.rowCount(); ++row) {
            if (slopes[row] == Point3{}) continue;
            const auto columns = part.table.columns(row);
            const auto weights = part.table.weights(row);
            for (std::size_t i = 0; i < columns.size(); ++i)
                for (Index c = 0; c < 3; ++c)
                    (*gradient)(columns[i], c) += weights[i] * slopes[row][c];
        }
    return total;
}

}  // namespace espalier::solve
