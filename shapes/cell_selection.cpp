// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/cell_distances.h>
#include <espalier/shapes/cell_selection.h>

#include <cmath>
#include <string>

#include "cell_sections.h"
#include "checks.h"
#include "distance_weights.h"

namespace espalier::shapes {
namespace {

/// Returns true for each vertex that is listed.
std::vector<char> marked(const std::string& function, std::span<const Index> vertices,
                         Index count) {
    std::vector<char> isMarked(count, 0);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (vertices[i] < 0 || vertices[i] >= count)
            throw ArgumentError(function, indexed("vertices", i), std::to_string(vertices[i]),
                                concat("0 to ", count - 1));
        isMarked[vertices[i]] = 1;
    }
    return isMarked;
}

std::vector<Index> listed(const std::vector<char>& isMarked) {
    std::vector<Index> vertices;
    for (std::size_t v = 0; v < isMarked.size(); ++v)
        if (isMarked[v] != 0) vertices.push_back(static_cast<Index>(v));
    return vertices;
}

/// Gives the vertices at the other ends of the edges of marked or unmarked vertices the same mark.
std::vector<Index> spread(const std::string& function, const far::CellComplex& complex,
                          std::span<const Index> vertices, int steps, char mark) {
    requireAtLeast(function, "steps", steps, 0);
    auto isMarked = marked(function, vertices, complex.count(0));
    for (int step = 0; step < steps; ++step) {
        auto next = isMarked;
        for (Index edge = 0; edge < complex.count(1); ++edge) {
            const auto ends = complex.relation(1, 0)[edge];
            if (isMarked[ends[0]] == mark) next[ends[1]] = mark;
            if (isMarked[ends[1]] == mark) next[ends[0]] = mark;
        }
        if (next == isMarked) break;
        isMarked = std::move(next);
    }
    return listed(isMarked);
}

}  // namespace

std::vector<Index> growSelection(const far::CellComplex& complex, std::span<const Index> vertices,
                                 int steps) {
    return spread("growSelection", complex, vertices, steps, 1);
}

std::vector<Index> shrinkSelection(const far::CellComplex& complex, std::span<const Index> vertices,
                                   int steps) {
    return spread("shrinkSelection", complex, vertices, steps, 0);
}

std::vector<double> selectAlongCells(const far::CellComplex& complex,
                                     std::span<const Point3> positions,
                                     std::span<const Index> vertices, const Falloff& falloff) {
    requireCells("selectAlongCells", complex, positions);
    const auto isSelected = marked("selectAlongCells", vertices, complex.count(0));
    std::vector<WayStart> starts;
    for (const Index vertex : listed(isSelected)) starts.push_back({vertex, 0});
    const auto distances = distancesAlongCells(complex, positions, starts);
    return weightsOfDistances("selectAlongCells", positions, falloff,
                              [&](std::size_t vertex) { return distances[vertex]; });
}

std::vector<double> selectNear(const far::CellComplex& complex, std::span<const Point3> positions,
                               const Point3& point, double radius, const Falloff& falloff) {
    requireCells("selectNear", complex, positions);
    requireFinite("selectNear", "point", point);
    if (!(radius >= 0) || !std::isfinite(radius))
        throw ArgumentError("selectNear", "radius", textOf(radius), "a finite number of 0 or more");
    const auto starts = waysFrom(point, complex, positions, nearestCell(complex, positions, point));
    const auto distances = distancesAlongCells(complex, positions, starts);
    return weightsOfDistances("selectNear", positions, falloff,
                              [&](std::size_t vertex) { return distances[vertex] - radius; });
}

Section selectionBorder(const far::CellComplex& complex, std::span<const Point3> positions,
                        std::span<const Index> vertices) {
    requireCells("selectionBorder", complex, positions);
    const auto isSelected = marked("selectionBorder", vertices, complex.count(0));
    const auto allSelected = [&](std::span<const Index> some) {
        for (const Index vertex : some)
            if (isSelected[vertex] == 0) return false;
        return true;
    };
    std::vector<char> isWhole(complex.count(3));
    for (Index cell = 0; cell < complex.count(3); ++cell)
        isWhole[cell] = static_cast<char>(allSelected(complex.relation(3, 0)[cell]));
    std::vector<Index> faces = facesBetween(complex, isWhole);
    if (faces.empty())
        for (Index face = 0; face < complex.count(2); ++face)
            if (isWhole[complex.relation(2, 3)[face].front()] == 0 &&
                allSelected(complex.relation(2, 0)[face]))
                faces.push_back(face);
    if (faces.empty())
        throw Error(
            "the selection has no border: expected selected vertices that are all vertices of a "
            "face, and others that are not selected");
    return sectionOf(complex, positions, std::move(faces));
}

}  // namespace espalier::shapes
