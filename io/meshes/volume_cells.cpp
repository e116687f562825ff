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

#include "volume_cells.h"

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

void VolumeCells::cell(far::StandardCell kind, std::span<const Index> points) {
    checkCancelledEvery(cells_.size(), 12);
    cells_.push_back({true, kind, points_.size(), points_.size() + points.size()});
    points_.insert(points_.end(), points.begin(), points.end());
}

void VolumeCells::polyhedron(std::span<const Loop> loops) {
    checkCancelledEvery(cells_.size(), 12);
    cells_.push_back({false, {}, loops_.size(), loops_.size() + loops.size()});
    loops_.insert(loops_.end(), loops.begin(), loops.end());
}

void VolumeCells::face(std::span<const Index> points) {
    checkCancelledEvery(faces_.offsets.size(), 12);
    if (points.size() != 3 && points.size() != 4) {
        ++polygons_;
        return;
    }
    faces_.values.insert(faces_.values.end(), points.begin(), points.end());
    faces_.offsets.push_back(static_cast<Offset>(faces_.values.size()));
}

void VolumeCells::curvedCell(int dimension, std::span<const Index> points) {
    if (dimension == 3 && !points.empty()) return cell(*far::kindOfCell(points.size()), points);
    if (dimension == 3) ++curvedCells_;
    if (dimension != 2) return;
    if (points.empty()) {
        ++curvedFaces_;
        return;
    }
    faces_.values.insert(faces_.values.end(), points.begin(), points.end());
    faces_.offsets.push_back(static_cast<Offset>(faces_.values.size()));
}

void VolumeCells::giveFaces(ModelVolume& volume, Index pointCount) const {
    const auto faceAt = [&](std::size_t face) {
        return std::span(faces_.values.data() + faces_.offsets[face],
                         faces_.values.data() + faces_.offsets[face + 1]);
    };
    const std::size_t faceCount = faces_.offsets.size() - 1;
    if (volume.mesh.cellCount() == 0 && volume.curvedCells == 0) {
        volume.surface = far::SurfaceMesh(pointCount);
        for (std::size_t face = 0; face < faceCount; ++face) volume.surface.addFace(faceAt(face));
        volume.polygons = polygons_;
        volume.curvedFaces = curvedFaces_;
        return;
    }
    // A face of a cell is checked with the cell. The corners of faces tell which these are.
    using Corners = std::array<Index, 4>;
    const auto cornersOf = [](std::span<const Index> points) {
        Corners corners = {-1, -1, -1, -1};
        const bool isTriangle = points.size() == 3 || points.size() == 6;
        std::ranges::copy(points.first(isTriangle ? 3 : 4), corners.begin());
        std::ranges::sort(corners);
        return corners;
    };
    std::vector<Corners> faces(faceCount);
    for (std::size_t face = 0; face < faceCount; ++face) faces[face] = cornersOf(faceAt(face));
    std::ranges::sort(faces);
    std::vector<char> isOfCell(faceCount, 0);
    for (Index face = 0; face < volume.mesh.faceCount() && faceCount > 0; ++face) {
        checkCancelledEvery(face, 12);
        const auto loop = volume.mesh.face(face);
        if (loop.size() > 4) continue;
        const auto [first, last] = std::equal_range(faces.begin(), faces.end(), cornersOf(loop));
        std::fill(isOfCell.begin() + (first - faces.begin()),
                  isOfCell.begin() + (last - faces.begin()), 1);
    }
    volume.facesBeside = static_cast<Index>(std::ranges::count(isOfCell, 0));
}

ModelVolume VolumeCells::finish(std::span<const Point3> positions) {
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
    ModelVolume volume;
    volume.mesh = builder.build();
    volume.curvedCells = curvedCells_;
    volume.unknownElements = unknownElements_;
    giveFaces(volume, pointCount);
    return volume;
}

}  // namespace espalier::io
