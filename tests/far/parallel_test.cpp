// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/parallel.h>
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/threads.h"
#include "support/waiting_thread.h"

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

TEST(ParallelFor, WaitingThreadTakesUpNoOtherWork) {
    // More threads than the machine has cores: some must be free to help with the inner loop, so
    // that the one that began it has to wait for them.
    test::withThreads(8, [] { EXPECT_FALSE(test::waitingThreadTakesUpOtherWork(300)); });
}

}  // namespace
}  // namespace espalier::far
