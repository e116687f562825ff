// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/executor.h>
#include <espalier/base/progress.h>

#include <atomic>
#include <exception>
#include <utility>

namespace espalier {

/// The state that all threads within a ProgressScope share.
class ProgressState {
public:
    ProgressState(ProgressScope::Callback callback, std::chrono::milliseconds interval);

    /// \throws what ended the work, if it is to end
    void check() const;

    /// A stage begins, and ends: on the scope's thread, while no other works for it.
    void beginStage(Offset count);
    void endStage();

    /// Counts `items` more of the current stage as done.
    void add(Offset items) { done_.fetch_add(items, std::memory_order_relaxed); }

    /// Calls the callback, unless another thread does so, or it is not yet time.
    void report();

private:
    using Clock = std::chrono::steady_clock;

    ProgressScope::Callback callback_;
    std::chrono::milliseconds interval_;
    Offset stage_ = 0;
    Offset count_ = 0;
    std::atomic<Offset> done_ = 0;

    std::atomic_flag isReporting_ = ATOMIC_FLAG_INIT;
    Clock::time_point lastCall_;  ///< of the thread that reports
    std::atomic<bool> isEnded_ = false;
    std::exception_ptr end_;  ///< once isEnded_
};

/// What scopes have said to this thread, or to that which began the loop that it works for.
struct LoopContext {
    Executor* executor = nullptr;       ///< or oneTBB's arena
    ProgressState* progress = nullptr;  ///< or nobody asks
    bool isInStage = false;             ///< whether this is inside of what counts as a stage

    /// The loop that this thread has handed to an executor and waits for.
    const void* awaited = nullptr;

    /// Whether others may wait for what this thread works on (CellComplex::relation()). Then it
    /// does not wait for others.
    bool isAwaited = false;
};

/// Of the calling thread.
LoopContext& loopContext();

/// Gives the calling thread another context while this lives.
class LoopContextScope {
public:
    explicit LoopContextScope(const LoopContext& context)
        : outer_(std::exchange(loopContext(), context)) {}
    ~LoopContextScope() { loopContext() = outer_; }
    LoopContextScope(const LoopContextScope&) = delete;
    LoopContextScope& operator=(const LoopContextScope&) = delete;

private:
    LoopContext outer_;
};

}  // namespace espalier
