// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/base/loop_context.h>
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <utility>

#ifdef ESPALIER_WITH_TBB
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace espalier {

LoopContext& loopContext() {
    // The TLS model places the context in the static block that each thread starts with. In a
    // library that is loaded later, the default model would allocate on a thread's first use.
    [[gnu::tls_model("initial-exec")]] thread_local constinit LoopContext context;
    return context;
}

namespace {

/// A loop of several ranges, while it runs.
class ParallelLoop {
public:
    ParallelLoop(Offset count, Offset grain, FunctionRef<void(Offset, Offset)> body)
        : count_(count),
          grain_(grain),
          rangeCount_((count + grain - 1) / grain),
          body_(body),
          outer_(loopContext()),
          isStage_(outer_.progress != nullptr && !outer_.isInStage),
          failedRange_(rangeCount_) {
        if (isStage_) outer_.progress->beginStage(count);
    }
    ~ParallelLoop() {
        if (isStage_) outer_.progress->endStage();
    }
    ParallelLoop(const ParallelLoop&) = delete;
    ParallelLoop& operator=(const ParallelLoop&) = delete;

    Offset rangeCount() const { return rangeCount_; }

    /// Runs a range, on any thread; called once per range. Does nothing if a lower range has
    /// failed.
    void runRange(Offset range) {
        if (range > failedRange_.load(std::memory_order_relaxed)) return;
        const LoopContextScope scope({outer_.executor, outer_.progress, outer_.progress != nullptr,
                                      nullptr, outer_.isAwaited});
        try {
            if (outer_.progress != nullptr) outer_.progress->check();
            checkMemory();
            const Offset first = range * grain_, last = std::min(first + grain_, count_);
            body_(first, last);
            if (outer_.progress != nullptr) {
                if (isStage_) outer_.progress->add(last - first);
                outer_.progress->report();
            }
        } catch (...) {
            const std::lock_guard lock(failureMutex_);
            if (range < failedRange_) {
                failedRange_ = range;
                failure_ = std::current_exception();
            }
        }
    }

    /// Rethrows the exception of the lowest range that failed, if any. Called after all ranges.
    void rethrowFailure() const {
        if (failure_) std::rethrow_exception(failure_);
    }

private:
    Offset count_, grain_, rangeCount_;
    FunctionRef<void(Offset, Offset)> body_;
    LoopContext outer_;
    bool isStage_;
    std::atomic<Offset> failedRange_;
    std::exception_ptr failure_;
    std::mutex failureMutex_;
};

/// Hands out the ranges of a loop in ascending order, whatever the order of the executor's calls.
class SharedRanges {
public:
    explicit SharedRanges(ParallelLoop& loop) : loop_(loop) {}

    void runNext() {
        const Offset range = next_.fetch_add(1, std::memory_order_relaxed);
        if (range < loop_.rangeCount()) loop_.runRange(range);
    }

    /// Returns the number of ranges that no thread has taken.
    Offset left() const {
        return std::max(loop_.rangeCount() - next_.load(std::memory_order_relaxed), Offset{0});
    }

private:
    ParallelLoop& loop_;
    std::atomic<Offset> next_ = 0;
};

void runOn(Executor& executor, ParallelLoop& loop) {
    SharedRanges ranges(loop);
    // A thread that waits for another loop may hold a lock that this loop needs.
    const auto task = [&](Offset) {
        const void* awaited = loopContext().awaited;
        if (awaited == nullptr || awaited == &loop) ranges.runNext();
    };
    // Our scopes do not apply to work of the host that this thread takes up while it waits.
    const LoopContextScope scope({nullptr, nullptr, false, &loop, loopContext().isAwaited});
    // Calls the executor again for ranges that threads turned away, as long as this makes progress;
    // then runs the rest on this thread.
    for (Offset left = ranges.left(), before = left + 1; left > 1 && left < before;
         before = std::exchange(left, ranges.left()))
        executor.run(left, task);
    while (ranges.left() > 0) ranges.runNext();
}

#ifdef ESPALIER_WITH_TBB
void runInArena(ParallelLoop& loop) {
    // Isolated, because the caller may hold a lock that other work of the arena needs.
    tbb::this_task_arena::isolate([&] {
        // Has its own context, because cancelling a group of the host must not silently skip
        // ranges.
        tbb::task_group_context context(tbb::task_group_context::isolated);
        tbb::parallel_for(
            Offset{0}, loop.rangeCount(), [&](Offset range) { loop.runRange(range); }, context);
    });
}
#else
void runInArena(ParallelLoop& loop) {
    for (Offset range = 0; range < loop.rangeCount(); ++range) loop.runRange(range);
}
#endif

}  // namespace

void parallelFor(Offset count, Offset grain, FunctionRef<void(Offset, Offset)> body) {
    if (count <= 0) return;
    const LoopContext& context = loopContext();
    if (context.progress != nullptr) context.progress->check();
    if (count <= grain) {
        body(0, count);
        if (context.progress != nullptr) context.progress->report();
        return;
    }
    ParallelLoop loop(count, grain, body);
    if (context.executor != nullptr)
        runOn(*context.executor, loop);
    else
        runInArena(loop);
    loop.rethrowFailure();
}

#ifdef ESPALIER_WITH_TBB

struct ThreadLimit::Control {
    // Queries oneTBB's default now: the first query allocates memory, and oneTBB would end the
    // program if that failed at the end of the limit.
    explicit Control(int threads)
        : defaultConcurrency(tbb::info::default_concurrency()),
          limit(tbb::global_control::max_allowed_parallelism, threads) {}
    int defaultConcurrency;
    tbb::global_control limit;
};

ThreadLimit::ThreadLimit(int threads)
    : control_(threads > 0 ? std::make_unique<Control>(threads) : nullptr) {}

#else

struct ThreadLimit::Control {};

ThreadLimit::ThreadLimit(int) {}

#endif

ThreadLimit::~ThreadLimit() = default;

Executor::~Executor() = default;

void SerialExecutor::run(Offset count, FunctionRef<void(Offset)> task) {
    for (Offset i = 0; i < count; ++i) task(i);
}

ExecutorScope::ExecutorScope(Executor& executor)
    : outer_(std::exchange(loopContext().executor, &executor)) {}

ExecutorScope::~ExecutorScope() {
    loopContext().executor = outer_;
}

}  // namespace espalier
