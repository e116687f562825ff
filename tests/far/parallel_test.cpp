// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/parallel.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "support/threads.h"

namespace espalier::far {
namespace {

TEST(ParallelFor, CoversEachItemOnceInFixedRanges) {
    for (const int threads : {1, 3, 8})
        test::withThreads(threads, [] {
            std::vector<std::atomic<int>> visits(1003);
            parallelFor(1003, 10, [&](Offset first, Offset last) {
                EXPECT_EQ(first % 10, 0);
                EXPECT_EQ(last, std::min<Offset>(first + 10, 1003));
                for (Offset i = first; i < last; ++i) ++visits[static_cast<std::size_t>(i)];
            });
            for (const auto& count : visits) EXPECT_EQ(count, 1);
        });
    parallelFor(0, 10, [](Offset, Offset) { FAIL() << "called for nothing"; });
}

TEST(ParallelFor, RethrowsTheErrorOfTheLowestRange) {
    for (int attempt = 0; attempt < 50; ++attempt) {
        try {
            parallelFor(1000, 10, [](Offset first, Offset) {
                if (first >= 300) throw std::runtime_error(std::to_string(first));
            });
            FAIL() << "nothing thrown";
        } catch (const std::runtime_error& error) {
            EXPECT_STREQ(error.what(), "300");
        }
    }
}

// A body may hold a lock round a nested loop, as CellComplex::relation() does: a thread that waits
// for the inner loop must not take up another range of the outer one, which would want the same
// lock.
TEST(ParallelFor, WaitingThreadTakesUpNoOtherWork) {
    thread_local bool holdsLock = false;
    std::atomic<bool> isEnteredAgain = false;
    // More threads than the machine has cores: some must be free to help with the inner loop, so
    // that the one that began it has to wait for them.
    test::withThreads(8, [&] {
        for (int repeat = 0; repeat < 300; ++repeat) {
            std::once_flag once;
            parallelFor(64, 1, [&](Offset, Offset) {
                if (holdsLock) {
                    isEnteredAgain = true;  // Waiting for the flag here would never end.
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
    });
    EXPECT_FALSE(isEnteredAgain);
}

}  // namespace
}  // namespace espalier::far
