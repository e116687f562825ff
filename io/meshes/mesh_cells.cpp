// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/far/second_order_cells.h>
#include <espalier/far/topology_error.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "mesh_cells.h"

namespace espalier::io {
namespace {

using Loop = std::vector<Index>;

/// Returns six times the volume inside loops that are anticlockwise seen from outside.
double volumeOf(std::span<const Loop> loops, std::span<const Point3> positions) {
    double volume = 0;
    // Relative to a point of the cell, so that a cell far from the origin loses no digits.
    if (loops.empty()) return volume;
    const Point3 origin = positions[loops[0][0]];
    std::vector<Point3> points;
    for (const Loop& loop : loops) {
        points.clear();
        for (const Index point : loop) points.push_back(difference(positions[point], origin));
        volume += 2 * dot(mean(points), areaVector(points));
    }
    return volume;
}

/// Reverses loops so that two neighbours step along their common edge in opposite directions, as
/// far as the loops are joined by edges of two faces.
void makeCoherent(std::span<Loop> loops) {
    struct EdgeUse {
        std::size_t loop;
        bool isForward;
    };
    std::map<std::pair<Index, Index>, std::vector<EdgeUse>> uses;
    for (std::size_t i = 0; i < loops.size(); ++i)
        for (std::size_t k = 0; k < loops[i].size(); ++k) {
            const Index from = loops[i][k], to = loops[i][(k + 1) % loops[i].size()];
            uses[std::minmax(from, to)].push_back({i, from < to});
        }
    std::vector<std::vector<std::pair<std::size_t, bool>>> neighbours(loops.size());
    for (const auto& [edge, ofEdge] : uses) {
        if (ofEdge.size() != 2) continue;
        const bool agree = ofEdge[0].isForward != ofEdge[1].isForward;
        neighbours[ofEdge[0].loop].emplace_back(ofEdge[1].loop, agree);
        neighbours[ofEdge[1].loop].emplace_back(ofEdge[0].loop, agree);
    }
    std::vector<char> isSeen(loops.size(), 0), isReversed(loops.size(), 0);
    std::vector<std::size_t> open;
    for (std::size_t start = 0; start < loops.size(); ++start) {
        if (isSeen[start]) continue;
        isSeen[start] = 1;
        open = {start};
        while (!open.empty()) {
            const std::size_t loop = open.back();
            open.pop_back();
            for (const auto& [other, agree] : neighbours[loop]) {
                if (isSeen[other]) continue;
                isSeen[other] = 1;
                isReversed[other] = static_cast<char>(agree ? isReversed[loop] : !isReversed[loop]);
                open.push_back(other);
            }
        }
    }
    for (std::size_t i = 0; i < loops.size(); ++i)
        if (isReversed[i]) std::reverse(loops[i].begin(), loops[i].end());
}

}  // namespace

void MeshCells::groupSide(int dimension, std::span<const Index> corners,
                          std::span<const Index> points) {
    patches_.add(dimension, points);
    if (dimension == 2) patches_.addFace(corners);
    if (dimension == 1) patches_.addLine(points);
}

void MeshCells::cell(far::StandardCell kind, std::span<const Index> points) {
    checkCancelledEvery(cells_.size(), 12);
    patches_.add(3, points);
    cells_.push_back({true, kind, points_.size(), points_.size() + points.size()});
    points_.insert(points_.end(), points.begin(), points.end());
}

void MeshCells::polyhedron(std::span<const Loop> loops) {
    checkCancelledEvery(cells_.size(), 12);
    for (const Loop& loop : loops) patches_.add(3, loop);
    cells_.push_back({false, {}, loops_.size(), loops_.size() + loops.size()});
    loops_.insert(loops_.end(), loops.begin(), loops.end());
}

void MeshCells::face(std::span<const Index> points) {
    checkCancelledEvery(faces_.offsets.size(), 12);
    patches_.add(2, points);
    patches_.addFace(points);
    if (points.size() == 3 || points.size() == 4)
        faces_.push(points);
    else if (points.size() > 4)
        ++polygons_;
    else
        ++unknownElements_;
}

void MeshCells::smallCell(int dimension, std::span<const Index> points) {
    if (dimension == 1) groupSide(1, points, points);
}

void MeshCells::curvedCell(int dimension, std::span<const Index> points) {
    if (dimension == 3 && !points.empty()) return cell(*far::kindOfCell(points.size()), points);
    if (dimension == 3) ++curvedCells_;
    if (dimension == 1 && !points.empty()) return groupSide(1, points, points);
    if (dimension != 2) return;
    if (points.empty()) {
        ++curvedFaces_;
        return;
    }
    patches_.add(2, points);
    patches_.addFace(far::cornersOfFace(points));
    faces_.push(points);
}

void MeshCells::giveFaces(ModelCells& cells, Index pointCount) const {
    const std::size_t faceCount = faces_.count();
    if (cells.isSurface() && cells.curvedCells == 0) {
        cells.surface = far::SurfaceMesh(pointCount);
        for (std::size_t face = 0; face < faceCount; ++face) cells.surface.addFace(faces_[face]);
        cells.polygons = polygons_;
        cells.curvedFaces = curvedFaces_;
        return;
    }
    // A face of a cell is checked with the cell. Faces are the same if their corners are.
    using Corners = std::array<Index, 4>;
    const auto cornersOf = [](std::span<const Index> points) {
        Corners corners = {-1, -1, -1, -1};
        std::ranges::copy(far::cornersOfFace(points), corners.begin());
        std::ranges::sort(corners);
        return corners;
    };
    std::vector<Corners> faces(faceCount);
    for (std::size_t face = 0; face < faceCount; ++face) faces[face] = cornersOf(faces_[face]);
    std::ranges::sort(faces);
    std::vector<char> isOfCell(faceCount, 0);
    for (Index face = 0; face < cells.volume.faceCount() && faceCount > 0; ++face) {
        checkCancelledEvery(face, 12);
        const auto loop = cells.volume.face(face);
        if (loop.size() > 4) continue;
        const auto [first, last] = std::equal_range(faces.begin(), faces.end(), cornersOf(loop));
        std::fill(isOfCell.begin() + (first - faces.begin()),
                  isOfCell.begin() + (last - faces.begin()), 1);
    }
    cells.facesBeside = static_cast<Index>(std::ranges::count(isOfCell, 0));
}

ModelCells MeshCells::finish(std::span<const Point3> positions) {
    const auto pointCount = static_cast<Index>(positions.size());
    const auto check = [&](std::span<const Index> points, std::size_t cell) {
        for (const Index point : points)
            if (point < 0 || point >= pointCount)
                throw far::TopologyError(
                    far::TopologyCause::VertexOutOfRange, {3, static_cast<Index>(cell)},
                    concat("cell ", cell, " names point ", point, "; there are ", pointCount));
    };
    std::array<std::ptrdiff_t, 4> balance{};  ///< positive minus negative cells of each kind
    std::vector<Loop> loops;
    for (std::size_t number = 0; number < cells_.size(); ++number) {
        checkCancelledEvery(number, 10);
        const Cell& cell = cells_[number];
        if (!cell.isStandard) {
            for (std::size_t i = cell.begin; i < cell.end; ++i) check(loops_[i], number);
            continue;
        }
        const std::span<const Index> points(points_.data() + cell.begin, cell.end - cell.begin);
        check(points, number);
        loops = far::faceLoops(cell.kind);
        for (Loop& loop : loops)
            for (Index& point : loop) point = points[point];
        const double volume = volumeOf(loops, positions);
        balance[static_cast<std::size_t>(cell.kind)] += volume > 0 ? 1 : volume < 0 ? -1 : 0;
    }
    far::VolumeMeshBuilder builder(pointCount);
    std::size_t polyhedra = 0;
    for (const Cell& cell : cells_) {
        if (cell.isStandard) {
            const std::span<Index> points(points_.data() + cell.begin, cell.end - cell.begin);
            if (balance[static_cast<std::size_t>(cell.kind)] < 0) far::mirrorCell(points);
            builder.addCell(cell.kind, points);
        } else {
            const std::span<Loop> ofCell(loops_.data() + cell.begin, cell.end - cell.begin);
            checkCancelledEvery(polyhedra++, 6);  // maps and lists for each
            makeCoherent(ofCell);
            if (volumeOf(ofCell, positions) < 0)
                for (Loop& loop : ofCell) std::reverse(loop.begin(), loop.end());
            builder.addCell(ofCell);
        }
    }
    ModelCells result;
    result.volume = builder.build();
    result.patches = patches_.take();
    result.curvedCells = curvedCells_;
    result.unknownElements = unknownElements_;
    giveFaces(result, pointCount);
    return result;
}

}  // namespace espalier::io
