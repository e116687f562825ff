// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/embed/local_binding.h>
#include <espalier/shapes/around.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "support/complexes.h"
#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/thread_pool.h"

namespace espalier::far {
namespace {

using namespace std::chrono_literals;

TEST(Progress, CountsItemsOfOutermostLoops) {
    SerialExecutor serial;
    const ExecutorScope onThisThread(serial);
    std::vector<std::array<Offset, 3>> heard;
    const ProgressScope scope(
        [&](const Progress& progress) {
            heard.push_back({progress.stage, progress.done, progress.count});
            return true;
        },
        0ms);
    parallelFor(25, 10, [](Offset, Offset) {});
    // A single range is not a stage; loops within it are.
    parallelFor(7, 10, [](Offset, Offset) {});
    parallelFor(1, 1, [](Offset, Offset) {
        parallelFor(2, 1, [](Offset, Offset) { parallelFor(2, 1, [](Offset, Offset) {}); });
    });
    const std::vector<std::array<Offset, 3>> expected = {
        {0, 10, 25}, {0, 20, 25}, {0, 25, 25},              //
        {1, 0, 0},                                          //
        {1, 0, 2},   {1, 0, 2},   {1, 1, 2},                // two inner ranges, then the outer one
        {1, 1, 2},   {1, 1, 2},   {1, 2, 2},   {2, 0, 0}};  //
    EXPECT_EQ(heard, expected);
    EXPECT_EQ((Progress{0, 1, 4}.fraction()), 0.25);
    EXPECT_EQ(Progress{}.fraction(), 0);
}

TEST(Progress, NeverFallsAndIsReportedByOneThreadAtATime) {
    ThreadPool pool(4);
    const ExecutorScope onPool(pool);
    std::atomic<int> callers = 0;
    Progress last;
    const ProgressScope scope(
        [&](const Progress& progress) {
            EXPECT_EQ(++callers, 1);
            EXPECT_GE(progress.stage, last.stage);
            if (progress.stage == last.stage) {
                EXPECT_GE(progress.fraction(), last.fraction());
            }
            last = progress;
            --callers;
            return true;
        },
        0ms);
    for (int loop = 0; loop < 20; ++loop)
        parallelFor(500, 1, [](Offset, Offset) { parallelFor(3, 1, [](Offset, Offset) {}); });
    EXPECT_EQ(last.stage, 19);
}

TEST(Progress, IsReportedAtMostOncePerInterval) {
    int calls = 0;
    const auto count = [&](const Progress&) { return ++calls > 0; };
    {
        const ProgressScope scope(count, std::chrono::hours(1));
        parallelFor(1000, 1, [](Offset, Offset) {});
    }
    EXPECT_EQ(calls, 0);
    {
        SerialExecutor serial;
        const ExecutorScope onThisThread(serial);
        const ProgressScope scope(count, 0ms);
        parallelFor(1000, 1, [](Offset, Offset) {});
        {
            int inner = 0;
            const ProgressScope another([&](const Progress&) { return ++inner > 0; }, 0ms);
            parallelFor(10, 1, [](Offset, Offset) {});
            EXPECT_EQ(inner, 10);
        }
        EXPECT_EQ(calls, 1000);
        parallelFor(10, 1, [](Offset, Offset) {});
        EXPECT_EQ(calls, 1010);
    }
    parallelFor(10, 1, [](Offset, Offset) {});
    EXPECT_EQ(calls, 1010);
}

// The callback may compute a preview, for example. Its work uses the executor of this thread.
TEST(Progress, WorkOfTheCallbackIsNotReported) {
    SerialExecutor serial;
    const ExecutorScope onThisThread(serial);
    int calls = 0;
    const auto own = std::this_thread::get_id();
    const ProgressScope scope(
        [&](const Progress&) {
            ++calls;
            parallelFor(50, 1, [&](Offset, Offset) {
                EXPECT_EQ(std::this_thread::get_id(), own);
                std::this_thread::sleep_for(20us);
            });
            return true;
        },
        0ms);
    parallelFor(10, 1, [](Offset, Offset) {});
    EXPECT_EQ(calls, 10);
}

// The callback requests the relation that is being derived.
TEST(Progress, CallbackMayUseARelationThatIsBeingDerived) {
    TopologyRefiner refiner = refined(shapes::box({.cells = {12, 12, 12}}).complex, 1);
    const CellComplex complex = refiner.level(1).complex;
    const Incidence* seen = nullptr;
    const ProgressScope scope(
        [&](const Progress&) {
            seen = &complex.relation(3, 0);
            return true;
        },
        0ms);
    EXPECT_EQ(&complex.relation(3, 0), seen);
}

TEST(Cancelled, LastsAsLongAsTheScope) {
    int begun = 0;
    SerialExecutor serial;
    const ExecutorScope onThisThread(serial);
    const auto work = [&] { parallelFor(10, 1, [&](Offset, Offset) { ++begun; }); };
    {
        int calls = 0;
        const ProgressScope scope([&](const Progress&) { return ++calls < 3; }, 0ms);
        EXPECT_THROW(work(), Cancelled);
        EXPECT_EQ(begun, 3);
        EXPECT_THROW(work(), Cancelled);
        EXPECT_THROW(parallelFor(1, 1, [&](Offset, Offset) { ++begun; }), Cancelled);
        EXPECT_EQ(begun, 3);
        EXPECT_EQ(calls, 3);
    }
    work();
    EXPECT_EQ(begun, 13);
}

// A complete result is not thrown away.
TEST(Cancelled, IsNotThrownAfterTheLastRange) {
    const ProgressScope scope([](const Progress& p) { return p.count == 0 || p.done < p.count; },
                              0ms);
    SerialExecutor serial;
    const ExecutorScope onThisThread(serial);
    parallelFor(10, 1, [](Offset, Offset) {});
    EXPECT_THROW(parallelFor(10, 1, [](Offset, Offset) {}), Cancelled);
}

TEST(Cancelled, IsNotAnError) {
    EXPECT_FALSE((std::is_base_of_v<Error, Cancelled>));
    EXPECT_STREQ(Cancelled().what(), "cancelled");
}

TEST(Cancelled, ExceptionsOfTheCallbackAreThrownInstead) {
    ThreadPool pool(3);
    const ExecutorScope onPool(pool);
    for (int repeat = 0; repeat < 20; ++repeat) {
        std::atomic<int> calls = 0;
        const ProgressScope scope(
            [&](const Progress&) -> bool {
                if (++calls == 7) throw std::runtime_error("the window was closed");
                return true;
            },
            0ms);
        const auto work = [] {
            for (int loop = 0; loop < 100; ++loop)
                parallelFor(100, 1,
                            [](Offset, Offset) { parallelFor(2, 1, [](Offset, Offset) {}); });
        };
        EXPECT_THROW(work(), std::runtime_error);
        EXPECT_THROW(work(), std::runtime_error);
        EXPECT_EQ(calls, 7);
    }
}

TEST(CheckCancelled, CallsTheCallbackInTheWorkOfOneThread) {
    checkCancelled();  // does nothing without a scope
    int calls = 0;
    const ProgressScope scope([&](const Progress&) { return ++calls < 3; }, 0ms);
    checkCancelled();
    checkCancelled();
    EXPECT_EQ(calls, 2);
    EXPECT_THROW(checkCancelled(), Cancelled);
    EXPECT_THROW(checkCancelled(), Cancelled);
    EXPECT_EQ(calls, 3);
}

TEST(CheckCancelled, EndsARangeOfALoop) {
    int calls = 0, steps = 0;
    const ProgressScope scope([&](const Progress&) { return ++calls < 10; }, 0ms);
    const auto body = [&](Offset, Offset) {
        for (; steps < 1000; ++steps) checkCancelled();
    };
    EXPECT_THROW(parallelFor(1, 1, body), Cancelled);
    EXPECT_EQ(steps, 9);
}

TEST(CheckCancelled, KeepsTheIntervalAndCallsOnceInSomeSteps) {
    int calls = 0;
    const auto count = [&](const Progress&) { return ++calls > 0; };
    {
        const ProgressScope scope(count, std::chrono::hours(1));
        for (int i = 0; i < 100; ++i) checkCancelled();
        EXPECT_EQ(calls, 0);
    }
    const ProgressScope scope(count, 0ms);
    for (std::size_t step = 0; step < 1000; ++step) checkCancelledEvery(step, 8);
    EXPECT_EQ(calls, 4);  // at 0, 256, 512 and 768
}

TEST(CheckCancelled, ThrowsTheExceptionOfTheCallback) {
    const ProgressScope scope(
        [](const Progress&) -> bool { throw std::runtime_error("interrupted"); }, 0ms);
    EXPECT_THROW(checkCancelled(), std::runtime_error);
}

/// Repeats work(), cancelled by the 1st, 3rd, 7th … call of the callback, until it completes.
/// Expects the right result then, and after all cancelled attempts.
template <class Work>
void cancelEverywhere(Work work) {
    const auto expected = work();
    int cancelled = 0;
    for (int limit = 1;; limit = 2 * limit + 1) {
        int calls = 0;
        const auto run = [&] {
            const ProgressScope scope([&](const Progress&) { return ++calls < limit; }, 0ms);
            return work();
        };
        try {
            EXPECT_EQ(run(), expected);
            break;
        } catch (const Cancelled&) {
            ++cancelled;
            EXPECT_EQ(calls, limit);
        }
    }
    // The work was cancelled at least after a first and after a later range.
    EXPECT_GT(cancelled, 1);
    EXPECT_EQ(work(), expected);
}

/// Runs a test without threads and on four threads.
template <class Test>
void withAndWithoutThreads(Test test) {
    SerialExecutor serial;
    {
        const ExecutorScope scope(serial);
        test();
    }
    ThreadPool pool(3);
    const ExecutorScope scope(pool);
    test();
}

const Lattice& lattice() {
    static const Lattice lattice = shapes::box({.cells = {4, 4, 4}});
    return lattice;
}

// A cancelled refiner has the levels that were complete, and continues from there.
TEST(Cancelled, RefinerKeepsCompleteLevels) {
    TopologyRefiner whole = refined(lattice().complex, 3);
    const auto loops = [](const TopologyRefiner& refiner) {
        const auto values = refiner.level(3).complex.relation(2, 0).values();
        return std::vector<Index>(values.begin(), values.end());
    };
    const auto expected = loops(whole);
    withAndWithoutThreads([&] {
        for (int complete = 0; complete < 3; ++complete) {
            TopologyRefiner refiner(lattice().complex);
            const auto refine = [&] {
                const ProgressScope scope(
                    [&](const Progress&) { return refiner.maxLevel() < complete; }, 0ms);
                refiner.refineUniform(3);
            };
            EXPECT_THROW(refine(), Cancelled);
            EXPECT_EQ(refiner.maxLevel(), complete);
            refiner.refineUniform(3);
            ASSERT_EQ(loops(refiner), expected);
        }
    });
}

TEST(Cancelled, TablesAndBindings) {
    TopologyRefiner refiner = refined(lattice().complex, 2);
    const TopologyRefiner base(lattice().complex);
    const auto points = pointsIn(Refined(lattice(), 1), 20'000, 4);
    withAndWithoutThreads([&] {
        cancelEverywhere([&] { return stencils::buildStencils(refiner, 2); });
        cancelEverywhere([&] {
            return embed::bindPoints({base, lattice().positions}, points, {.level = 2});
        });
    });
}

// Work of a single thread.
TEST(Cancelled, TheSmallestBox) {
    const auto points = pointsIn(Refined(lattice(), 1), 20'000, 4);
    cancelEverywhere([&] { return shapes::around(points, {.oriented = true}).positions; });
}

}  // namespace
}  // namespace espalier::far
