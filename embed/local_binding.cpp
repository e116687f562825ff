// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/embed/bind_groups.h>
#include <espalier/embed/local_binding.h>
#include <espalier/embed/point_location.h>
#include <espalier/embed/regular_binding.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/level_rows.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <type_traits>
#include <utility>

#include "level_search.h"

namespace espalier::embed {
namespace {

/// Returns true if a level has at most `maxCells` cells, by an estimate: each vertex of each base
/// cell becomes a cell of level 1, and each of these becomes eight cells on the next level.
bool hasAtMost(const far::CellComplex& base, int level, Offset maxCells) {
    auto cells = static_cast<double>(base.relation(3, 0).values().size());
    for (int k = 1; k < level; ++k) cells *= 8;
    return cells <= static_cast<double>(maxCells);
}

/// Returns true if points should be bound to the whole level, and not to the parts around them.
///
/// If there are as many points as cells, leaving cells out saves nothing, and neighbouring groups
/// would both refine the cells between them. But if rows of S are long, rows for all vertices of
/// the level take too much memory.
bool needWholeLevel(const far::CellComplex& base, int level, Offset pointCount) {
    return hasAtMost(base, level, pointCount) &&
           stencils::compositionAbove(base) == stencils::Composition::FromBase;
}

template <class Table>
Table rowsIn(const stencils::Levels& levels, const Embedding& embedding) {
    if constexpr (std::is_same_v<Table, stencils::StencilTable<double>>)
        return buildDeformationTable(levels, embedding);
    else
        return buildFactoredTable(levels, embedding);
}

/// Returns the gradients of points with a row in D, over the base of the level tables.
/// \param tables R_1 to R_n, where the embedding is in level n
/// \param table D, or W
/// \param rest the base, in units
GradientTables gradientTablesIn(const far::CellComplex& level,
                                std::span<const stencils::StencilTable<double>> tables,
                                const Embedding& embedding,
                                const stencils::StencilTable<double>& table,
                                std::span<const Point3> rest, const LengthUnit& unit) {
    std::vector<stencils::StencilTable<double>> rows;
    for (const auto& each : tables)
        rows.push_back(stencils::buildTable(0, each.columnCount(), [](Index, auto&) {}));
    rows.push_back(buildDirectionTable(level, embedding));
    const auto directions = std::move(
        stencils::composeDerivatives(tables, std::move(rows), stencils::RowMeaning::Spans).back());
    GradientTables gradients = gradientsOf(directions, rest, unit.toUnits(1.0));
    for (auto& gradient : gradients) gradient = emptyRows(std::move(gradient), table.emptyRows());
    return gradients;
}

template <class Table>
std::vector<BoundPart<Table>> bindGroup(const LevelSearch& search, std::span<const Point3> points,
                                        const LengthUnit* unitOfGradients = nullptr) {
    std::vector<BoundPart<Table>> parts;
    search.locate(points, far::TopologyRefiner::Extent::Cells, [&](LocatedPart located) {
        BoundPart<Table> part;
        part.points = std::move(located.points);
        for (const LocatedPoint& point : located.embedding.points)
            part.statuses.push_back(point.status);
        addCarried(located.embedding.points, part.carried);
        if (located.levels) {
            const stencils::Levels& levels = *located.levels;
            part.table = rowsIn<Table>(levels, located.embedding);
            if (unitOfGradients != nullptr)
                part.gradients = gradientTablesIn(levels.finestLevel().complex, levels.tables(),
                                                  located.embedding, pointRows(part.table),
                                                  levels.positions(0), *unitOfGradients);
            part.largestResidual = located.embedding.largestResidual(pointRows(part.table));
        }
        part.baseVertices = std::move(located.baseVertices);
        parts.push_back(std::move(part));
    });
    return parts;
}

/// Returns a lower bound of the mean of numbers between 0 and 1, given the mean `sampleMean` of a
/// random sample of `count` of them. The bound is wrong with a probability of one in a million.
///
/// Chernoff's bound: if the mean is smaller, such a sample has a probability of at most exp(−count
/// · D(sampleMean ‖ mean)), where D is the Kullback-Leibler divergence of two coins.
double lowerBoundOfMean(double sampleMean, int count) {
    const double divergence = std::log(1e6) / count;
    const auto term = [](double p, double q) { return p > 0 ? p * std::log(p / q) : 0; };
    double low = 0, high = sampleMean;
    for (int i = 0; i < 50; ++i) {
        const double mean = (low + high) / 2;
        const bool isTooFar = term(sampleMean, mean) + term(1 - sampleMean, 1 - mean) > divergence;
        (isTooFar ? low : high) = mean;
    }
    return low;
}

/// Throws if the rows of D exceed the memory limit, before they are computed: with thousands of
/// entries per row, computing them takes minutes. Estimates the number of entries from a sample of
/// the points.
/// \throws MemoryError
void requireForRows(const LevelSearch& search, const LengthUnit& unit,
                    std::span<const Point3> points, Index columnCount) {
    constexpr int kSampleSize = 64;
    if (points.size() < 4 * kSampleSize) return;
    // Twice: the rows of the groups, and D, which is gathered from them.
    constexpr auto kEntryBytes = static_cast<double>(2 * (sizeof(Index) + sizeof(double)));
    const double maxEntries = static_cast<double>(points.size()) * columnCount;
    const auto require = [&](double entries, double rowLength) {
        // No limit exceeds 2⁶³ bytes.
        const double bytes = std::min(kEntryBytes * entries, 0x1p63);
        requireMemory(static_cast<std::uint64_t>(bytes),
                      "binding " + std::to_string(points.size()) + " points with some " +
                          std::to_string(std::llround(rowLength)) + " weights each");
    };
    try {
        return require(maxEntries, columnCount);
    } catch (const MemoryError&) {
        // Most rows may be shorter, or empty.
    }
    std::mt19937 random(1);
    std::vector<Point3> sample;
    for (int i = 0; i < kSampleSize; ++i)
        sample.push_back(unit.toUnits(points[random() % points.size()]));
    Offset entryCount = 0;
    for (const auto& part : bindGroup<stencils::StencilTable<double>>(search, sample))
        entryCount += part.table.entryCount();
    const double rowLength = static_cast<double>(entryCount) / kSampleSize;
    require(maxEntries * lowerBoundOfMean(rowLength / columnCount, kSampleSize), rowLength);
}

/// Returns the number of neighbouring points that are bound together: they share the cells around
/// them. LevelSearch divides the group if the levels would have too many cells.
Offset groupSizeFor(Offset pointCount) {
    constexpr Offset kGroups = 16, kMin = 1 << 7, kMax = 1 << 14;
    return std::clamp(pointCount / kGroups, kMin, kMax);
}

/// Points in the whole level, without the level.
struct PointsInLevel {
    std::vector<PointStatus> statuses;
    double largestResidual;
    stencils::FactoredTable<double> factors;
    stencils::RowOrder byBaseCell;
    GradientTables gradients;  ///< 0 × 0 if they were not requested
    std::vector<CarriedPoint> carried;
};

/// Locates points in the whole level.
/// \param rest the positions of the lattice, in units
/// \param points in units, each near the one before
PointsInLevel locateInWholeLevel(far::TopologyRefiner refiner, std::span<const Point3> rest,
                                 std::span<const Point3> points, const BindingOptions& options,
                                 const LengthUnit& unit) {
    const int level = options.level;
    refiner.refineUniform(level);
    const auto embed = [&] {
        const far::CellComplex& complex = refiner.level(level).complex;
        const PointLocator locator(complex, stencils::refinePositions(refiner, level, rest),
                                   CellSolver::scaleOf(rest, options.embedding.tolerance));
        const bool seekNearest = options.embedding.outside == OutsidePolicy::Nearest;
        return locatePoints<CellPlace>(
            points, complex.count(0), OutsidePolicy::Keep, options.progress,
            [&](const Point3& point, bool) { return locator.locate(point, seekNearest); });
    };
    const Embedding embedding = embed();
    const stencils::BaseEntities origins = stencils::baseEntities(refiner, level).back();
    PointsInLevel located{{},
                          0,
                          buildFactoredTable(refiner, level, embedding),
                          orderByBaseCell(embedding, origins.of(3), origins.count()),
                          {},
                          {}};
    if (options.gradients)
        located.gradients = gradientTablesIn(refiner.level(level).complex,
                                             stencils::buildLevelTables(refiner, level), embedding,
                                             located.factors.points, rest, unit);
    located.largestResidual = embedding.largestResidual(located.factors.points);
    located.statuses.reserve(points.size());
    for (const LocatedPoint& point : embedding.points) located.statuses.push_back(point.status);
    addCarried(embedding.points, located.carried);
    return located;
}

/// Returns the row of each point, where the points of the rows are in `order`.
std::vector<Index> rowsOfPoints(std::span<const Index> order) {
    std::vector<Index> rowOf(order.size());
    for (std::size_t row = 0; row < order.size(); ++row)
        rowOf[order[row]] = static_cast<Index>(row);
    return rowOf;
}

/// Makes D or its factors from factors whose points are in another order.
/// \param order the points in the order of the factors
void orderRows(stencils::FactoredTable<double> factors, const stencils::RowOrder&,
               std::span<const Index> order, stencils::FactoredTable<double>& result) {
    result = {std::move(factors.vertices),
              stencils::selectRows<double>(factors.points, rowsOfPoints(order))};
}
void orderRows(const stencils::FactoredTable<double>& factors, const stencils::RowOrder& byCell,
               std::span<const Index> order, stencils::StencilTable<double>& result) {
    result = stencils::multiply(factors.points, factors.vertices, byCell, order);
}

/// Binds points to the whole level, all at once. The points are processed along a curve, but the
/// rows of D are computed in their final place.
/// \param rest the positions of the lattice, in units
template <class Table>
BoundRows<Table> bindToWholeLevel(const far::TopologyRefiner& base, const LengthUnit& unit,
                                  std::span<const Point3> rest, std::span<const Point3> points,
                                  const BindingOptions& options) {
    const std::vector<Index> order = alongCurve(points);
    PointsInLevel located =
        locateInWholeLevel(base, rest, unit.toUnits(chosenPoints(points, order)), options, unit);
    BoundRows<Table> model;
    model.statuses.resize(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) model.statuses[order[i]] = located.statuses[i];
    model.largestResidual = unit.fromUnits(located.largestResidual);
    for (const CarriedPoint& each : located.carried)
        model.carried.push_back({order[each.point], unit.fromUnits(each.away)});
    if (options.gradients) {
        model.gradients.emplace();
        const std::vector<Index> rowOf = rowsOfPoints(order);
        for (std::size_t axis = 0; axis < 3; ++axis)
            model.gradients->tables[axis] =
                stencils::selectRows<double>(located.gradients[axis], rowOf);
        located.gradients = {};
    }
    orderRows(std::move(located.factors), located.byBaseCell, order, model.table);
    completeStatuses(points, options.embedding.outside, model);
    return model;
}

/// Binds points to D or to its factors, by refinement.
/// \param search a search in `lattice`, which is in units
template <class Table>
BoundRows<Table> bindByRefinement(const RestLattice& lattice, const LengthUnit& unit,
                                  std::shared_ptr<const LevelSearch> search,
                                  std::span<const Point3> points, const BindingOptions& options) {
    const far::CellComplex& complex = lattice.base.level(0).complex;
    if (needWholeLevel(complex, options.level, std::ssize(points))) {
        search = nullptr;
        return bindToWholeLevel<Table>(lattice.base, unit, lattice.positions, points, options);
    }
    if constexpr (std::is_same_v<Table, stencils::StencilTable<double>>)
        if (stencils::compositionAbove(complex) == stencils::Composition::FromRows)
            requireForRows(*search, unit, points, complex.count(0));
    return bindGroups<Table>(
        [search = std::move(search), &options, &unit](std::span<const Point3> group) {
            return bindGroup<Table>(*search, group, options.gradients ? &unit : nullptr);
        },
        lattice.base, unit, points, groupSizeFor(std::ssize(points)), options);
}

}  // namespace

BoundRows<> bindPoints(const RestLattice& lattice, std::span<const Point3> points,
                       const BindingOptions& options) {
    checkRest(lattice, options.level);
    checkPointCount(points);
    const LengthUnit unit(lattice.positions);
    const std::vector<Point3> inUnits = unit.toUnits(lattice.positions);
    const RestLattice rest{lattice.base, inUnits};
    auto search = std::make_shared<const LevelSearch>(rest, options.level, options.embedding);
    const RegularSearch regular(rest, search->descent(), spacingOf(options.level));
    return bindRegularFirst(
        regular, unit, points, options,
        [&](std::span<const Point3> others, const BindingOptions& optionsOfOthers) {
            return bindByRefinement<stencils::StencilTable<double>>(rest, unit, std::move(search),
                                                                    others, optionsOfOthers);
        });
}

BoundRows<stencils::FactoredTable<double>> bindFactored(const RestLattice& lattice,
                                                        std::span<const Point3> points,
                                                        const BindingOptions& options) {
    checkRest(lattice, options.level);
    checkPointCount(points);
    const LengthUnit unit(lattice.positions);
    const std::vector<Point3> inUnits = unit.toUnits(lattice.positions);
    const RestLattice rest{lattice.base, inUnits};
    BindingOptions withoutGradients = options;
    withoutGradients.gradients = false;
    return bindByRefinement<stencils::FactoredTable<double>>(
        rest, unit, std::make_shared<const LevelSearch>(rest, options.level, options.embedding),
        points, withoutGradients);
}

}  // namespace espalier::embed
