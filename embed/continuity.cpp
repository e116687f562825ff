// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/cell_solver.h>
#include <espalier/embed/continuity.h>
#include <espalier/embed/length_unit.h>
#include <espalier/embed/local_binding.h>
#include <espalier/embed/place_points.h>
#include <espalier/embed/point_descent.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

namespace espalier::embed {
namespace {

using Extent = far::TopologyRefiner::Extent;
using Flags = std::vector<std::uint8_t>;

std::vector<Index> flagged(const Flags& flags) {
    std::vector<Index> result;
    for (std::size_t i = 0; i < flags.size(); ++i)
        if (flags[i]) result.push_back(static_cast<Index>(i));
    return result;
}

/// The columns with a weight above a limit, ascending.
std::vector<Index> columnsOf(const stencils::StencilTable<double>& table, double limit) {
    Flags isNamed(table.columnCount());
    for (Index row = 0; row < table.rowCount(); ++row)
        for (std::size_t k = 0; k < table.columns(row).size(); ++k)
            if (std::abs(table.weights(row)[k]) > limit) isNamed[table.columns(row)[k]] = 1;
    return flagged(isNamed);
}

/// What a vertex may move, of its own displacement, and still count as moving nothing. Where sums
/// should cancel, or a place lie on the side of a cell, rounding leaves some 1e-16 to 1e-12.
constexpr double kRounding = 1e-11;

/// The same for vertices of a level. Its cells are 2^-level of a base cell, so that a second
/// derivative is 4^level times a second difference, of four times a weight at most: it is this that
/// is to be some kRounding at most. The weights that the next layer comes in by, some 8^-level,
/// are above it to level 36.
double roundingOf(int level) {
    return std::ldexp(kRounding, -2 * level);
}

/// The cells with a marked vertex, ascending.
std::vector<Index> cellsAt(const far::CellComplex& complex, const Flags& vertices) {
    Flags isTouching(complex.count(3));
    for (const Index vertex : flagged(vertices))
        for (const Index cell : complex.relation(0, 3)[vertex]) isTouching[cell] = 1;
    return flagged(isTouching);
}

/// Marks the vertices of cells.
Flags verticesOf(const far::CellComplex& complex, std::span<const Index> cells) {
    Flags isVertex(complex.count(0));
    for (const Index cell : cells)
        for (const Index vertex : complex.relation(3, 0)[cell]) isVertex[vertex] = 1;
    return isVertex;
}

/// Faces, and what bounds them.
ByEntity<std::uint8_t> closureOf(const far::CellComplex& complex, std::span<const Index> faces) {
    ByEntity<std::uint8_t> isIn;
    for (int d = 0; d <= 3; ++d) isIn[d].resize(complex.count(d));
    for (const Index face : faces) {
        if (face < 0 || face >= complex.count(2))
            throw Error("there is no face " + std::to_string(face) + " to hold; the lattice has " +
                        std::to_string(complex.count(2)));
        isIn[2][face] = 1;
        for (int d = 0; d < 2; ++d)
            for (const Index part : complex.relation(2, d)[face]) isIn[d][part] = 1;
    }
    return isIn;
}

/// A group of points that lie together.
struct HeldGroup {
    std::vector<Index> columns;         ///< what moves the cells that carry them, or those around
    std::vector<PointStatus> statuses;  ///< one a point
};

/// Finds what moves the cells that carry points, as bindPoints() has it, and those around. Any
/// number of threads may ask.
class HoldingSearch {
public:
    /// \param base, positions must outlive this
    HoldingSearch(const far::TopologyRefiner& base, std::span<const Point3> positions, int level,
                  stencils::Rules rules, const EmbeddingOptions& options)
        : level_(level),
          seekNearest_(options.outside == OutsidePolicy::Nearest),
          scale_(CellSolver::scaleOf(positions, options.tolerance)),
          descent_(base, positions, rules, scale_) {}

    HeldGroup search(std::span<const Point3> points) const {
        HeldGroup group;
        group.statuses.assign(points.size(), PointStatus::Outside);
        auto unsettled = searchInside(points, group);
        std::erase_if(unsettled, [&](Index i) {
            const auto beyond =
                CellSolver::beyondReach(Eigen::Vector3d(points[i].data()), seekNearest_);
            if (beyond) group.statuses[i] = beyond->status;
            return beyond.has_value();
        });
        if (!unsettled.empty()) searchBeside(points, unsettled, group);
        return group;
    }

private:
    /// Adds what moves cells, or those around.
    void add(const Descent& found, std::span<const Index> cells, HeldGroup& group) const {
        const far::CellComplex& complex = found.refiner.level(level_).complex;
        const Flags held = verticesOf(complex, cells);
        const auto vertices = flagged(verticesOf(complex, cellsAt(complex, held)));
        const auto columns = columnsOf(
            stencils::composeStencils(found.refiner, found.tables, vertices), roundingOf(level_));
        group.columns.insert(group.columns.end(), columns.begin(), columns.end());
    }

    /// \return the points that may be in a gap between cells, and those outside that are carried
    std::vector<Index> searchInside(std::span<const Point3> points, HeldGroup& group) const {
        std::vector<Index> unsettled;
        const auto found = descent_.descend(points, level_, Sought::Containing, Extent::Ring);
        if (!found) {
            if (!seekNearest_) return {};
            unsettled.resize(points.size());
            std::iota(unsettled.begin(), unsettled.end(), Index{0});
            return unsettled;
        }
        const CellSolver solver(found->refiner.level(level_).complex, found->positions, scale_);
        const auto cells =
            found->candidates.cellsOfPoints(points.size(), [&](Index cell, Index point) {
                return solver.boxOf(CellId(cell)).contains(Eigen::Vector3d(points[point].data()));
            });
        std::vector<Index> holding;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto held = cells.of(static_cast<Index>(i));
            if (const auto inside = solver.locateIn(Eigen::Vector3d(points[i].data()), held)) {
                group.statuses[i] = inside->status;
                holding.push_back(inside->place->cell.value);
            } else if (seekNearest_ || !held.empty()) {
                unsettled.push_back(static_cast<Index>(i));
            }
        }
        add(*found, holding, group);
        return unsettled;
    }

    /// The same for points that are in no cell, by the nearest one.
    void searchBeside(std::span<const Point3> points, std::span<const Index> numbers,
                      HeldGroup& group) const {
        std::vector<Point3> beside;
        for (const Index i : numbers) beside.push_back(points[i]);
        const auto found = descent_.descend(beside, level_, Sought::Nearest, Extent::Ring);
        const CellSolver solver(found->refiner.level(level_).complex, found->positions, scale_);
        const auto cells =
            found->candidates.cellsOfPoints(beside.size(), [](Index, Index) { return true; });
        std::vector<Index> holding;
        for (std::size_t i = 0; i < beside.size(); ++i) {
            const Eigen::Vector3d point(beside[i].data());
            std::pair nearest(std::numeric_limits<double>::infinity(), kMaxIndex);
            for (const Index cell : cells.of(static_cast<Index>(i)))
                nearest = std::min(nearest, {solver.distance(point, CellId(cell)), cell});
            const auto located = solver.locateBeside(point, CellId(nearest.second), seekNearest_);
            group.statuses[numbers[i]] = located.status;
            if (located.place) holding.push_back(located.place->cell.value);
        }
        add(*found, holding, group);
    }

    int level_;
    bool seekNearest_;
    CellSolver::Scale scale_;
    PointDescent descent_;
};

void checkFinite(std::span<const Point3> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        for (const double coordinate : points[i])
            if (!std::isfinite(coordinate))
                throw Error("point " + std::to_string(i) + " to hold is not finite");
}

}  // namespace

std::vector<Index> verticesHoldingFaces(const far::TopologyRefiner& base, stencils::Rules rules,
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
    std::vector<stencils::StencilTable<double>> tables;
    auto isHeld = closureOf(refiner.level(0).complex, faces);
    for (int k = 1; k <= kLevel; ++k) {
        const auto cells = cellsAt(refiner.level(k - 1).complex, isHeld[0]);
        refiner.refineAround(cells, k == kLevel ? Extent::Cells : Extent::Ring);
        isHeld = refiner.refinement(k).inherit(isHeld);
        tables.push_back(stencils::buildLevelTable(refiner, k, rules));
    }
    const far::CellComplex& complex = refiner.level(kLevel).complex;
    const Flags vertices =
        continuity == Continuity::C0 ? isHeld[0] : verticesOf(complex, cellsAt(complex, isHeld[0]));
    return columnsOf(stencils::composeStencils(refiner, tables, flagged(vertices)),
                     roundingOf(kLevel));
}

std::vector<Index> verticesHoldingRows(const stencils::StencilTable<double>& deformation) {
    return columnsOf(deformation, kRounding);
}

std::vector<Index> verticesHoldingPoints(const far::TopologyRefiner& base,
                                         std::span<const Point3> positions, int level,
                                         stencils::Rules rules, std::span<const Point3> points,
                                         Continuity continuity, const EmbeddingOptions& options) {
    checkBase(base, positions, level);
    checkPointCount(points);
    if (points.empty()) throw Error("there are no points to hold");
    checkFinite(points);
    if (continuity == Continuity::C0)
        return verticesHoldingRows(
            bindPoints(base, positions, level, rules, points, options).binding.table);
    const LengthUnit unit(positions);
    const std::vector<Point3> restInUnits = unit.toUnits(positions);
    const std::vector<Point3> inUnits = unit.toUnits(points);
    const HoldingSearch search(base, restInUnits, level, rules, options);
    const std::vector<Index> order = alongCurve(inUnits);
    constexpr Offset kGroupSize = 1 << 11;
    std::vector<std::vector<Index>> columns((std::ssize(points) + kGroupSize - 1) / kGroupSize);
    std::vector<PointStatus> statuses(points.size());
    parallelFor(std::ssize(points), kGroupSize, [&](Offset first, Offset last) {
        std::vector<Point3> own;
        for (Offset i = first; i < last; ++i) own.push_back(inUnits[order[i]]);
        HeldGroup group = search.search(own);
        for (std::size_t i = 0; i < own.size(); ++i)
            statuses[order[static_cast<std::size_t>(first) + i]] = group.statuses[i];
        columns[first / kGroupSize] = std::move(group.columns);
    });
    if (options.outside == OutsidePolicy::Error) checkAllInside(points, statuses);
    Flags isFrozen(positions.size());
    for (const auto& group : columns)
        for (const Index column : group) isFrozen[column] = 1;
    return flagged(isFrozen);
}

}  // namespace espalier::embed
