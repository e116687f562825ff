// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/executor.h>
#include <espalier/base/progress_state.h>

#include <utility>

namespace espalier {

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
