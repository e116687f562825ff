// SPDX-License-Identifier: Apache-2.0
#include "cell_sections.h"

#include <espalier/base/bounding_box.h>
#include <espalier/base/error.h>
#include <espalier/base/vector3.h>
#include <espalier/shapes/cell_distances.h>

#include <cmath>
#include <utility>

#include "checks.h"

namespace espalier::shapes {

void requireCells(const std::string& function, const far::CellComplex& complex,
                  std::span<const Point3> positions) {
    if (complex.dimension() != 3 || complex.count(3) == 0)
        throw Error(function + ": expected a lattice: a complex with cells");
    if (std::ssize(positions) != complex.count(0))
        throw Error(concat(function, ": got ", positions.size(), " positions for ",
                           complex.count(0), " vertices"));
    requireFinite("positions", positions);
    // The cube of the size is the largest number in volumes.
    constexpr double kMaxSize = 1e90;
    if (!(BoundingBox(positions).diagonal() <= kMaxSize))
        throw Error(function + ": the positions are more than 1e90 apart");
}

std::vector<Index> facesBetween(const far::CellComplex& complex, std::span<const char> isMarked) {
    std::vector<Index> faces;
    for (Index face = 0; face < complex.count(2); ++face) {
        const auto cells = complex.relation(2, 3)[face];
        if (cells.size() == 2 && isMarked[cells[0]] != isMarked[cells[1]]) faces.push_back(face);
    }
    return faces;
}

Section sectionOf(const far::CellComplex& complex, std::span<const Point3> positions,
                  std::vector<Index> faces) {
    Section section;
    Point3 moment = {0, 0, 0};
    // Relative to a vertex, so that a lattice far from the origin loses no digits.
    const Point3 origin = faces.empty() ? Point3{} : loopOf(complex, positions, faces[0]).front();
    for (const Index face : faces) {
        const auto loop = loopOf(complex, positions, face);
        const double area = length(areaVector(loop));
        section.area += area;
        moment = sum(moment, scaled(difference(mean(loop), origin), area));
    }
    if (!(section.area > 0)) throw Error("the section has no area");
    section.center = sum(origin, scaled(moment, 1 / section.area));
    section.faces = std::move(faces);
    return section;
}

}  // namespace espalier::shapes
