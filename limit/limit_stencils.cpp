// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/argument_error.h>
#include <espalier/base/parallel.h>
#include <espalier/base/sort_unique.h>
#include <espalier/embed/regular_cells.h>
#include <espalier/limit/limit_stencils.h>
#include <espalier/limit/vertex_limits.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/level_rows.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "limit_place.h"

namespace espalier::limit {
namespace {

/// Returns the derivatives up to an order: 1, 4 or 10 of them.
std::vector<Orders> ordersUpTo(int derivatives) {
    std::vector<Orders> orders = {kPosition};
    if (derivatives > 0) orders.insert(orders.end(), kFirst.begin(), kFirst.end());
    if (derivatives > 1) orders.insert(orders.end(), kSecond.begin(), kSecond.end());
    return orders;
}

/// Maximum number of further levels, whatever the tolerance. On the last of them, cells are 1e-13
/// times as large as on the first level.
constexpr int kMaxLevels = 43;

/// A location during the descent, with the cell of the current level that contains it.
struct Walker {
    std::size_t location;
    embed::CellFrame frame;
    std::array<double, 3> uvw;
};

/// Locations with their places on the levels below the level of the locations.
struct Walk {
    stencils::Levels levels;  ///< level 0 is the level of the locations
    /// For each level, the locations that end on it.
    std::vector<std::vector<std::size_t>> locations = {};
    /// For each level, one place for each of its `locations`.
    std::vector<std::vector<LimitPlace>> places = {};
};

/// Goes to the half of the cell along each axis that contains the place: changes `uvw` to the place
/// in this child, and returns the corner of the child.
std::size_t stepInto(std::array<double, 3>& uvw) {
    std::size_t corner = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool isHigh = uvw[axis] > 0.5;
        uvw[axis] = 2 * uvw[axis] - isHigh;
        corner |= std::size_t{isHigh} << axis;
    }
    return corner;
}

std::vector<Index> cellsOf(const std::vector<Walker>& walkers) {
    std::vector<Index> cells;
    for (const Walker& walker : walkers) cells.push_back(walker.frame.cell);
    sortUnique(cells);
    return cells;
}

/// Ends the walkers in regular or small cells: moves them to the places of the level.
void settle(Walk& walk, std::vector<Walker>& walkers, double tolerance) {
    const int level = walk.levels.finest();
    const far::Level& here = walk.levels.finestLevel();
    const std::vector<Index> cells = cellsOf(walkers);
    std::vector<double> sizes(cells.size(), level >= kMaxLevels ? 0.0 : 1.0);
    if (level >= levelsToShrink(1, tolerance) && level < kMaxLevels && !cells.empty())
        sizes = cellSizes(walk.levels, cells);
    walk.locations.emplace_back();
    walk.places.emplace_back();
    std::erase_if(walkers, [&](const Walker& walker) {
        const bool isRegular = embed::isRegularCell(here, walker.frame.cell);
        const auto cell = std::lower_bound(cells.begin(), cells.end(), walker.frame.cell);
        if (!isRegular && sizes[cell - cells.begin()] > tolerance) return false;
        walk.locations.back().push_back(walker.location);
        walk.places.back().push_back({level, FramePlace{walker.frame, walker.uvw, {}, !isRegular}});
        return true;
    });
}

/// Takes the remaining walkers to the next level.
void refine(Walk& walk, std::vector<Walker>& walkers, std::span<const LimitLocation> locations) {
    const far::CellComplex parent = walk.levels.finestLevel().complex;
    walk.levels.refineAround(cellsOf(walkers));
    const far::Refinement& refinement = walk.levels.refiner().refinement(walk.levels.finest());
    for (Walker& walker : walkers) {
        const std::size_t corner = stepInto(walker.uvw);
        const auto child = embed::childOf(parent, refinement, walker.frame, corner);
        if (!child)
            throw Error("place " + std::to_string(walker.location) + ", in cell " +
                        std::to_string(locations[walker.location].cell) +
                        ", is in the part of the lattice that the boundary mode 'open' removes");
        walker.frame = *child;
    }
}

/// Builds the rows of the places of one level, a block of rows for each derivative in `orders`.
stencils::StencilTable<double> rowsOf(const Walk& walk, std::size_t level, const PlaceRows& rows,
                                      std::span<const Orders> orders) {
    const std::size_t placeCount = walk.places[level].size();
    return stencils::buildTable(
        static_cast<Index>(placeCount * orders.size()),
        walk.levels.refiner().level(static_cast<int>(level)).complex.count(0),
        [&](Index row, stencils::RowAccumulator& accumulator) {
            const auto& order = orders[row / placeCount];
            // Each level doubles the derivative by a coordinate.
            const double scale =
                std::ldexp(1.0, static_cast<int>(level) * (order[0] + order[1] + order[2]));
            for (const auto& [vertex, weight] : rows.weights(row % placeCount, order))
                accumulator.add(vertex, scale * weight);
        });
}

/// Builds the rows of a chunk of locations over the vertices of their level, a block of rows for
/// each derivative.
stencils::StencilTable<double> rowsOf(const far::Level& level,
                                      const far::RefinerOptions& refinerOptions,
                                      std::span<const LimitLocation> locations,
                                      std::vector<Walker> walkers,
                                      const std::vector<Orders>& orders, double tolerance) {
    const std::size_t first = walkers.front().location, count = walkers.size();
    Walk walk{stencils::Levels(far::TopologyRefiner(level, refinerOptions))};
    for (;;) {
        settle(walk, walkers, tolerance);
        if (walkers.empty()) break;
        refine(walk, walkers, locations);
    }
    const std::span derivatives = std::span(orders).subspan(1);
    std::vector<stencils::StencilTable<double>> rows, derivativeRows;
    for (std::size_t k = 0; k < walk.places.size(); ++k) {
        const PlaceRows ofPlaces(walk.levels, static_cast<int>(k), walk.places[k]);
        rows.push_back(rowsOf(walk, k, ofPlaces, std::span(orders).first(1)));
        if (!derivatives.empty()) derivativeRows.push_back(rowsOf(walk, k, ofPlaces, derivatives));
    }
    const auto tables = stencils::composeRows(walk.levels.tables(), std::move(rows),
                                              stencils::compositionOf(walk.levels.tables()));
    if (!derivatives.empty())
        derivativeRows = stencils::composeDerivatives(
            walk.levels.tables(), std::move(derivativeRows), stencils::RowMeaning::Vectors);
    // The table and row that hold a location and derivative.
    struct Source {
        const stencils::StencilTable<double>* table;
        Index row;
    };
    std::vector<Source> sources(count * orders.size());
    for (std::size_t k = 0; k < walk.places.size(); ++k) {
        const std::size_t here = walk.locations[k].size();
        for (std::size_t i = 0; i < here; ++i) {
            const std::size_t location = walk.locations[k][i] - first;
            sources[location] = {&tables[k], static_cast<Index>(i)};
            for (std::size_t o = 0; o < derivatives.size(); ++o)
                sources[(o + 1) * count + location] = {&derivativeRows[k],
                                                       static_cast<Index>(o * here + i)};
        }
    }
    return stencils::buildTable(static_cast<Index>(sources.size()), level.complex.count(0),
                                [&](Index row, stencils::RowAccumulator& accumulator) {
                                    const auto& [table, source] = sources[row];
                                    const auto columns = table->columns(source);
                                    const auto weights = table->weights(source);
                                    for (std::size_t e = 0; e < columns.size(); ++e)
                                        accumulator.add(columns[e], weights[e]);
                                });
}

void checkOptions(const LimitStencilOptions& options) {
    checkLimitTolerance(options.tolerance, "tolerance");
    if (options.derivatives < 0 || options.derivatives > 2)
        throw ArgumentError("", "derivatives", std::to_string(options.derivatives), "0 to 2");
}

Walker walkerAt(const far::CellComplex& complex, std::size_t location, const LimitLocation& at) {
    const std::string name = "place " + std::to_string(location);
    if (at.cell < 0 || at.cell >= complex.count(3))
        throw Error(name + " is in cell " + std::to_string(at.cell) + "; there are " +
                    std::to_string(complex.count(3)) + " cells");
    // A coordinate that is a sum may exceed 1 by rounding.
    constexpr double kRounding = 1e-14;
    std::array<double, 3> uvw;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        uvw[axis] = std::clamp(at.uvw[axis], 0.0, 1.0);
        if (std::abs(at.uvw[axis] - uvw[axis]) <= kRounding) continue;
        throw Error(concat(name, " is at ", at.uvw[axis], "; expected 0 to 1"));
    }
    const auto frame = embed::frameOf(complex, at.cell);
    if (!frame)
        throw Error(name + " is in cell " + std::to_string(at.cell) + ", which is no hexahedron");
    return {location, *frame, uvw};
}

/// Splits a table into its blocks of rows.
LimitStencils blocksOf(const stencils::StencilTable<double>& table, std::size_t blockCount) {
    const auto block = [&](std::size_t number) {
        std::vector<Index> rows(table.rowCount() / blockCount);
        std::iota(rows.begin(), rows.end(), static_cast<Index>(number * rows.size()));
        return stencils::selectRows(table, rows);
    };
    LimitStencils result;
    result.position = block(0);
    for (std::size_t i = 0; i < 3 && 1 + i < blockCount; ++i) result.first[i] = block(1 + i);
    for (std::size_t i = 0; i < 6 && 4 + i < blockCount; ++i) result.second[i] = block(4 + i);
    return result;
}

}  // namespace

LimitStencils buildLimitStencils(const far::TopologyRefiner& refiner, int level,
                                 std::span<const LimitLocation> locations,
                                 const LimitStencilOptions& options) {
    const far::Level& here = refiner.level(level);
    if (here.complex.dimension() != 3)
        throw Error(
            "places in cells have limits in lattices only; on meshes and curves, vertices have "
            "limits");
    checkOptions(options);
    const std::vector<Orders> orders = ordersUpTo(options.derivatives);
    // Locations of a chunk share the cells that they refine. Each chunk repeats some of the work of
    // a level.
    constexpr Offset kGrain = 1 << 13;
    const Offset count = std::ssize(locations);
    std::vector<stencils::StencilTable<double>> chunks((count + kGrain - 1) / kGrain);
    parallelFor(count, kGrain, [&](Offset first, Offset last) {
        std::vector<Walker> walkers;
        for (Offset i = first; i < last; ++i)
            walkers.push_back(walkerAt(here.complex, i, locations[i]));
        chunks[first / kGrain] = rowsOf(here, refiner.options(), locations, std::move(walkers),
                                        orders, options.tolerance);
    });
    const auto rows = stencils::buildTable(
        static_cast<Index>(count * std::ssize(orders)), here.complex.count(0),
        [&](Index row, stencils::RowAccumulator& accumulator) {
            const Offset i = row % count, chunk = i / kGrain;
            const Offset size = std::min(kGrain, count - chunk * kGrain);
            const auto source = static_cast<Index>(row / count * size + i % kGrain);
            const auto& table = chunks[chunk];
            for (std::size_t e = 0; e < table.columns(source).size(); ++e)
                accumulator.add(table.columns(source)[e], table.weights(source)[e]);
        });
    const stencils::CompactTable compact = stencils::compactColumns(rows);
    return blocksOf(
        stencils::multiply(compact.table, stencils::buildStencils(refiner, level, compact.columns)),
        orders.size());
}

LimitStencils buildLimitStencils(const far::TopologyRefiner& refiner, int level,
                                 const LimitStencilOptions& options) {
    checkOptions(options);
    LimitStencils result;
    if (options.derivatives > 0) {
        const far::Level& here = refiner.level(level);
        std::vector<LimitLocation> locations;
        std::vector<Index> rowOf(here.complex.count(0), kMaxIndex);
        for (Index vertex = 0; vertex < here.complex.count(0); ++vertex) {
            if (here.strata.isOpen({0, vertex})) continue;
            for (const Index cell : here.complex.relation(0, 3)[vertex]) {
                const auto frame = embed::frameOf(here.complex, cell);
                if (!frame) continue;
                const std::size_t corner =
                    std::find(frame->corners.begin(), frame->corners.end(), vertex) -
                    frame->corners.begin();
                rowOf[vertex] = static_cast<Index>(locations.size());
                locations.push_back(
                    {cell,
                     {double(embed::bitOf(corner, 0)), double(embed::bitOf(corner, 1)),
                      double(embed::bitOf(corner, 2))}});
                break;
            }
        }
        const auto found = buildLimitStencils(refiner, level, locations, options);
        const auto spread = [&](const stencils::StencilTable<double>& table) {
            return stencils::buildTable(
                here.complex.count(0), table.columnCount(),
                [&](Index vertex, stencils::RowAccumulator& accumulator) {
                    const Index row = rowOf[vertex];
                    if (row == kMaxIndex) return;
                    for (std::size_t e = 0; e < table.columns(row).size(); ++e)
                        accumulator.add(table.columns(row)[e], table.weights(row)[e]);
                });
        };
        for (std::size_t i = 0; i < 3; ++i) result.first[i] = spread(found.first[i]);
        for (std::size_t i = 0; options.derivatives > 1 && i < 6; ++i)
            result.second[i] = spread(found.second[i]);
    }
    result.position = buildVertexLimits(refiner, level);
    return result;
}

}  // namespace espalier::limit
