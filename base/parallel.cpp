// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/base/loop_context.h>
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <utility>

#ifdef ESPALIER_WITH_TBB
#endif

namespace espalier {

LoopContext& loopContext() {
    // Of the block that each thread is born with: in a library that is loaded later the first use
    // on a thread would allocate.
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

    /// For any thread, each range once. Does nothing if a lower range has failed.
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

    /// When all ranges have run.
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

/// Ranges are taken in ascending order, whatever the order of the calls.
class SharedRanges {
public:
    explicit SharedRanges(ParallelLoop& loop) : loop_(loop) {}

    void runNext() {
        const Offset range = next_.fetch_add(1, std::memory_order_relaxed);
        if (range < loop_.rangeCount()) loop_.runRange(range);
    }

    /// Ranges that nobody has taken.
    Offset left() const {
        return std::max(loop_.rangeCount() - next_.load(std::memory_order_relaxed), Offset{0});
    }

private:
    ParallelLoop& loop_;
    std::atomic<Offset> next_ = 0;
};

void runOn(Executor& executor, ParallelLoop& loop) {
    SharedRanges ranges(loop);
    // A thread that waits for another loop may hold a lock that this one wants.
    const auto task = [&](Offset) {
        const void* awaited = loopContext().awaited;
        if (awaited == nullptr || awaited == &loop) ranges.runNext();
    };
    // What work of the host this thread takes up meanwhile is no concern of our scopes.
    const LoopContextScope scope({nullptr, nullptr, false, &loop, loopContext().isAwaited});
    // Again for what threads turned away, as long as that brings us on; and alone in the end.
    for (Offset left = ranges.left(), before = left + 1; left > 1 && left < before;
         before = std::exchange(left, ranges.left()))
        executor.run(left, task);
    while (ranges.left() > 0) ranges.runNext();
}

#ifdef ESPALIER_WITH_TBB
void runInArena(ParallelLoop& loop) {
    // Isolated: the caller may hold a lock that other work of the arena wants.
    tbb::this_task_arena::isolate([&] {
        // Of its own: a loop that ended when a group of the host's is cancelled would leave ranges
        // out, and nobody would know.
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
    // What the limit goes back to is asked for now: oneTBB's first look at the machine takes
    // memory, and ends the program if that is short when a limit ends.
    explicit Control(int threads)
        : unlimited(tbb::info::default_concurrency()),
          limit(tbb::global_control::max_allowed_parallelism, threads) {}
    int unlimited;
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
