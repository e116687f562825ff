// SPDX-License-Identifier: Apache-2.0
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <limits>

#include "support/complexes.h"
#include "support/test.h"
#include "support/threads.h"

namespace espalier::stencils {
namespace {

TEST(Multiply, IsTheProductOfMatrices) {
    const StencilTable<double> left(3, {0, 2, 2, 3}, {0, 2, 1}, {2, 3, 5});
    const StencilTable<double> right(2, {0, 1, 2, 4}, {1, 0, 0, 1}, {7, 11, 13, 17});
    // Row 0: 2·(0, 7) + 3·(13, 17); row 1 empty; row 2: 5·(11, 0).
    EXPECT_EQ(multiply(left, right),
              StencilTable<double>(2, {0, 2, 2, 3}, {0, 1, 0}, {39, 65, 55}));
    EXPECT_THROW(multiply(right, left), Error);
}

// The product adds four terms at a time. Terms that fill up the last four use no row of the table.
TEST(Multiply, ARowThatIsNotUsedMayBeInfinite) {
    const double infinity = std::numeric_limits<double>::infinity();
    const StencilTable<double> left(2, {0, 1, 2}, {0, 1}, {1, 1});
    const StencilTable<double> right(2, {0, 1, 2}, {0, 1}, {infinity, 3});
    EXPECT_EQ(multiply(left, right), right);
}

/// Returns rows of up to `longest` entries, each row within `band` columns.
StencilTable<double> randomTable(Index rows, Index columns, Index longest, Index band,
                                 unsigned seed) {
    std::mt19937 random(seed);
    Array<Offset> offsets = {0};
    Array<Index> all;
    Array<double> weights;
    for (Index row = 0; row < rows; ++row) {
        const Index first = Index(random() % unsigned(std::max(columns - band, Index{1})));
        std::vector<Index> chosen;
        for (Index k = Index(random() % unsigned(longest + 1)); k > 0; --k)
            chosen.push_back(std::min(first + Index(random() % unsigned(band)), columns - 1));
        std::sort(chosen.begin(), chosen.end());
        chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
        for (const Index column : chosen) {
            all.push_back(column);
            // Sums of multiples of 1/4 sometimes cancel exactly.
            weights.push_back(double(random() % 9) / 2 - 2.25);
        }
        offsets.push_back(Offset(all.size()));
    }
    return StencilTable<double>(columns, std::move(offsets), std::move(all), std::move(weights));
}

/// Multiplies entry by entry, by definition. The largest factor of a row comes last, as in
/// multiply(), so that sums agree to the last bit.
StencilTable<double> plainProduct(const StencilTable<double>& left,
                                  const StencilTable<double>& right) {
    Array<Offset> offsets = {0};
    Array<Index> columns;
    Array<double> weights;
    for (Index row = 0; row < left.rowCount(); ++row) {
        const auto factors = left.weights(row);
        std::vector<std::size_t> turns;
        for (std::size_t k = 0; k < factors.size(); ++k) turns.push_back(k);
        const auto largest =
            std::max_element(turns.begin(), turns.end(), [&](std::size_t a, std::size_t b) {
                return std::abs(factors[a]) < std::abs(factors[b]);
            });
        if (!turns.empty()) std::rotate(largest, largest + 1, turns.end());
        std::map<Index, double> sums;
        for (const std::size_t k : turns) {
            const Index middle = left.columns(row)[k];
            for (std::size_t i = 0; i < right.columns(middle).size(); ++i)
                sums[right.columns(middle)[i]] += factors[k] * right.weights(middle)[i];
        }
        for (const auto& [column, sum] : sums) {
            if (sum == 0) continue;
            columns.push_back(column);
            weights.push_back(sum);
        }
        offsets.push_back(Offset(columns.size()));
    }
    return StencilTable<double>(right.columnCount(), std::move(offsets), std::move(columns),
                                std::move(weights));
}

// The tables have rows that share all, some or none of their columns; rows without entries; sums
// that cancel; rows wider than any block; and more rows than a thread takes at once.
TEST(Multiply, IsThePlainProductToTheLastBit) {
    struct Case {
        Index rows, middles, columns, longest, band;
    };
    for (const Case& each : {Case{5000, 300, 40, 12, 30}, Case{5000, 2000, 900, 9, 20},
                             Case{60, 2000, 3000, 200, 2000}, Case{50, 1, 1, 1, 1}}) {
        const auto left = randomTable(each.rows, each.middles, each.longest, each.band, 1);
        const auto right = randomTable(each.middles, each.columns, each.longest, each.band, 2);
        EXPECT_EQ(multiply(left, right), plainProduct(left, right)) << each.rows;
    }
}

TEST(Multiply, DoesNotDependOnOrderOrThreads) {
    const auto left = randomTable(20000, 500, 9, 40, 3), right = randomTable(500, 200, 20, 30, 4);
    const auto expected = plainProduct(left, right);
    std::mt19937 random(5);
    for (const Index groupCount : {1, 7, 3000}) {
        std::vector<Index> groups(20000);
        for (Index& group : groups) group = Index(random() % unsigned(groupCount));
        const RowOrder order(groups, groupCount);
        for (const int threads : {1, 3})
            EXPECT_EQ(withThreads(threads, [&] { return multiply(left, right, order); }), expected)
                << groupCount;
    }
}

// Sums that cancel leave gaps between the rows, which are closed.
TEST(Multiply, PutsRowsIntoTheirSlots) {
    const auto left = randomTable(9000, 500, 9, 40, 6), right = randomTable(500, 200, 20, 30, 7);
    std::mt19937 random(8);
    std::vector<Index> groups(9000), slots(9000), rowOf(9000);
    for (Index& group : groups) group = Index(random() % 5);
    std::iota(slots.begin(), slots.end(), Index{0});
    std::shuffle(slots.begin(), slots.end(), random);
    for (std::size_t row = 0; row < slots.size(); ++row)
        rowOf[std::size_t(slots[row])] = Index(row);
    const auto expected = selectRows<double>(plainProduct(left, right), rowOf);
    for (const int threads : {1, 3})
        EXPECT_EQ(
            withThreads(threads, [&] { return multiply(left, right, RowOrder(groups, 5), slots); }),
            expected);
}

TEST(Multiply, CompactColumnsKeepTheProduct) {
    const StencilTable<double> table(9, {0, 2, 3}, {3, 8, 3}, {.25, .75, 1});
    const CompactTable compact = compactColumns(table);
    EXPECT_THAT(compact.columns, ElementsAre(3, 8));
    EXPECT_EQ(compact.table, StencilTable<double>(2, {0, 2, 3}, {0, 1, 0}, {.25, .75, 1}));
    const CompactTable again = compactColumns(compact.table);
    EXPECT_THAT(again.columns, ElementsAre(0, 1));
    EXPECT_EQ(again.table, compact.table);
}

TEST(RowOrder, KeepsGroupsTogetherAndTheirRowsInOrder) {
    const RowOrder order(std::vector<Index>{2, 0, 2, 1, 0}, 3);
    EXPECT_THAT(order.rows(), ElementsAre(1, 4, 3, 0, 2));
    EXPECT_TRUE(order.isSameGroup(0, 1));
    EXPECT_FALSE(order.isSameGroup(1, 2));
    EXPECT_EQ(RowOrder().row(7), 7);
    EXPECT_TRUE(RowOrder().isSameGroup(3, 9));
}

// In a box of unit cells, the base entity that contains a refined vertex in its interior is the one
// whose centre has the vertex's coordinates, with 1/2 in place of coordinates that are not
// integers.
TEST(BaseEntities, ContainTheVerticesInTheirInterior) {
    const Lattice box = shapes::box({.cells = {2, 1, 1}, .max = {2, 1, 1}});
    TopologyRefiner refiner = test::refined(box.complex, 3);
    const auto centre = [&](int dimension, Index index) {
        Point3 sum{};
        const auto vertices = box.complex.relation(dimension, 0)[index];
        for (const Index vertex : vertices)
            for (std::size_t c = 0; c < 3; ++c)
                sum[c] += box.positions[vertex][c] / double(vertices.size());
        return sum;
    };
    std::vector<Point3> centres;
    for (int d = 0; d <= 3; ++d)
        for (Index index = 0; index < box.complex.count(d); ++index)
            centres.push_back(centre(d, index));
    // By linear precision, the vertices of a level are at the points of a finer grid.
    const auto positions = refinePositions(refiner, 3, box.positions);
    const auto origins = baseEntities(refiner, 3);
    ASSERT_EQ(origins.back().count(), Index(centres.size()));
    const auto ofVertices = origins.back().of(0);
    ASSERT_EQ(ofVertices.size(), positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) {
            const double x = positions[v][c], whole = std::round(x);
            const bool isOnVertex = std::abs(x - whole) < 1e-12;
            EXPECT_EQ(centres[ofVertices[v]][c], isOnVertex ? whole : std::floor(x) + 0.5);
        }
}

}  // namespace
}  // namespace espalier::stencils
