// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/memory.h>
#include <espalier/base/sort_unique.h>
#include <espalier/embed/bind_groups.h>
#include <espalier/embed/gradient_rows.h>
#include <espalier/embed/local_binding.h>
#include <espalier/embed/point_location.h>
#include <espalier/embed/regular_binding.h>
#include <espalier/embed/trilinear.h>
#include <espalier/far/standard_cells.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/level_rows.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <type_traits>
#include <unordered_map>
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

/// A level in which points were placed.
struct PlacedIn {
    const far::CellComplex& complex;
    std::span<const Point3> positions;                       ///< of the vertices, in units
    std::span<const stencils::StencilTable<double>> tables;  ///< R_1 to R_n for level n
    std::span<const Point3> rest;                            ///< the base, in units
};

/// Returns the places of points in hexahedra that are not flat, with vertices of the level as the
/// corners of cells.
CellPlaces cellPlacesIn(const PlacedIn& level, const Embedding& embedding) {
    CellPlaces cells;
    std::unordered_map<Index, Index> numbers;  // of the cells; -1 for other cells
    for (std::size_t i = 0; i < embedding.points.size(); ++i) {
        const auto& place = embedding.points[i].place;
        if (!place) continue;
        const auto [found, isNew] = numbers.try_emplace(place->cell.value, -1);
        if (isNew)
            if (const auto corners = far::hexahedronVertices(level.complex, place->cell)) {
                found->second = static_cast<Index>(cells.cells.size());
                cells.cells.push_back(*corners);
            }
        if (found->second < 0) continue;
        Trilinear::Corners corners;
        for (std::size_t k = 0; k < 8; ++k)
            corners[k] = Eigen::Vector3d(level.positions[cells.cells[found->second][k]].data());
        const Eigen::Vector3d uvw(place->uvw.data());
        if (!areFlat(Trilinear(corners).jacobian(uvw).transpose()))
            cells.places.push_back({static_cast<Index>(i), found->second, place->uvw});
    }
    return cells;
}

/// Renumbers the vertices of a level in gradients to those that are used. Returns these.
std::vector<Index> compactVertices(Gradients& gradients) {
    const auto& rows = gradients.rows;
    std::vector<Index> used(rows.columns().begin(), rows.columns().end());
    for (const CellPlaces::Cell& cell : gradients.cells.cells)
        used.insert(used.end(), cell.begin(), cell.end());
    sortUnique(used);
    for (CellPlaces::Cell& cell : gradients.cells.cells)
        for (Index& vertex : cell) vertex = indexIn(used, vertex);
    gradients.rows = stencils::renumberColumns(rows, static_cast<Index>(used.size()),
                                               [&](Index vertex) { return indexIn(used, vertex); });
    return used;
}

/// Returns the gradients of points.
/// \param stencilsFor returns the rows of S_n for some vertices of the level
template <class StencilsFor>
Gradients gradientsIn(const PlacedIn& level, const Embedding& embedding, const LengthUnit& unit,
                      StencilsFor stencilsFor) {
    // Differences of the vertices of deeper levels would round by more than 2⁶ units in the last
    // place of a displacement; and long rows of S are not made (needWholeLevel()). If the points
    // have several vertices each, rows over the base take less memory than the vertices.
    constexpr std::size_t kMaxLevel = 6;
    constexpr Offset kMostVertices = 4;
    const double perLength = unit.toUnits(1.0);
    const auto rowsOf = [&](const Embedding& points) {
        return buildDirectionTable(level.complex, points);
    };
    const bool isDeep = level.tables.size() > kMaxLevel ||
                        stencils::compositionOf(level.tables) == stencils::Composition::FromRows;
    CellPlaces cells;
    if (!isDeep) cells = cellPlacesIn(level, embedding);
    if (isDeep || 8 * std::ssize(cells.cells) > kMostVertices * std::ssize(embedding.points)) {
        std::vector<stencils::StencilTable<double>> rows;
        for (const auto& each : level.tables)
            rows.push_back(stencils::buildTable(0, each.columnCount(), [](Index, auto&) {}));
        rows.push_back(rowsOf(embedding));
        const auto directions = std::move(
            stencils::composeDerivatives(level.tables, std::move(rows), stencils::RowMeaning::Spans)
                .back());
        return gradientsOfRows(gradientRows(directions, level.rest, perLength));
    }
    Embedding others = embedding;  // The points in cells of other types, and in flat ones.
    for (const CellPlaces::Place& place : cells.places) others.points[place.point].place.reset();
    Gradients gradients = gradientsOfRows(gradientRows(rowsOf(others), level.positions, perLength));
    gradients.cells = std::move(cells);
    const std::vector<Index> used = compactVertices(gradients);
    gradients.vertices = stencilsFor(used);
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
                part.gradients = withoutPoints(
                    gradientsIn(
                        {levels.finestLevel().complex, levels.finestPositions(), levels.tables(),
                         levels.positions(0)},
                        located.embedding, *unitOfGradients,
                        [&](std::span<const Index> vertices) { return levels.stencils(vertices); }),
                    pointRows(part.table).emptyRows());
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
    Gradients gradients;  ///< empty if they were not requested
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
    const far::CellComplex& complex = refiner.level(level).complex;
    const std::vector<Point3> positions = stencils::refinePositions(refiner, level, rest);
    const auto embed = [&] {
        const PointLocator locator(complex, positions,
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
    if (options.gradients) {
        const auto tables = stencils::buildLevelTables(refiner, level);
        located.gradients =
            withoutPoints(gradientsIn({complex, positions, tables, rest}, embedding, unit,
                                      [&](std::span<const Index> vertices) {
                                          return stencils::buildStencils(refiner, level, vertices);
                                      }),
                          located.factors.points.emptyRows());
    }
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
    if (options.gradients) model.gradients = renumbered(std::move(located.gradients), order);
    orderRows(std::move(located.factors), located.byBaseCell, order, model.table);
    markWithoutRows(model);
    if (options.embedding.outside == OutsidePolicy::Error) checkAllInside(points, model.statuses);
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

/// Binds points by refinement, and gives the rows of each group to `sink`.
/// \param search a search in `lattice`, which is in units
/// \param options the policy for points outside is not OutsidePolicy::Error
void bindByRefinementInto(const RestLattice& lattice, const LengthUnit& unit,
                          const LevelSearch& search, std::span<const Point3> points,
                          const BindingOptions& options, RowSink sink) {
    // Points that are bound to the whole level get their rows all at once. So the level is made
    // anew for each of these many points, which takes less time than their rows.
    constexpr Offset kMostAtOnce = 1 << 18;
    for (Offset first = 0; first < std::ssize(points); first += kMostAtOnce) {
        const auto some = points.subspan(first, std::min(kMostAtOnce, std::ssize(points) - first));
        BindingOptions ofSome = options;
        if (options.progress)
            ofSome.progress = [&](Offset done) { options.progress(first + done); };
        const auto sinkAll = [&](std::span<const Index> numbers, BoundRows<> rows) {
            std::vector<Index> inAll(numbers.begin(), numbers.end());
            for (Index& number : inAll) number += static_cast<Index>(first);
            sink(inAll, std::move(rows));
        };
        if (!needWholeLevel(lattice.base.level(0).complex, options.level, std::ssize(some))) {
            bindGroupsInto(
                [&](std::span<const Point3> group) {
                    return bindGroup<stencils::StencilTable<double>>(
                        search, group, options.gradients ? &unit : nullptr);
                },
                lattice.base, unit, some, groupSizeFor(std::ssize(some)), ofSome, sinkAll);
            continue;
        }
        std::vector<Index> numbers(some.size());
        std::iota(numbers.begin(), numbers.end(), Index{0});
        sinkAll(numbers, bindToWholeLevel<stencils::StencilTable<double>>(
                             lattice.base, unit, lattice.positions, some, ofSome));
    }
}

}  // namespace

void bindInGroups(const RestLattice& lattice, std::span<const Point3> points,
                  const BindingOptions& options, RowSink sink) {
    checkRest(lattice, options.level);
    checkPointCount(points);
    const LengthUnit unit(lattice.positions);
    const std::vector<Point3> inUnits = unit.toUnits(lattice.positions);
    const RestLattice rest{lattice.base, inUnits};
    const LevelSearch search(rest, options.level, withoutRefusal(options.embedding));
    const RegularSearch regular(rest, search.descent(), spacingOf(options.level));
    bindRegularFirstInto(
        regular, unit, points, options, sink,
        [&](std::span<const Point3> others, const BindingOptions& ofOthers, RowSink sinkOthers) {
            bindByRefinementInto(rest, unit, search, others, ofOthers, sinkOthers);
        });
}

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
