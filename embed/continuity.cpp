// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/continuity.h>
#include <espalier/embed/length_unit.h>
#include <espalier/embed/place_points.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "level_search.h"

namespace espalier::embed {
namespace {

using Flags = std::vector<std::uint8_t>;

std::vector<Index> flagged(const Flags& flags) {
    std::vector<Index> result;
    for (std::size_t i = 0; i < flags.size(); ++i)
        if (flags[i]) result.push_back(static_cast<Index>(i));
    return result;
}

/// Returns the columns in which some weight exceeds a limit, ascending.
std::vector<Index> columnsOf(const stencils::StencilTable<double>& table, double limit) {
    Flags isNamed(table.columnCount());
    for (Index row = 0; row < table.rowCount(); ++row)
        for (std::size_t k = 0; k < table.columns(row).size(); ++k)
            if (std::abs(table.weights(row)[k]) > limit) isNamed[table.columns(row)[k]] = 1;
    return flagged(isNamed);
}

/// A vertex that moves a point by at most this fraction of its own displacement counts as not
/// moving it. Where weights should cancel, or a place is on a face of its cell, rounding leaves
/// 1e-16 to 1e-12.
constexpr double kRounding = 1e-11;

/// Returns the same limit for vertices of a level. A cell of the level is 2^-level of a base cell
/// across, so a second derivative is 4^level times a second difference, which is at most four times
/// a weight. This second derivative must not exceed about kRounding. The weights with which the
/// next layer enters, about 8^-level, exceed the limit up to level 36.
double roundingOf(int level) {
    return std::ldexp(kRounding, -2 * level);
}

/// Returns the cells with a marked vertex, ascending.
std::vector<Index> cellsAt(const far::CellComplex& complex, const Flags& vertices) {
    Flags isTouching(complex.count(3));
    for (const Index vertex : flagged(vertices))
        for (const Index cell : complex.relation(0, 3)[vertex]) isTouching[cell] = 1;
    return flagged(isTouching);
}

/// Returns flags that mark the vertices of some cells.
Flags verticesOf(const far::CellComplex& complex, std::span<const Index> cells) {
    Flags isVertex(complex.count(0));
    for (const Index cell : cells)
        for (const Index vertex : complex.relation(3, 0)[cell]) isVertex[vertex] = 1;
    return isVertex;
}

/// Returns flags that mark some faces with their edges and vertices.
ByEntity<std::uint8_t> closureOf(const far::CellComplex& complex, std::span<const Index> faces) {
    ByEntity<std::uint8_t> isIn;
    for (int d = 0; d <= 3; ++d) isIn[d].resize(complex.count(d));
    for (const Index face : faces) {
        if (face < 0 || face >= complex.count(2))
            throw Error("there is no face " + std::to_string(face) + " to hold; the lattice has " +
                        std::to_string(complex.count(2)) + " faces");
        isIn[2][face] = 1;
        for (int d = 0; d < 2; ++d)
            for (const Index part : complex.relation(2, d)[face]) isIn[d][part] = 1;
    }
    return isIn;
}

/// Returns the base vertices that move vertices of some cells of the finest level, or of the cells
/// around these.
std::vector<Index> columnsAround(const stencils::Levels& levels, std::span<const Index> cells) {
    const far::CellComplex& complex = levels.finestLevel().complex;
    const Flags held = verticesOf(complex, cells);
    const auto vertices = flagged(verticesOf(complex, cellsAt(complex, held)));
    return columnsOf(levels.stencils(vertices), roundingOf(levels.finest()));
}

void checkFinite(std::span<const Point3> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        for (const double coordinate : points[i])
            if (!std::isfinite(coordinate))
                throw Error("point " + std::to_string(i) + " to hold is not finite");
}

}  // namespace

std::vector<Index> verticesHoldingFaces(const far::TopologyRefiner& base,
                                        std::span<const Index> faces, Continuity continuity) {
    if (base.dimension() != 3 || base.maxLevel() != 0)
        throw Error("faces can be held only in a lattice (dimension 3) that has not been refined");
    if (base.boundary() == far::Boundary::Open)
        throw Error(
            "no face can be held with the boundary mode 'open': the refined region does not reach "
            "the boundary of the lattice");
    if (faces.empty()) throw Error("there are no faces to hold");
    // Level 1 has a vertex for each entity, and a vertex in the cells at the faces still depends on
    // its own entity alone. From level 2 on, the vertices there all depend on the same base
    // vertices.
    constexpr int kLevel = 2;
    stencils::Levels levels(base);
    auto isHeld = closureOf(base.level(0).complex, faces);
    for (int k = 1; k <= kLevel; ++k) {
        const auto cells = cellsAt(levels.finestLevel().complex, isHeld[0]);
        levels.refineAround(cells, k == kLevel ? Extent::Cells : Extent::Ring);
        isHeld = levels.refiner().refinement(k).inherit(isHeld);
    }
    const far::CellComplex& complex = levels.finestLevel().complex;
    const Flags vertices =
        continuity == Continuity::C0 ? isHeld[0] : verticesOf(complex, cellsAt(complex, isHeld[0]));
    return columnsOf(levels.stencils(flagged(vertices)), roundingOf(kLevel));
}

std::vector<Index> verticesHoldingRows(const stencils::StencilTable<double>& deformation) {
    return columnsOf(deformation, kRounding);
}

std::vector<Index> verticesHoldingPoints(const RestLattice& lattice, std::span<const Point3> points,
                                         Continuity continuity, const BindingOptions& options) {
    checkRest(lattice, options.level);
    checkPointCount(points);
    if (points.empty()) throw Error("there are no points to hold");
    checkFinite(points);
    if (continuity == Continuity::C0)
        return verticesHoldingRows(bindPoints(lattice, points, options).table);
    const LengthUnit unit(lattice.positions);
    const std::vector<Point3> restInUnits = unit.toUnits(lattice.positions);
    const std::vector<Point3> inUnits = unit.toUnits(points);
    const LevelSearch search({lattice.base, restInUnits}, options.level, options.embedding);
    const std::vector<Index> order = alongCurve(inUnits);
    constexpr Offset kGroupSize = 1 << 11;
    std::vector<std::vector<Index>> columns((std::ssize(points) + kGroupSize - 1) / kGroupSize);
    std::vector<PointStatus> statuses(points.size());
    parallelFor(std::ssize(points), kGroupSize, [&](Offset first, Offset last) {
        const auto numbers = std::span(order).subspan(first, last - first);
        auto& ofGroup = columns[first / kGroupSize];
        search.locate(chosenPoints(inUnits, numbers), Extent::Ring, [&](const LocatedPart& part) {
            std::vector<Index> holding;
            for (std::size_t i = 0; i < part.points.size(); ++i) {
                const LocatedPoint& located = part.embedding.points[i];
                statuses[numbers[part.points[i]]] = located.status;
                if (located.place) holding.push_back(located.place->cell.value);
            }
            if (!part.levels) return;
            for (const Index column : columnsAround(*part.levels, holding))
                ofGroup.push_back(part.baseVertices[column]);
        });
    });
    if (options.embedding.outside == OutsidePolicy::Error) checkAllInside(points, statuses);
    Flags isFrozen(lattice.positions.size());
    for (const auto& group : columns)
        for (const Index column : group) isFrozen[column] = 1;
    return flagged(isFrozen);
}

}  // namespace espalier::embed
