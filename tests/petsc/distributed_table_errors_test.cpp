// SPDX-License-Identifier: Apache-2.0
#include <espalier/petsc/distributed_table.h>

#include <functional>
#include <optional>

#include "allocation_limit.h"
#include "ranks.h"
#include "refusals.h"
#include "support/test.h"

// An error on the last rank only is thrown on all ranks: a rank that continued would wait until the
// test times out.
namespace espalier::petsc {
namespace {

bool isLast() {
    return test::rank() == rankCount() - 1;
}

std::string lastRank() {
    return "rank " + std::to_string(rankCount() - 1) + ": ";
}

class DistributedTableErrors : public ::testing::Test {
protected:
    static constexpr Index kPoints = 40, kVertices = 10;

    std::string errorOfTable(const stencils::StencilTable<double>& rows, Offset ownVertexCount,
                             int components = 3) const {
        return messageOf(
            [&] { DistributedTable(MPI_COMM_WORLD, rows, ownVertexCount, components); });
    }

    const stencils::StencilTable<double> table_ = randomTable(kPoints, kVertices, 1);
    const OwnedRange points_ = ownRange(kPoints, Spread::Even);
    const OwnedRange vertices_ = ownRange(kVertices, Spread::Even);
    const stencils::StencilTable<double> rows_ = ownRows(table_, points_);
};

TEST_F(DistributedTableErrors, PetscIsNotInitialised) {
    EXPECT_THAT(refusalBeforeInitialisation, HasSubstr("PetscInitialize()"));
}

TEST_F(DistributedTableErrors, WeightsThatAreNotFinite) {
    for (const double weight : {kNan, -kInfinity}) {
        const stencils::StencilTable<double> bad(stencils::Trusted{}, kVertices, {0, 0, 1, 2},
                                                 {3, 4}, {0.5, weight});
        const std::string error = errorOfTable(isLast() ? bad : rows_, vertices_.count());
        EXPECT_THAT(error, StartsWith(lastRank() + "row 2 has a weight of "));
    }
}

TEST_F(DistributedTableErrors, VerticesThatAreNotTheColumns) {
    EXPECT_THAT(errorOfTable(rows_, vertices_.count() + (isLast() ? 2 : 0)),
                StartsWith("rank 0: the rows are over 10 vertices; the ranks own 12"));
    const auto wider = ownRows(randomTable(kPoints, kVertices + 1, 1), points_);
    EXPECT_THAT(errorOfTable(isLast() ? wider : rows_, vertices_.count()),
                StartsWith(lastRank() + "the rows are over 11 vertices; the ranks own 10"));
    EXPECT_THAT(errorOfTable(rows_, isLast() ? -1 : vertices_.count()),
                StartsWith(lastRank() + "the number of own vertices is -1; expected 0 or more"));
}

TEST_F(DistributedTableErrors, Components) {
    EXPECT_THAT(errorOfTable(rows_, vertices_.count(), 0),
                StartsWith("rank 0: the number of components is 0; expected 1 or more"));
    if (rankCount() > 1) {
        EXPECT_THAT(errorOfTable(rows_, vertices_.count(), isLast() ? 2 : 3),
                    StartsWith(lastRank() + "got 2 components, rank 0 has 3"));
    }
}

TEST_F(DistributedTableErrors, MoreRowsThanPetscCanCount) {
    if (sizeof(PetscInt) > 4) GTEST_SKIP() << "PETSc's integers have 64 bits";
    constexpr Index kMany = 1'000'000'000;
    const stencils::StencilTable<double> none(kMany, {0}, {}, {});
    EXPECT_THAT(errorOfTable(none, ownRange(kMany, Spread::Even).count()),
                HasSubstr("3000000000 components of vertices; PETSc's integers have 32 bits"));
}

// The last rank copies 5,001 offsets, which are at least 20,000 bytes.
TEST_F(DistributedTableErrors, OutOfMemoryForCopies) {
    constexpr Index kMany = 5'000;
    const auto own = randomTable(kMany, kVertices, 1);
    // Other allocations before the copy are much smaller.
    EXPECT_EQ(messageOf([&] {
                  std::optional<AllocationLimit> limit;
                  if (isLast()) limit.emplace(10'000);
                  DistributedTable(MPI_COMM_WORLD, own, vertices_.count());
              }),
              lastRank() + "out of memory");
}

TEST_F(DistributedTableErrors, SizesOfValues) {
    DistributedTable distributed(MPI_COMM_WORLD, rows_, vertices_.count());
    const auto pointNumbers = std::size_t(3 * points_.count());
    const auto vertexNumbers = std::size_t(3 * vertices_.count());
    const std::size_t extra = isLast() ? 1 : 0;
    std::vector<double> points(pointNumbers, 7), vertices(vertexNumbers, 7);
    std::vector<double> morePoints(pointNumbers + extra, 7), moreVertices(vertexNumbers + extra, 7);
    EXPECT_THAT(messageOf([&] { distributed.evaluate(moreVertices, points); }),
                StartsWith(lastRank() + "got "));
    EXPECT_REFUSED(Error, "points of 3 components", distributed.evaluate(vertices, morePoints));
    std::vector<double> addend(pointNumbers + 1 + extra, 7);
    EXPECT_REFUSED(Error, "points of the addend of 3 components",
                   distributed.evaluate(vertices, points, addend));
    EXPECT_REFUSED(Error, "points of 3 components",
                   distributed.evaluateAdjoint(morePoints, vertices));
    EXPECT_REFUSED(Error, "vertices of 3 components",
                   distributed.evaluateAdjoint(points, moreVertices));
    EXPECT_EQ(points, std::vector<double>(pointNumbers, 7)) << "nothing is written";
    EXPECT_EQ(vertices, std::vector<double>(vertexNumbers, 7)) << "nothing is written";
    EXPECT_MESSAGE("", distributed.evaluate(vertices, points));
}

TEST_F(DistributedTableErrors, EvenRanges) {
    EXPECT_THROW(evenRange(-1, 0, 1), Error);
    EXPECT_THROW(evenRange(5, -1, 2), Error);
    EXPECT_THROW(evenRange(5, 2, 2), Error);
    EXPECT_THROW(evenRange(5, 0, 0), Error);
}

}  // namespace
}  // namespace espalier::petsc
