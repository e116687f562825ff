// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/petsc/distributed_table.h>

#include <cstdint>

#include "ranks.h"
#include "support/test.h"

// Every rank builds the same whole table, and passes its own part. The result must be the same part
// of the reference's result for the whole table.
namespace espalier::petsc {
namespace {

using stencils::StencilTable;

constexpr Index kPoints = 301, kVertices = 97;

std::vector<double> reference(const StencilTable<double>& table, const std::vector<double>& values,
                              int components) {
    std::vector<double> result(table.rowCount() * components);
    const auto layout = osd::BufferDescriptor::packed(components);
    osd::ReferenceEvaluator::evaluate(table, values, layout, result, layout, {0, table.rowCount()});
    return result;
}

/// Returns a bound of the rounding error of each result: the number of its products times the sum
/// of their absolute values.
std::vector<double> bounds(const StencilTable<double>& table, const std::vector<double>& values,
                           int components) {
    std::vector<double> result;
    for (Index row = 0; row < table.rowCount(); ++row)
        for (int c = 0; c < components; ++c) {
            double size = 0;
            for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                size += std::abs(table.weights(row)[k] *
                                 values[table.columns(row)[k] * components + c]);
            // Two sums of n products in different orders. The rounding of products and sums makes
            // each sum wrong by at most n/2 ulp of the size.
            result.push_back(double(table.columns(row).size()) *
                             std::numeric_limits<double>::epsilon() * size);
        }
    return result;
}

void expectOwnPart(const std::vector<double>& got, const std::vector<double>& all,
                   const std::vector<double>& bound, OwnedRange own, int components) {
    ASSERT_EQ(got.size(), std::size_t(own.count() * components));
    const auto first = std::size_t(own.first * components);
    for (std::size_t i = 0; i < got.size(); ++i)
        EXPECT_LE(std::abs(got[i] - all[first + i]), bound[first + i]) << "number " << i;
}

struct Case {
    Spread points, vertices;
    int components;
};

class DistributedTableTest : public ::testing::TestWithParam<Case> {};

// MATMAIJ has separate code for these component counts: for 1 it uses D itself, for 3 a specialised
// kernel, for 13 the general one.
INSTANTIATE_TEST_SUITE_P(Spreads, DistributedTableTest,
                         ::testing::Values(Case{Spread::Even, Spread::Even, 3},
                                           Case{Spread::Even, Spread::Even, 1},
                                           Case{Spread::Even, Spread::Even, 13},
                                           Case{Spread::Uneven, Spread::Even, 3},
                                           Case{Spread::Even, Spread::Uneven, 3},
                                           Case{Spread::AllOnFirst, Spread::AllOnLast, 3},
                                           Case{Spread::AllOnLast, Spread::AllOnFirst, 3},
                                           Case{Spread::Even, Spread::AllOnLast, 2},
                                           Case{Spread::AllOnFirst, Spread::Uneven, 1}));

TEST_P(DistributedTableTest, AgreesWithTheReference) {
    const int components = GetParam().components;
    const auto table = randomTable(kPoints, kVertices, 1);
    const OwnedRange points = ownRange(kPoints, GetParam().points);
    const OwnedRange vertices = ownRange(kVertices, GetParam().vertices);
    DistributedTable distributed(MPI_COMM_WORLD, ownRows(table, points), vertices.count(),
                                 components);
    EXPECT_EQ(distributed.ownPoints().count(), points.count());
    EXPECT_EQ(distributed.ownVertices().count(), vertices.count());
    EXPECT_EQ(distributed.components(), components);
    EXPECT_EQ(distributed.pointCount(), kPoints);
    EXPECT_EQ(distributed.vertexCount(), kVertices);

    const auto values = randomValues(kVertices * components, 2);
    std::vector<double> got(points.count() * components, 99);
    distributed.evaluate(ownValues(values, vertices, components), got);
    expectOwnPart(got, reference(table, values, components), bounds(table, values, components),
                  points, components);

    const auto transpose = stencils::transposeTable(table);
    const auto gradients = randomValues(kPoints * components, 3);
    std::vector<double> back(vertices.count() * components, 99);
    distributed.evaluateAdjoint(ownValues(gradients, points, components), back);
    expectOwnPart(back, reference(transpose, gradients, components),
                  bounds(transpose, gradients, components), vertices, components);
}

TEST_P(DistributedTableTest, CountsGhostVertices) {
    const auto table = randomTable(kPoints, kVertices, 1);
    const OwnedRange points = ownRange(kPoints, GetParam().points);
    const OwnedRange vertices = ownRange(kVertices, GetParam().vertices);
    const auto rows = ownRows(table, points);
    const DistributedTable distributed(MPI_COMM_WORLD, rows, vertices.count(),
                                       GetParam().components);
    std::set<Index> others;
    for (const Index column : rows.columns())
        if (column < distributed.ownVertices().first || column >= distributed.ownVertices().last)
            others.insert(column);
    EXPECT_EQ(distributed.ghostCount(), Offset(others.size()));
}

// The same table, evaluated repeatedly, and an equal table give the same results bit for bit,
// whatever the order of messages.
TEST(DistributedTable, ResultsAreReproducible) {
    constexpr Index kMany = 20'000;
    const auto table = randomTable(kMany, kVertices, 4);
    const OwnedRange points = ownRange(kMany, Spread::Uneven);
    const OwnedRange vertices = ownRange(kVertices, Spread::Even);
    const auto rows = ownRows(table, points);
    const auto values = ownValues(randomValues(3 * kVertices, 5), vertices, 3);
    const auto gradients = ownValues(randomValues(3 * kMany, 6), points, 3);
    std::vector<double> forward(gradients.size()), back(values.size());
    std::vector<double> firstForward, firstBack;
    for (int made = 0; made < 2; ++made) {
        DistributedTable distributed(MPI_COMM_WORLD, rows, vertices.count());
        for (int repetition = 0; repetition < 50; ++repetition) {
            distributed.evaluate(values, forward);
            distributed.evaluateAdjoint(gradients, back);
            if (firstForward.empty() && firstBack.empty()) {
                firstForward = forward;
                firstBack = back;
            }
            EXPECT_EQ(forward, firstForward);
            EXPECT_EQ(back, firstBack);
        }
    }
}

TEST(DistributedTable, MovesWithItsMatrices) {
    const auto table = randomTable(kPoints, kVertices, 1);
    const OwnedRange points = ownRange(kPoints, Spread::Even);
    const OwnedRange vertices = ownRange(kVertices, Spread::Even);
    const auto make = [&](int components) {
        return DistributedTable(MPI_COMM_WORLD, ownRows(table, points), vertices.count(),
                                components);
    };
    DistributedTable distributed = make(1);
    distributed = make(3);
    DistributedTable moved = std::move(distributed);
    PetscInt rows = 0, columns = 0;
    ASSERT_EQ(MatGetSize(moved.matrix(), &rows, &columns), 0);
    EXPECT_EQ(rows, kPoints);
    EXPECT_EQ(columns, kVertices);
    ASSERT_EQ(MatGetLocalSize(moved.blocked(), &rows, &columns), 0);
    EXPECT_EQ(rows, 3 * points.count());
    EXPECT_EQ(columns, 3 * vertices.count());
    std::vector<double> got(3 * points.count());
    const auto values = randomValues(3 * kVertices, 2);
    moved.evaluate(ownValues(values, vertices, 3), got);
    expectOwnPart(got, reference(table, values, 3), bounds(table, values, 3), points, 3);
}

TEST(DistributedTable, MayHaveNoPointsAtAll) {
    const OwnedRange vertices = ownRange(kVertices, Spread::Even);
    DistributedTable distributed(MPI_COMM_WORLD, randomTable(0, kVertices, 1), vertices.count());
    std::vector<double> none, gradients(3 * vertices.count(), 7);
    distributed.evaluate(gradients, none);
    distributed.evaluateAdjoint(none, gradients);
    EXPECT_EQ(gradients, std::vector<double>(gradients.size(), 0));
}

TEST(EvenRange, EqualsPetscsSplit) {
    for (const Offset total : {0, 1, 2, 7, 97, 1000}) {
        PetscInt local = PETSC_DECIDE;
        auto all = static_cast<PetscInt>(total);
        ASSERT_EQ(PetscSplitOwnership(MPI_COMM_WORLD, &local, &all), 0);
        const OwnedRange own = evenRange(total, test::rank(), rankCount());
        EXPECT_EQ(own.count(), local);
        std::int64_t last = 0;
        const std::int64_t count = own.count();
        MPI_Scan(&count, &last, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
        EXPECT_EQ(own.last, last);
    }
}

}  // namespace
}  // namespace espalier::petsc
