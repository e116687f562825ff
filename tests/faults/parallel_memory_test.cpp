// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>
#include <espalier/embed/local_binding.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <cstring>
#include <optional>
#include <tuple>

#include "exhaustion.h"
#include "support/test.h"

// Failing allocations while several threads work: oneTBB's threads, if it is used.
namespace espalier {
namespace {

/// Repeats work `times` times, each time with a different failing allocation, counted over all
/// threads. (Leaks are not checked, because oneTBB keeps memory.)
template <class Work>
void failSome(Work work, int times) {
    const auto expected = work();
    long count = 0;
    {
        const test::AllocationFault never(test::Failing::One, 1L << 60);
        work();
        count = never.count();
    }
    for (const auto failing : {test::Failing::One, test::Failing::AllFrom})
        for (int i = 0; i < times; ++i) {
            const long n = 1 + i * count / times;
            const auto it = test::attempt(failing, n, work);
            // oneTBB's message if it cannot start a thread.
            const bool isThread = std::strstr(it.otherError.data(), "pthread_create has failed");
            EXPECT_TRUE(it.result ? *it.result == expected : it.isOutOfMemory || isThread)
                << "allocation " << n << ": " << it.otherError.data();
        }
}

// Often the scope of a limit ends by an exception for lack of memory, so its end must not allocate.
TEST(ParallelMemory, ThreadLimitsEndWithoutMemory) {
    std::optional<ThreadLimit> limit(std::in_place, 1);
    auto end = [&] {
        limit.reset();
        return 0;
    };
    EXPECT_FALSE(test::attempt(test::Failing::AllFrom, 1, end).hasHappened);
}

TEST(ParallelMemory, BindingAndEvaluating) {
    const Lattice lattice = shapes::box({.cells = {2, 2, 3}});
    std::vector<Point3> points;
    for (int i = 0; i < 3000; ++i)
        points.push_back({i % 15 / 7.0, i / 15 % 15 / 7.0, i / 225 / 5.0});
    failSome(
        [&] {
            const TopologyRefiner base(lattice.complex);
            const auto binding =
                bind::bindPoints({base, lattice.positions}, points, bind::Level{2});
            return osd::evaluateBinding(binding, lattice.positions);
        },
        15);
}

TEST(ParallelMemory, RefiningAndTables) {
    const Lattice lattice = shapes::box({.cells = {2, 2, 3}});
    failSome(
        [&] {
            TopologyRefiner refiner(lattice.complex);
            refiner.refineUniform(2);
            const auto table = stencils::buildStencils(refiner, 2);
            return std::tuple(table, osd::CompiledTable<double>(table).byteCount());
        },
        15);
}

}  // namespace
}  // namespace espalier
