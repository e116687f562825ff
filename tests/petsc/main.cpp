// SPDX-License-Identifier: Apache-2.0
#include <espalier/petsc/distributed_table.h>
#include <petscsys.h>

#include <cstdio>

#include "refusals.h"
#include "support/test.h"

namespace espalier::test {

std::string refusalBeforeInitialisation;

namespace {

/// Prints failures on ranks that print nothing else.
class FailurePrinter : public ::testing::EmptyTestEventListener {
public:
    explicit FailurePrinter(int rank) : rank_(rank) {}
    void OnTestPartResult(const ::testing::TestPartResult& result) override {
        if (result.failed())
            std::fprintf(stderr, "rank %d: %s:%d: %s\n", rank_, result.file_name(),
                         result.line_number(), result.message());
    }

private:
    int rank_;
};

}  // namespace
}  // namespace espalier::test

int main(int argumentCount, char** arguments) {
    using namespace espalier;
    ::testing::InitGoogleTest(&argumentCount, arguments);
    test::refusalBeforeInitialisation = messageOf(
        [] { petsc::DistributedTable(MPI_COMM_WORLD, stencils::StencilTable<double>(), 0); });
    if (PetscInitialize(&argumentCount, &arguments, nullptr, nullptr)) return 2;
    int rank = 0;
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
    if (rank != 0) {
        auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
        delete listeners.Release(listeners.default_result_printer());
        listeners.Append(new test::FailurePrinter(rank));
    }
    const int result = RUN_ALL_TESTS();
    return PetscFinalize() ? 2 : result;
}
