// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/executor.h>
#include <espalier/far/progress_state.h>

namespace espalier::far {

/// What scopes have said to this thread, or to that which began the loop that it works for.
struct LoopContext {
    Executor* executor = nullptr;       ///< or oneTBB's arena
    ProgressState* progress = nullptr;  ///< or nobody asks
    bool isInStage = false;             ///< whether this is inside of what counts as a stage

    /// The loop that this thread has handed to an executor and waits for.
    const void* awaited = nullptr;
};

/// Of the calling thread.
LoopContext& loopContext();

}  // namespace espalier::far
