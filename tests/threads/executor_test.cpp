// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/base/parallel.h>
#include <espalier/base/progress.h>
#include <espalier/embed/local_binding.h>
#include <espalier/far/topology_refiner.h>
#include <espalier/shapes/inventory.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>

#include "support/complexes.h"
#include "support/parallel_contract.h"
#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/thread_pool.h"
#include "support/threads.h"

#ifdef ESPALIER_WITH_TBB
#include <tbb/task_group.h>
#endif

namespace espalier::far {
namespace {

/// An executor that makes only some of the calls, in descending order.
class LazyExecutor final : public Executor {
public:
    void run(Offset count, FunctionRef<void(Offset)> task) override {
        for (Offset i = count - 1; i >= 0; i -= 3) task(i);
    }
};

/// Calls work(name) under each kind of executor.
template <class Work>
void withEachExecutor(Work work) {
    std::vector<std::pair<std::string, std::unique_ptr<Executor>>> executors;
    executors.emplace_back("serial", std::make_unique<SerialExecutor>());
    executors.emplace_back("lazy", std::make_unique<LazyExecutor>());
    executors.emplace_back("a pool", std::make_unique<ThreadPool>(3));
    executors.emplace_back("a pool that helps anybody",
                           std::make_unique<ThreadPool>(3, ThreadPool::Waiting::HelpsAnybody));
    for (const auto& [name, executor] : executors) {
        SCOPED_TRACE(name);
        const ExecutorScope scope(*executor);
        work();
    }
}

TEST(Executor, CoversEachItemOnceInFixedRanges) {
    withEachExecutor([] { expectEachItemOnceInFixedRanges(); });
}

TEST(Executor, RethrowsTheErrorOfTheLowestRange) {
    withEachExecutor([] { expectTheErrorOfTheLowestRange(20); });
}

TEST(Executor, ErrorsOfTheExecutorReachTheCaller) {
    class Broken final : public Executor {
        void run(Offset, FunctionRef<void(Offset)>) override {
            throw std::runtime_error("no threads today");
        }
    } broken;
    const ExecutorScope scope(broken);
    EXPECT_THROW(parallelFor(2, 1, [](Offset, Offset) {}), std::runtime_error);
    // A single range runs on the calling thread, without the executor.
    parallelFor(1, 1, [](Offset, Offset) {});
}

TEST(SerialExecutor, RunsEverythingOnTheCallingThreadInOrder) {
    SerialExecutor serial;
    const ExecutorScope scope(serial);
    std::vector<Offset> firsts;
    parallelFor(100, 10, [&](Offset first, Offset) {
        parallelFor(4, 2, [&](Offset inner, Offset) { firsts.push_back(first + inner); });
    });
    EXPECT_EQ(firsts.size(), 20u);
    EXPECT_TRUE(std::is_sorted(firsts.begin(), firsts.end()));
}

// Nested loops run on the executor's threads too, and on no others.
TEST(ExecutorScope, AppliesToNestedLoops) {
    /// Runs its calls on new threads, and records them.
    class Recorder final : public Executor {
    public:
        void run(Offset count, FunctionRef<void(Offset)> task) override {
            ++runs;
            std::thread([&] {
                {
                    const std::lock_guard lock(mutex);
                    threads.insert(std::this_thread::get_id());
                }
                for (Offset i = 0; i < count; ++i) task(i);
            }).join();
        }
        std::atomic<int> runs = 0;
        std::mutex mutex;
        std::set<std::thread::id> threads;
    } recorder;
    {
        const ExecutorScope scope(recorder);
        parallelFor(4, 1, [&](Offset, Offset) {
            parallelFor(8, 1, [&](Offset, Offset) {
                const std::lock_guard lock(recorder.mutex);
                EXPECT_TRUE(recorder.threads.contains(std::this_thread::get_id()));
            });
        });
    }
    EXPECT_EQ(recorder.runs, 5);
    // The executor is not used after the scope, nor on other threads of the host.
    parallelFor(4, 1, [](Offset, Offset) {});
    const ExecutorScope scope(recorder);
    std::thread([] { parallelFor(4, 1, [](Offset, Offset) {}); }).join();
    EXPECT_EQ(recorder.runs, 5);
    SerialExecutor serial;
    {
        const ExecutorScope inner(serial);
        parallelFor(4, 1, [](Offset, Offset) {});
    }
    EXPECT_EQ(recorder.runs, 5);
    parallelFor(4, 1, [](Offset, Offset) {});
    EXPECT_EQ(recorder.runs, 6);
}

// The same as ParallelFor.WaitingThreadRunsNoOtherRanges, with a scheduler that offers other work
// to waiting threads.
TEST(Executor, WaitingThreadRunsNoOtherRanges) {
    ThreadPool pool(8, ThreadPool::Waiting::HelpsAnybody);
    const ExecutorScope scope(pool);
    expectNoOtherWorkWhileWaiting(50);
}

/// Runs job() on a thread of a pool while the thread waits for a loop of the library, in a scope of
/// the library.
template <class Work>
void whileWaiting(ThreadPool& pool, Work job) {
    const auto waiting = std::this_thread::get_id();
    std::atomic<bool> isOtherAtWork = false, isDone = false;
    parallelFor(2, 1, [&](Offset, Offset) {
        if (std::this_thread::get_id() == waiting) {
            while (!isOtherAtWork) std::this_thread::yield();
            return;
        }
        isOtherAtWork = true;
        pool.post([&] {
            EXPECT_EQ(std::this_thread::get_id(), waiting);
            job();
            isDone = true;
        });
        while (!isDone) std::this_thread::yield();
    });
    EXPECT_TRUE(isDone);
}

// Scopes of a thread do not apply to work that the host runs on the thread while it waits for the
// library.
TEST(Executor, ScopesDoNotApplyToWorkOfTheHost) {
    ThreadPool pool(1, ThreadPool::Waiting::HelpsAnybody);
    const ExecutorScope scope(pool);
    bool isHeard = false;
    {
        const ProgressScope listening(
            [&](const Progress& progress) {
                isHeard = isHeard || progress.count == 7;
                return true;
            },
            std::chrono::milliseconds(0));
        whileWaiting(pool, [] { parallelFor(7, 1, [](Offset, Offset) {}); });
        EXPECT_FALSE(isHeard);
        parallelFor(7, 1, [](Offset, Offset) {});
        EXPECT_TRUE(isHeard);
    }
    // Cancelling the loop does not cancel the work of the host.
    std::atomic<bool> isCancelled = false, isThrough = false;
    const ProgressScope ending([&](const Progress&) { return !(isCancelled = true); },
                               std::chrono::milliseconds(0));
    whileWaiting(pool, [&] {
        while (!isCancelled) std::this_thread::yield();
        parallelFor(7, 1, [](Offset, Offset) {});
        isThrough = true;
    });
    EXPECT_TRUE(isThrough);
    EXPECT_THROW(parallelFor(7, 1, [](Offset, Offset) {}), Cancelled);
}

// The work of a host may request the relation that its thread is deriving.
TEST(Executor, WorkOfTheHostMayUseARelationThatIsBeingDerived) {
    const Lattice lattice = shapes::box({.cells = {12, 12, 12}});
    const auto deriving = std::this_thread::get_id();
    ThreadPool pool(1, ThreadPool::Waiting::HelpsAnybody);
    const ExecutorScope scope(pool);
    const Incidence* seen = nullptr;
    // Repeats until the other thread of the pool has run a range.
    for (int repeat = 0; repeat < 1000 && seen == nullptr; ++repeat) {
        TopologyRefiner refiner = refined(lattice.complex, 1);
        const CellComplex complex = refiner.level(1).complex;
        std::atomic<bool> isDone = false;
        const ProgressScope holding(
            [&](const Progress&) {
                if (std::this_thread::get_id() == deriving || isDone) return true;
                pool.post([&] {
                    EXPECT_EQ(std::this_thread::get_id(), deriving);
                    seen = &complex.relation(3, 0);
                    isDone = true;
                });
                while (!isDone) std::this_thread::yield();
                return true;
            },
            std::chrono::milliseconds(0));
        const Incidence* derived = &complex.relation(3, 0);
        if (seen != nullptr) {
            EXPECT_EQ(seen, derived);
        }
    }
    EXPECT_NE(seen, nullptr);
}

// Ranges that busy threads turned away are offered again, so that nested loops do not leave the
// outer loop to a single thread.
TEST(Executor, OffersDeclinedRangesAgain) {
    /// Makes only half of the calls in each run(), as if threads were busy with another loop.
    class Reluctant final : public Executor {
    public:
        void run(Offset count, FunctionRef<void(Offset)> task) override {
            counts.push_back(count);
            for (Offset i = 0; i < (count + 1) / 2; ++i) task(i);
        }
        std::vector<Offset> counts;
    } reluctant;
    const ExecutorScope scope(reluctant);
    std::vector<int> visits(20);
    parallelFor(20, 1, [&](Offset first, Offset) { ++visits[first]; });
    EXPECT_EQ(visits, std::vector<int>(20, 1));
    EXPECT_EQ(reluctant.counts, (std::vector<Offset>{20, 10, 5, 2}));
}

/// Binds points to a lattice, in groups on several threads.
embed::BoundRows<> bindModel() {
    static const Lattice lattice = shapes::cylinder({.sectors = 5});
    static const std::vector<Point3> points = pointsIn(Refined(lattice, 2), 20'000, 3);
    return embed::bindPoints({TopologyRefiner(lattice.complex), lattice.positions}, points,
                             {.level = 3});
}

TEST(ExecutorScope, ResultsAreTheSameBitForBit) {
    const auto expected = bindModel();
    withEachExecutor([&] {
        const auto bound = bindModel();
        EXPECT_EQ(bound, expected);
    });
}

#ifdef ESPALIER_WITH_TBB
// In a host's arena, the library uses only the threads of the arena, and gives the same results.
TEST(Arena, UsesTheArenaOfTheCaller) {
    for (const int threads : {1, 2, 4}) {
        const ThreadLimit limit(8);
        tbb::task_arena arena(threads);
        arena.execute([&] {
            parallelFor(200, 1, [&](Offset, Offset) {
                EXPECT_EQ(tbb::this_task_arena::max_concurrency(), threads);
                EXPECT_LT(tbb::this_task_arena::current_thread_index(), threads);
                parallelFor(3, 1, [&](Offset, Offset) {
                    EXPECT_EQ(tbb::this_task_arena::max_concurrency(), threads);
                });
            });
        });
    }
    const auto expected = bindModel();
    const ThreadLimit limit(8);
    tbb::task_arena arena(3);
    EXPECT_EQ(arena.execute(bindModel), expected);
}

// Cancelling a oneTBB group of the host does not cancel our loops: a loop that skipped ranges would
// leave uninitialized numbers.
TEST(Arena, LoopInACancelledGroupCompletes) {
    std::vector<std::atomic<int>> visits(500);
    // Two threads also on one core: this thread waits for the other one to begin.
    withThreads(2, [&] {
        tbb::task_group group;
        std::atomic<bool> isBegun = false;
        group.run([&] {
            parallelFor(500, 1, [&](Offset first, Offset) {
                isBegun = true;
                ++visits[first];
                std::this_thread::sleep_for(std::chrono::microseconds(20));
            });
        });
        while (!isBegun) std::this_thread::yield();
        group.cancel();
        group.wait();
    });
    for (const auto& count : visits) EXPECT_EQ(count, 1);
}
#endif

}  // namespace
}  // namespace espalier::far
