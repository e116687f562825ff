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

    /// Throws if the work has been cancelled or the callback has thrown.
    /// \throws Cancelled, or the exception of the callback
    void check() const;

    /// Begins and ends a stage. Called on the scope's thread, while no other thread works for it.
    void beginStage(Offset count);
    void endStage();

    /// Counts `items` more of the current stage as done.
    void add(Offset items) { done_.fetch_add(items, std::memory_order_relaxed); }

    /// Calls the callback, unless another thread is calling it, or the interval has not passed.
    void report();

private:
    using Clock = std::chrono::steady_clock;

    ProgressScope::Callback callback_;
    std::chrono::milliseconds interval_;
    Offset stage_ = 0;
    Offset count_ = 0;
    std::atomic<Offset> done_ = 0;

    std::atomic_flag isReporting_ = ATOMIC_FLAG_INIT;
    Clock::time_point lastCall_;  ///< used only by the thread that reports
    std::atomic<bool> isEnded_ = false;
    std::exception_ptr end_;  ///< set once isEnded_ is true
};

/// The scopes that apply to a thread: its own, or those of the thread that began the loop that it
/// works for.
struct LoopContext {
    Executor* executor = nullptr;       ///< null for oneTBB's arena
    ProgressState* progress = nullptr;  ///< null without a ProgressScope
    bool isInStage = false;             ///< true inside a loop that counts as a stage

    /// The loop that this thread has handed to an executor and waits for.
    const void* awaited = nullptr;

    /// True if other threads may wait for the work of this thread (CellComplex::relation()). Then
    /// this thread does not wait for others.
    bool isAwaited = false;
};

/// Returns the context of the calling thread.
LoopContext& loopContext();

/// Gives the calling thread another context until destruction.
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
