// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/stencils/cell_solver.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/continuity.h>
#include <espalier/stencils/local_binding.h>
#include <espalier/stencils/place_points.h>

#include <algorithm>
#include <string>

#include "point_descent.h"

namespace espalier::stencils {
namespace {

using Extent = far::TopologyRefiner::Extent;
using Flags = std::vector<std::uint8_t>;

std::size_t at(Index index) {
    return static_cast<std::size_t>(index);
}

std::vector<Index> flagged(const Flags& flags) {
    std::vector<Index> result;
    for (std::size_t i = 0; i < flags.size(); ++i)
        if (flags[i]) result.push_back(static_cast<Index>(i));
    return result;
}

/// The columns with a weight, ascending. A weight below is the rounding of a place on the side of a
/// cell: places are found to 1e-12 of the size of the lattice.
std::vector<Index> columnsOf(const StencilTable<double>& table) {
    constexpr double kRounding = 1e-11;
    Flags isNamed(at(table.columnCount()));
    for (Index row = 0; row < table.rowCount(); ++row)
        for (std::size_t k = 0; k < table.columns(row).size(); ++k)
            if (std::abs(table.weights(row)[k]) > kRounding) isNamed[at(table.columns(row)[k])] = 1;
    return flagged(isNamed);
}

/// The cells with a marked vertex, ascending.
std::vector<Index> cellsAt(const far::CellComplex& complex, const Flags& vertices) {
    Flags isTouching(at(complex.count(3)));
    for (const Index vertex : flagged(vertices))
        for (const Index cell : complex.relation(0, 3)[vertex]) isTouching[at(cell)] = 1;
    return flagged(isTouching);
}

/// Marks the vertices of cells.
Flags verticesOf(const far::CellComplex& complex, std::span<const Index> cells) {
    Flags isVertex(at(complex.count(0)));
    for (const Index cell : cells)
        for (const Index vertex : complex.relation(3, 0)[cell]) isVertex[at(vertex)] = 1;
    return isVertex;
}

/// Faces, and what bounds them.
far::ByEntity<std::uint8_t> closureOf(const far::CellComplex& complex,
                                      std::span<const Index> faces) {
    far::ByEntity<std::uint8_t> isIn;
    for (int d = 0; d <= 3; ++d) isIn[at(d)].resize(at(complex.count(d)));
    for (const Index face : faces) {
        if (face < 0 || face >= complex.count(2))
            throw Error("there is no face " + std::to_string(face) + " to hold; the lattice has " +
                        std::to_string(complex.count(2)));
        isIn[2][at(face)] = 1;
        for (int d = 0; d < 2; ++d)
            for (const Index part : complex.relation(2, d)[face]) isIn[at(d)][at(part)] = 1;
    }
    return isIn;
}

/// The cells that hold points.
std::vector<Index> cellsHolding(const FoundCells& found, const far::CellComplex& complex,
                                std::span<const Point3> points, CellSolver::Scale scale) {
    const CellSolver solver(complex, found.positions, scale);
    std::vector<std::vector<Index>> cellsOf(points.size());
    for (std::size_t i = 0; i < found.cells.size(); ++i)
        for (Offset k = found.offsets[i]; k < found.offsets[i + 1]; ++k) {
            const Index point = found.points[static_cast<std::size_t>(k)];
            const Eigen::Vector3d position(points[at(point)].data());
            if (solver.boxOf(far::CellId(found.cells[i])).contains(position))
                cellsOf[at(point)].push_back(found.cells[i]);
        }
    std::vector<Index> holding;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto inside = solver.locateIn(Eigen::Vector3d(points[i].data()), cellsOf[i]);
        // In the gap between cells, whichever of them it is that carries the point.
        if (inside)
            holding.push_back(inside->place->cell.value);
        else
            holding.insert(holding.end(), cellsOf[i].begin(), cellsOf[i].end());
    }
    return holding;
}

/// What moves the vertices of the cells that hold points, and of those around.
std::vector<Index> columnsAround(const PointDescent& descent, CellSolver::Scale scale, int level,
                                 std::span<const Point3> points) {
    const auto found = descent.descend(points, level, Sought::Containing, Extent::Ring);
    if (!found) return {};
    const far::CellComplex& complex = found->refiner.level(level).complex;
    const Flags held = verticesOf(complex, cellsHolding(*found, complex, points, scale));
    const auto vertices = flagged(verticesOf(complex, cellsAt(complex, held)));
    return columnsOf(composeStencils<double>(found->refiner, found->tables, vertices));
}

}  // namespace

std::vector<Index> verticesHoldingFaces(const far::TopologyRefiner& base, Rules rules,
                                        std::span<const Index> faces, Continuity continuity) {
    if (base.dimension() != 3 || base.maxLevel() != 0)
        throw Error("faces are held of a lattice that has not been refined");
    if (base.boundary() == far::Boundary::Open)
        throw Error(
            "without boundary control no face can be held: the region is smaller than the lattice");
    if (faces.empty()) throw Error("there are no faces to hold");
    // On the first level, which has a vertex for each entity, a vertex in the cells at the faces
    // still depends on its own entity alone. From the second one on, those there depend on the same
    // vertices.
    constexpr int kLevel = 2;
    far::TopologyRefiner refiner = base;
    std::vector<StencilTable<double>> tables;
    auto isHeld = closureOf(refiner.level(0).complex, faces);
    for (int k = 1; k <= kLevel; ++k) {
        const auto cells = cellsAt(refiner.level(k - 1).complex, isHeld[0]);
        refiner.refineAround(cells, k == kLevel ? Extent::Cells : Extent::Ring);
        isHeld = refiner.refinement(k).inherit(isHeld);
        tables.push_back(buildLevelTable(refiner, k, rules));
    }
    const far::CellComplex& complex = refiner.level(kLevel).complex;
    const Flags vertices =
        continuity == Continuity::C0 ? isHeld[0] : verticesOf(complex, cellsAt(complex, isHeld[0]));
    return columnsOf(composeStencils<double>(refiner, tables, flagged(vertices)));
}

std::vector<Index> verticesHoldingPoints(const far::TopologyRefiner& base,
                                         std::span<const Point3> positions, int level, Rules rules,
                                         std::span<const Point3> points, Continuity continuity,
                                         double tolerance) {
    checkBase(base, positions, level);
    checkPointCount(points);
    if (points.empty()) throw Error("there are no points to hold");
    if (continuity == Continuity::C0)
        return columnsOf(
            bindPoints<double>(base, positions, level, rules, points, {.tolerance = tolerance})
                .binding.table);
    const auto scale = CellSolver::scaleOf(positions, tolerance);
    const PointDescent descent(base, positions, rules, scale);
    const std::vector<Index> order = alongCurve(points);
    constexpr Offset kGroupSize = 1 << 11;
    std::vector<std::vector<Index>> columns(
        static_cast<std::size_t>((std::ssize(points) + kGroupSize - 1) / kGroupSize));
    far::parallelFor(std::ssize(points), kGroupSize, [&](Offset first, Offset last) {
        std::vector<Point3> own;
        for (Offset i = first; i < last; ++i)
            own.push_back(points[at(order[static_cast<std::size_t>(i)])]);
        columns[static_cast<std::size_t>(first / kGroupSize)] =
            columnsAround(descent, scale, level, own);
    });
    Flags isFrozen(positions.size());
    for (const auto& group : columns)
        for (const Index column : group) isFrozen[at(column)] = 1;
    return flagged(isFrozen);
}

}  // namespace espalier::stencils
