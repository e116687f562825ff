// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/error.h>
#include <espalier/far/parallel.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace espalier::stencils {
namespace {

/// Rows of the identity.
template <class Real>
StencilTable<Real> selectionTable(Index columnCount, std::span<const Index> columns) {
    Array<Offset> offsets(columns.size() + 1);
    std::iota(offsets.begin(), offsets.end(), Offset{0});
    return StencilTable<Real>(columnCount, std::move(offsets), {columns.begin(), columns.end()},
                              Array<Real>(columns.size(), Real{1}));
}

/// A table times values of `components` a source entry, source by source.
std::vector<double> product(const StencilTable<double>& table, std::span<const double> values,
                            int components) {
    const auto width = static_cast<std::size_t>(components);
    std::vector<double> result(static_cast<std::size_t>(table.rowCount()) * width, 0);
    far::parallelFor(table.rowCount(), 4096, [&](Offset first, Offset last) {
        for (Offset row = first; row < last; ++row) {
            const auto columns = table.columns(static_cast<Index>(row));
            const auto weights = table.weights(static_cast<Index>(row));
            for (std::size_t k = 0; k < columns.size(); ++k)
                for (std::size_t c = 0; c < width; ++c)
                    result[static_cast<std::size_t>(row) * width + c] +=
                        weights[k] * values[static_cast<std::size_t>(columns[k]) * width + c];
        }
    });
    return result;
}

}  // namespace

CompactTable compactColumns(const StencilTable<double>& table) {
    std::vector<Index> place(static_cast<std::size_t>(table.columnCount()), 0);
    for (const Index column : table.columns()) place[static_cast<std::size_t>(column)] = 1;
    CompactTable compact;
    for (Index column = 0; column < table.columnCount(); ++column) {
        Index& at = place[static_cast<std::size_t>(column)];
        if (at == 0) continue;
        at = static_cast<Index>(compact.columns.size());
        compact.columns.push_back(column);
    }
    Array<Index> columns;
    columns.reserve(table.columns().size());
    for (const Index column : table.columns())
        columns.push_back(place[static_cast<std::size_t>(column)]);
    compact.table =
        StencilTable<double>(static_cast<Index>(compact.columns.size()),
                             {table.offsets().begin(), table.offsets().end()}, std::move(columns),
                             {table.weights().begin(), table.weights().end()});
    return compact;
}

template <class Real>
StencilTable<Real> buildStencils(const far::TopologyRefiner& refiner, int level, Rules rules,
                                 std::span<const Index> vertices) {
    refiner.level(level);  // Throws if it is not there.
    checkRules(refiner, rules);
    if (level == 0) return selectionTable<Real>(refiner.level(0).complex.count(0), vertices);
    // Down the levels: what each row needs of the level before. Then up: their products.
    struct Link {
        CompactTable table;
        RowOrder order;
    };
    const std::vector<BaseEntities> origins = baseEntities(refiner, level);
    std::vector<Link> chain;
    std::span<const Index> demanded = vertices;
    for (int k = level; k > 0; --k) {
        std::vector<Index> groups;
        for (const Index vertex : demanded)
            groups.push_back(
                origins[static_cast<std::size_t>(k)].of(0)[static_cast<std::size_t>(vertex)]);
        CompactTable table = compactColumns(buildLevelTable(refiner, k, rules, demanded));
        chain.push_back({std::move(table), RowOrder(groups, origins.front().count())});
        demanded = chain.back().table.columns;
    }
    StencilTable<double> product =
        selectionTable<double>(refiner.level(0).complex.count(0), demanded);
    for (; chain.size() > 1; chain.pop_back())
        product = multiply<double>(chain.back().table.table, product, chain.back().order);
    return multiply<Real>(chain.front().table.table, product, chain.front().order);
}

template <class Real>
StencilTable<Real> buildStencils(const far::TopologyRefiner& refiner, int level, Rules rules) {
    std::vector<Index> all(static_cast<std::size_t>(refiner.level(level).complex.count(0)));
    std::iota(all.begin(), all.end(), Index{0});
    return buildStencils<Real>(refiner, level, rules, all);
}

std::vector<double> refineValues(const far::TopologyRefiner& refiner, int level, Rules rules,
                                 std::span<const double> values, int components) {
    refiner.level(level);  // Throws if it is not there.
    checkRules(refiner, rules);
    const Index baseCount = refiner.level(0).complex.count(0);
    if (components < 1 ||
        values.size() != static_cast<std::size_t>(baseCount) * static_cast<std::size_t>(components))
        throw Error("got " + std::to_string(values.size()) + " values; expected " +
                    std::to_string(components) + " for each of " + std::to_string(baseCount) +
                    " vertices");
    std::vector<double> result(values.begin(), values.end());
    for (int k = 1; k <= level; ++k)
        result = product(buildLevelTable(refiner, k, rules), result, components);
    return result;
}

std::vector<Point3> refinePositions(const far::TopologyRefiner& refiner, int level, Rules rules,
                                    std::span<const Point3> positions) {
    std::vector<double> values;
    values.reserve(3 * positions.size());
    for (const Point3& position : positions)
        values.insert(values.end(), position.begin(), position.end());
    values = refineValues(refiner, level, rules, values, 3);
    std::vector<Point3> refined(values.size() / 3);
    for (std::size_t i = 0; i < refined.size(); ++i)
        refined[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    return refined;
}

template StencilTable<float> buildStencils(const far::TopologyRefiner&, int, Rules,
                                           std::span<const Index>);
template StencilTable<double> buildStencils(const far::TopologyRefiner&, int, Rules,
                                            std::span<const Index>);
template StencilTable<float> buildStencils(const far::TopologyRefiner&, int, Rules);
template StencilTable<double> buildStencils(const far::TopologyRefiner&, int, Rules);

}  // namespace espalier::stencils
