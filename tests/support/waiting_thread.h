// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/parallel.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

namespace espalier::test {

/// Whether a thread that waits for an inner loop takes up a range of the outer one. A body may hold
/// a lock round a nested loop, as CellComplex::relation() does, which that range would want too.
inline bool waitingThreadTakesUpOtherWork(int repeats) {
    thread_local bool holdsLock = false;
    std::atomic<bool> isEnteredAgain = false;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        std::once_flag once;
        far::parallelFor(64, 1, [&](far::Offset, far::Offset) {
            if (holdsLock) {
                isEnteredAgain = true;  // Waiting for the flag here would never end.
                return;
            }
            std::call_once(once, [&] {
                holdsLock = true;
                far::parallelFor(16, 1, [](far::Offset first, far::Offset) {
                    std::this_thread::sleep_for(std::chrono::microseconds(10 + 7 * first));
                });
                holdsLock = false;
            });
        });
    }
    return isEnteredAgain;
}

}  // namespace espalier::test
