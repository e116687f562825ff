// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/parallel.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "support/test.h"

// Tests the promises of parallelFor() for any executor.
namespace espalier::test {

inline void expectEachItemOnceInFixedRanges() {
    std::vector<std::atomic<int>> visits(1003);
    parallelFor(1003, 10, [&](Offset first, Offset last) {
        EXPECT_EQ(first % 10, 0);
        EXPECT_EQ(last, std::min<Offset>(first + 10, 1003));
        for (Offset i = first; i < last; ++i) ++visits[i];
    });
    for (const auto& count : visits) EXPECT_EQ(count, 1);
}

inline void expectTheErrorOfTheLowestRange(int repeats) {
    for (int repeat = 0; repeat < repeats; ++repeat) {
        EXPECT_EQ(test::messageOf<std::runtime_error>([&] {
                      parallelFor(1000, 10, [](Offset first, Offset) {
                          if (first >= 300) throw std::runtime_error(std::to_string(first));
                      });
                  }),
                  "300");
    }
}

/// Expects that a thread that waits for an inner loop runs no range of the outer loop. A body may
/// hold a lock around a nested loop, as CellComplex::relation() does, and a range of the outer loop
/// may need the same lock.
inline void expectNoOtherWorkWhileWaiting(int repeats) {
    thread_local bool holdsLock = false;
    std::atomic<bool> isEnteredAgain = false;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        std::once_flag once;
        parallelFor(64, 1, [&](Offset, Offset) {
            if (holdsLock) {
                isEnteredAgain = true;  // Returns, because waiting for the flag would never end.
                return;
            }
            std::call_once(once, [&] {
                holdsLock = true;
                parallelFor(16, 1, [](Offset first, Offset) {
                    std::this_thread::sleep_for(std::chrono::microseconds(10 + 7 * first));
                });
                holdsLock = false;
            });
        });
    }
    EXPECT_FALSE(isEnteredAgain);
}

}  // namespace espalier::test
