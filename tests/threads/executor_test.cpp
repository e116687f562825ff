// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/executor.h>
#include <espalier/far/parallel.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/local_binding.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "support/refined_lattice.h"
#include "support/thread_pool.h"
#include "support/threads.h"
#include "support/waiting_thread.h"

namespace espalier::far {
namespace {

using test::ThreadPool;

/// One that does no more than it must: of the calls it makes some, the last first.
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
    withEachExecutor([] {
        std::vector<std::atomic<int>> visits(1003);
        parallelFor(1003, 10, [&](Offset first, Offset last) {
            EXPECT_EQ(first % 10, 0);
            EXPECT_EQ(last, std::min<Offset>(first + 10, 1003));
            for (Offset i = first; i < last; ++i) ++visits[static_cast<std::size_t>(i)];
        });
        for (const auto& count : visits) EXPECT_EQ(count, 1);
    });
}

TEST(Executor, RethrowsTheErrorOfTheLowestRange) {
    withEachExecutor([] {
        for (int attempt = 0; attempt < 20; ++attempt) {
            try {
                parallelFor(1000, 10, [](Offset first, Offset) {
                    if (first >= 300) throw std::runtime_error(std::to_string(first));
                });
                FAIL() << "nothing thrown";
            } catch (const std::runtime_error& error) {
                EXPECT_STREQ(error.what(), "300");
            }
        }
    });
}

TEST(Executor, ItsOwnErrorsArrive) {
    class Broken final : public Executor {
        void run(Offset, FunctionRef<void(Offset)>) override {
            throw std::runtime_error("no threads today");
        }
    } broken;
    const ExecutorScope scope(broken);
    EXPECT_THROW(parallelFor(2, 1, [](Offset, Offset) {}), std::runtime_error);
    // One range is nobody else's business.
    parallelFor(1, 1, [](Offset, Offset) {});
}

TEST(SerialExecutor, DoesAllOnTheCallingThreadInOrder) {
    SerialExecutor serial;
    const ExecutorScope scope(serial);
    std::vector<Offset> firsts;
    parallelFor(100, 10, [&](Offset first, Offset) {
        parallelFor(4, 2, [&](Offset inner, Offset) { firsts.push_back(first + inner); });
    });
    EXPECT_EQ(firsts.size(), 20u);
    EXPECT_TRUE(std::is_sorted(firsts.begin(), firsts.end()));
}

// Loops within loops run on the executor's threads, too, and on no others.
TEST(ExecutorScope, HoldsForNestedLoops) {
    /// Runs its calls on threads of its own, and knows these.
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
    // And not longer, nor on other threads of the host.
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

// As ParallelFor.WaitingThreadTakesUpNoOtherWork, where the host's scheduler would have it so.
TEST(Executor, WaitingThreadTakesUpNoOtherWork) {
    ThreadPool pool(8, ThreadPool::Waiting::HelpsAnybody);
    const ExecutorScope scope(pool);
    EXPECT_FALSE(test::waitingThreadTakesUpOtherWork(50));
}

/// Points bound to a lattice, by groups on several threads.
stencils::BoundModel<float> bindModel() {
    static const Lattice lattice = shapes::cylinder({.sectors = 5});
    static const std::vector<Point3> points = test::pointsIn(test::Refined(lattice, 2), 20'000, 3);
    return stencils::bindPoints<float>(TopologyRefiner(lattice.complex), lattice.positions, 3,
                                       stencils::Rules::Siggraph96, points);
}

TEST(ExecutorScope, ResultsAreTheSameBitForBit) {
    const auto expected = bindModel();
    withEachExecutor([&] {
        const auto bound = bindModel();
        EXPECT_EQ(bound.binding, expected.binding);
        EXPECT_EQ(bound.statuses, expected.statuses);
        EXPECT_EQ(bound.largestResidual, expected.largestResidual);
    });
}

#ifdef ESPALIER_WITH_TBB
// A host's arena: no other threads than those that it lets in, and the same results.
TEST(Arena, OfTheCallerIsUsed) {
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
    EXPECT_EQ(arena.execute(bindModel).binding, expected.binding);
}
#endif

}  // namespace
}  // namespace espalier::far
