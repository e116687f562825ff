// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/progress.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/cell_distances.h>
#include <espalier/shapes/limb.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "cell_sections.h"
#include "checks.h"

namespace espalier::shapes {
namespace {

/// Rounding of distances and of sums of volumes in a lattice of size 1.
constexpr double kEqual = 1e-9;

/// Returns the positions in a box of size 1 or less, so that volumes do not vanish or overflow.
std::vector<Point3> nearOne(std::span<const Point3> positions) {
    const BoundingBox box(positions);
    const double diagonal = box.diagonal();
    std::vector<Point3> result;
    for (const Point3& position : positions)
        result.push_back(scaled(difference(position, box.min), diagonal > 0 ? 1 / diagonal : 1));
    return result;
}

/// A cell and its distance from the point.
struct Reached {
    double distance = 0;
    Index cell = 0;
};

/// Returns the cells that ways from a point reach, from the nearest to the farthest.
std::vector<Reached> cellsInOrder(const far::CellComplex& complex,
                                  std::span<const Point3> positions, const Point3& point) {
    const Index first = nearestCell(complex, positions, point);
    const auto distances =
        distancesAlongCells(complex, positions, waysFrom(point, complex, positions, first));
    std::vector<Reached> reached;
    for (Index cell = 0; cell < complex.count(3); ++cell) {
        const auto vertices = complex.relation(3, 0)[cell];
        double total = 0;
        for (const Index vertex : vertices) total += distances[vertex];
        if (std::isfinite(total))
            reached.push_back(
                {cell == first ? -1 : total / static_cast<double>(vertices.size()), cell});
    }
    std::ranges::sort(reached, [](const Reached& a, const Reached& b) {
        return std::pair(a.distance, a.cell) < std::pair(b.distance, b.cell);
    });
    return reached;
}

/// The first cells up to some place in their order.
struct Part {
    std::size_t count = 0;  ///< number of cells
    double volume = 0;
    double width = 0;  ///< area / volume^(2/3)
    double opening = 1;
};

/// Returns the parts that end between cells of different distances, and have a section. The last
/// one has all cells.
std::vector<Part> partsOf(const far::CellComplex& complex, std::span<const Point3> positions,
                          std::span<const Reached> reached) {
    std::vector<char> isInside(complex.count(3), 0);
    std::vector<Part> parts;
    double area = 0, volume = 0;
    Index border = 0;  // number of faces between the part and the rest
    for (std::size_t i = 0; i < reached.size(); ++i) {
        checkCancelledEvery(static_cast<Offset>(i), 10);
        const Index cell = reached[i].cell;
        isInside[cell] = 1;
        volume += cellVolume(complex, positions, cell);
        for (const Index face : complex.relation(3, 2)[cell]) {
            const auto cells = complex.relation(2, 3)[face];
            if (cells.size() != 2) continue;
            const Index other = cells[0] == cell ? cells[1] : cells[0];
            const double size = length(areaVector(loopOf(complex, positions, face)));
            area += isInside[other] != 0 ? -size : size;
            border += isInside[other] != 0 ? -1 : 1;
        }
        if (i + 1 < reached.size() && reached[i + 1].distance <= reached[i].distance + kEqual)
            continue;
        // A part that only vertices join to the rest has no section: its area is 0 but for
        // rounding.
        if (border == 0 && i + 1 < reached.size()) continue;
        if (volume > 0)
            parts.push_back({i + 1, volume, std::max(area, 0.0) / std::pow(volume, 2.0 / 3), 1});
    }
    return parts;
}

/// Returns the part with the largest opening. Its volume is at most `part` of the whole.
const Part* widestOpening(std::span<const Part> parts, double part) {
    const Part* best = nullptr;
    for (const Part& each : parts)
        if (each.volume <= part * (1 + kEqual) * parts.back().volume &&
            each.count < parts.back().count && (best == nullptr || each.opening > best->opening))
            best = &each;
    return best;
}

Limb limbOf(const far::CellComplex& complex, std::span<const Point3> positions,
            std::vector<Index> cells, double opening) {
    std::ranges::sort(cells);
    std::vector<char> isInside(complex.count(3), 0), isVertex(complex.count(0), 0);
    for (const Index cell : cells) {
        isInside[cell] = 1;
        for (const Index vertex : complex.relation(3, 0)[cell]) isVertex[vertex] = 1;
    }
    Limb limb;
    limb.section = sectionOf(complex, positions, facesBetween(complex, isInside));
    limb.cells = std::move(cells);
    for (Index vertex = 0; vertex < complex.count(0); ++vertex)
        if (isVertex[vertex] != 0) limb.vertices.push_back(vertex);
    limb.opening = opening;
    return limb;
}

/// The cells on one side of a face, and their volume.
struct Side {
    std::vector<Index> cells;
    double volume = 0;
};

/// Returns the cells that are joined to a cell at a face on the cell's side of the face's plane.
Side sideOf(const far::CellComplex& complex, std::span<const Point3> positions, Index face,
            Index first) {
    const auto loop = loopOf(complex, positions, face);
    const Point3 normal = areaVector(loop), middle = mean(loop);
    const auto height = [&](Index cell) {
        return dot(normal, difference(cellMiddle(complex, positions, cell), middle));
    };
    const double sign = height(first) < 0 ? -1 : 1;
    std::vector<char> isSeen(complex.count(3), 0);
    for (const Index cell : complex.relation(2, 3)[face]) isSeen[cell] = 1;
    Side side{{first}, 0};
    for (std::size_t i = 0; i < side.cells.size(); ++i) {
        side.volume += cellVolume(complex, positions, side.cells[i]);
        for (const Index next : complex.relation(3, 2)[side.cells[i]])
            for (const Index cell : complex.relation(2, 3)[next])
                if (isSeen[cell] == 0 && sign * height(cell) > 0) {
                    isSeen[cell] = 1;
                    side.cells.push_back(cell);
                }
    }
    return side;
}

}  // namespace

Limb selectLimb(const far::CellComplex& complex, std::span<const Point3> positions,
                const Point3& point) {
    requireCells("selectLimb", complex, positions);
    requireFinite("selectLimb", "point", point);
    std::vector<Point3> all = nearOne(positions);
    const BoundingBox box(positions);
    const double diagonal = box.diagonal();
    const Point3 place = scaled(difference(point, box.min), diagonal > 0 ? 1 / diagonal : 1);
    const auto reached = cellsInOrder(complex, all, place);
    auto parts = partsOf(complex, all, reached);
    const double half = parts.empty() ? 0 : 0.5 * (1 + kEqual) * parts.back().volume;
    for (Part& part : parts) {
        checkCancelled();
        for (const Part& later : std::span(parts).subspan(&part - parts.data())) {
            if (later.width < part.width && later.volume <= half) break;
            if (part.width > 0) part.opening = std::max(part.opening, later.width / part.width);
        }
    }
    const Part *chosen = nullptr, *widest = nullptr;
    for (const auto& [part, opens] : {std::pair(1.0 / 3, 1.5), std::pair(0.5, 2.0)}) {
        widest = widestOpening(parts, part);
        if (chosen == nullptr && widest != nullptr && widest->opening >= opens) chosen = widest;
    }
    if (chosen == nullptr)
        throw Error(concat(
            "the lattice has no limb at ", textOf(point),
            ": no section between there and the rest is narrow (the widest opening is ",
            widest == nullptr ? 1.0 : std::round(100 * widest->opening) / 100,
            "; expected 1.5 or more in a third of the lattice, or 2 in a half); select a ball, the "
            "vertices near the point, or those beyond a face"));
    std::vector<Index> cells;
    for (std::size_t i = 0; i < chosen->count; ++i) cells.push_back(reached[i].cell);
    return limbOf(complex, positions, std::move(cells), chosen->opening);
}

Limb selectBeyond(const far::CellComplex& complex, std::span<const Point3> positions, Index face) {
    requireCells("selectBeyond", complex, positions);
    if (face < 0 || face >= complex.count(2))
        throw ArgumentError("selectBeyond", "face", std::to_string(face),
                            concat("0 to ", complex.count(2) - 1));
    const auto cells = complex.relation(2, 3)[face];
    if (cells.size() != 2)
        throw ArgumentError("selectBeyond", "face", std::to_string(face),
                            "a face between two cells; this one is on the boundary");
    const auto all = nearOne(positions);
    const auto [low, high] = std::minmax(cells[0], cells[1]);
    Side first = sideOf(complex, all, face, low), second = sideOf(complex, all, face, high);
    const bool isSecond = second.volume < first.volume * (1 - kEqual);
    return limbOf(complex, positions, std::move(isSecond ? second.cells : first.cells), 1);
}

Index nearestInnerFace(const far::CellComplex& complex, std::span<const Point3> positions,
                       const Point3& point) {
    requireCells("nearestInnerFace", complex, positions);
    requireFinite("nearestInnerFace", "point", point);
    const Index face = nearestFace(complex, positions, point, true);
    if (face < 0) throw Error("no face of the lattice is between two cells");
    return face;
}

}  // namespace espalier::shapes
