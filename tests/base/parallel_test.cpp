// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/parallel.h>

#include "support/parallel_contract.h"
#include "support/test.h"
#include "support/threads.h"

namespace espalier::far {
namespace {

TEST(ParallelFor, CoversEachItemOnceInFixedRanges) {
    for (const int threads : {1, 3, 8})
        withThreads(threads, [] { expectEachItemOnceInFixedRanges(); });
    parallelFor(0, 10, [](Offset, Offset) { FAIL() << "called for nothing"; });
}

TEST(ParallelFor, RethrowsTheErrorOfTheLowestRange) {
    expectTheErrorOfTheLowestRange(50);
}

TEST(ParallelFor, WaitingThreadRunsNoOtherRanges) {
    // There are more threads than cores, so that free threads help with the inner loop and the
    // thread that began it has to wait for them.
    withThreads(8, [] { expectNoOtherWorkWhileWaiting(300); });
}

}  // namespace
}  // namespace espalier::far
