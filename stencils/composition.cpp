// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/error.h>
#include <espalier/base/parallel.h>
#include <espalier/stencils/composition.h>
#include <espalier/stencils/table_builder.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "repeated_rows.h"
#include "vertex_parents.h"

namespace espalier::stencils {
namespace {

/// Returns the rows of the identity for some columns.
StencilTable<double> selectionTable(Index columnCount, std::span<const Index> columns) {
    Array<Offset> offsets(columns.size() + 1);
    std::iota(offsets.begin(), offsets.end(), Offset{0});
    return {columnCount,
            std::move(offsets),
            {columns.begin(), columns.end()},
            Array<double>(columns.size(), 1.0)};
}

/// Adds the product of a table and values to `sums`: `components` per source entry and per row,
/// entry after entry.
void addProduct(const StencilTable<double>& table, std::span<const double> values, int components,
                std::span<double> sums) {
    const std::size_t width = components;
    parallelFor(table.rowCount(), 4096, [&](Offset first, Offset last) {
        for (Offset row = first; row < last; ++row) {
            const auto columns = table.columns(static_cast<Index>(row));
            const auto weights = table.weights(static_cast<Index>(row));
            for (std::size_t k = 0; k < columns.size(); ++k)
                for (std::size_t c = 0; c < width; ++c)
                    sums[row * width + c] += weights[k] * values[columns[k] * width + c];
        }
    });
}

/// Carries values of level k − 1 to level k by R_k. Only a part of the rows of R_k is in memory at
/// a time.
std::vector<double> refinedOnce(const far::TopologyRefiner& refiner, int level,
                                std::span<const double> values, int components) {
    // Each part takes time for all columns, so there are few parts.
    constexpr Offset kMinRows = 1 << 15, kMaxParts = 32;
    const Offset rowCount = refiner.level(level).complex.count(0);
    const Offset step = std::max(kMinRows, rowCount / kMaxParts);
    std::vector<double> result(rowCount * components, 0);
    std::vector<Index> rows;
    for (Offset first = 0; first < rowCount; first += step) {
        rows.resize(std::min(step, rowCount - first));
        std::iota(rows.begin(), rows.end(), static_cast<Index>(first));
        addProduct(buildLevelTable(refiner, level, rows), values, components,
                   std::span(result).subspan(first * components));
    }
    return result;
}

}  // namespace

void checkVertices(const far::TopologyRefiner& refiner, int level,
                   std::span<const Index> vertices) {
    const Index count = refiner.level(level).complex.count(0);
    for (const Index vertex : vertices)
        if (vertex < 0 || vertex >= count)
            throw Error("there is no vertex " + std::to_string(vertex) + " on level " +
                        std::to_string(level) + ", which has " + std::to_string(count) +
                        " vertices");
}

CompactTable compactColumns(StencilTable<double> table) {
    std::vector<Index> slot(table.columnCount(), 0);
    for (const Index column : table.columns()) slot[column] = 1;
    CompactTable compact;
    for (Index column = 0; column < table.columnCount(); ++column) {
        Index& at = slot[column];
        if (at == 0) continue;
        at = static_cast<Index>(compact.columns.size());
        compact.columns.push_back(column);
    }
    const auto count = static_cast<Index>(compact.columns.size());
    if (count == table.columnCount()) {
        compact.table = std::move(table);
        return compact;
    }
    compact.table = renumberColumns(table, count, [&](Index column) { return slot[column]; });
    return compact;
}

namespace {

/// Returns the rows of S_level for the given vertices, by multiplication.
/// \param origins of levels 0 to `level` − 1
/// \param rowsOf rowsOf(k, vertices) returns the rows of R_k for some vertices of level k
template <class RowsOf>
StencilTable<double> compose(const far::TopologyRefiner& refiner, int level,
                             std::span<const BaseEntities> origins, std::span<const Index> vertices,
                             RowsOf rowsOf) {
    // First from the finest level down: find the rows that each level needs of the level before.
    // Then multiply from the base up.
    struct Link {
        StencilTable<double> table;
        RowOrder order;
    };
    std::vector<Link> chain;
    std::vector<Index> demanded(vertices.begin(), vertices.end());
    for (int k = level; k > 1; --k) {
        const VertexParents parents(refiner, k);
        const BaseEntities& origin = origins[k - 1];
        std::vector<Index> groups;
        groups.reserve(demanded.size());
        for (const Index vertex : demanded) groups.push_back(origin.of(parents(vertex)));
        CompactTable compact = compactColumns(rowsOf(k, demanded));
        chain.push_back({std::move(compact.table), RowOrder(groups, origin.count())});
        demanded = std::move(compact.columns);
    }
    StencilTable<double> product = rowsOf(1, demanded);
    for (; !chain.empty(); chain.pop_back())
        product = multiply(chain.back().table, product, chain.back().order);
    return product;
}

}  // namespace

template <class Real>
StencilTable<Real> buildStencils(const far::TopologyRefiner& refiner, int level,
                                 std::span<const Index> vertices) {
    checkVertices(refiner, level, vertices);
    if (level == 0)
        return convertTable<Real>(selectionTable(refiner.level(0).complex.count(0), vertices));
    const std::vector<BaseEntities> origins = baseEntities(refiner, level - 1);
    const auto rowsOf = [&](int k, std::span<const Index> demanded) {
        return buildLevelTable(refiner, k, demanded);
    };
    if (RepeatedRows::isApplicable(refiner, level)) {
        const RepeatedRows rows(refiner, level, origins, vertices);
        const bool isAll = rows.representatives().size() == vertices.size();
        auto distinctRows =
            convertTable<Real>(compose(refiner, level, origins, rows.representatives(), rowsOf));
        return isAll ? distinctRows : rows.expand(distinctRows);
    }
    return convertTable<Real>(compose(refiner, level, origins, vertices, rowsOf));
}

StencilTable<double> composeStencils(const far::TopologyRefiner& refiner,
                                     std::span<const StencilTable<double>> tables,
                                     std::span<const Index> vertices) {
    const int level = static_cast<int>(tables.size());
    if (level < 1 || level > refiner.maxLevel())
        throw Error("got " + std::to_string(level) + " level tables for " +
                    std::to_string(refiner.maxLevel()) + " levels");
    for (int k = 1; k <= level; ++k) {
        const auto& table = tables[k - 1];
        const Index rows = refiner.level(k).complex.count(0);
        const Index columns = refiner.level(k - 1).complex.count(0);
        if (table.rowCount() != rows || table.columnCount() != columns)
            throw Error("the table of level " + std::to_string(k) + " is " +
                        std::to_string(table.rowCount()) + " × " +
                        std::to_string(table.columnCount()) + "; expected " + std::to_string(rows) +
                        " × " + std::to_string(columns));
    }
    checkVertices(refiner, level, vertices);
    return compose(refiner, level, baseEntities(refiner, level - 1), vertices,
                   [&](int k, std::span<const Index> demanded) {
                       return selectRows(tables[k - 1], demanded);
                   });
}

template <class Real>
StencilTable<Real> buildStencils(const far::TopologyRefiner& refiner, int level) {
    std::vector<Index> all(refiner.level(level).complex.count(0));
    std::iota(all.begin(), all.end(), Index{0});
    return buildStencils<Real>(refiner, level, all);
}

template StencilTable<float> buildStencils(const far::TopologyRefiner&, int,
                                           std::span<const Index>);
template StencilTable<double> buildStencils(const far::TopologyRefiner&, int,
                                            std::span<const Index>);
template StencilTable<float> buildStencils(const far::TopologyRefiner&, int);
template StencilTable<double> buildStencils(const far::TopologyRefiner&, int);

std::vector<StencilTable<double>> buildLevelTables(const far::TopologyRefiner& refiner, int level) {
    refiner.level(level);  // Throws if the level does not exist.
    std::vector<StencilTable<double>> tables;
    for (int k = 1; k <= level; ++k) tables.push_back(buildLevelTable(refiner, k));
    return tables;
}

std::vector<double> refineValues(const far::TopologyRefiner& refiner, int level,
                                 std::span<const double> values, int components) {
    refiner.level(level);  // Throws if the level does not exist.
    const Index baseCount = refiner.level(0).complex.count(0);
    if (components < 1 || std::ssize(values) != Offset{baseCount} * components)
        throw Error("got " + std::to_string(values.size()) + " values; expected " +
                    std::to_string(components) + " for each of " + std::to_string(baseCount) +
                    " vertices");
    std::vector<double> result(values.begin(), values.end());
    for (int k = 1; k <= level; ++k) result = refinedOnce(refiner, k, result, components);
    return result;
}

namespace {

std::vector<double> toValues(std::span<const Point3> positions) {
    std::vector<double> values;
    values.reserve(3 * positions.size());
    for (const Point3& position : positions)
        values.insert(values.end(), position.begin(), position.end());
    return values;
}

std::vector<Point3> toPositions(std::span<const double> values) {
    std::vector<Point3> positions(values.size() / 3);
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    return positions;
}

}  // namespace

std::vector<Point3> applyLevelTable(const StencilTable<double>& table,
                                    std::span<const Point3> positions) {
    std::vector<double> result(Offset{3} * table.rowCount(), 0);
    addProduct(table, toValues(positions), 3, result);
    return toPositions(result);
}

std::vector<Point3> refinePositions(const far::TopologyRefiner& refiner, int level,
                                    std::span<const Point3> positions) {
    return toPositions(refineValues(refiner, level, toValues(positions), 3));
}

}  // namespace espalier::stencils
