// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "allocation_faults.h"

namespace espalier::test {

/// What came of work while memory was short.
template <class Result>
struct Attempt {
    bool hasHappened = false;            ///< that an allocation failed
    std::optional<Result> result = {};   ///< what was returned
    bool isOutOfMemory = false;          ///< or that std::bad_alloc was thrown
    std::array<char, 200> otherError{};  ///< or what another exception says; a string takes memory
};

template <class Work>
auto attempt(Failing failing, long n, Work& work) {
    Attempt<decltype(work())> attempt;
    const AllocationFault fault(failing, n);
    try {
        attempt.result.emplace(work());
    } catch (const std::bad_alloc&) {
        attempt.isOutOfMemory = true;
    } catch (const std::exception& error) {
        std::snprintf(attempt.otherError.data(), attempt.otherError.size(), "%s", error.what());
    }
    attempt.hasHappened = fault.hasHappened();
    return attempt;
}

/// Does work again and again, and each time another allocation in it fails, until it gets through.
/// Each time it throws std::bad_alloc, or has the right result in spite of it; it leaks nothing,
/// and `check()` is content.
///
/// \param work returns what can be compared; when that is gone, so is all that work has made
template <class Work, class Check>
void failEachAllocation(Work work, Check check) {
    const auto expected = work();
    long count = 0;
    for (const auto& [failing, step] : {std::pair(Failing::One, 1), {Failing::AllFrom, 7}}) {
        bool isDone = false;
        for (long n = 1; !isDone && !testing::Test::HasFailure(); n += step) {
            const long before = liveBlocks();
            bool isRight = false;
            std::array<char, 200> error{};
            {
                const auto it = attempt(failing, n, work);
                isDone = !it.hasHappened;
                isRight = it.result ? *it.result == expected : it.isOutOfMemory && it.hasHappened;
                error = it.otherError;
            }
            const long left = liveBlocks() - before;
            SCOPED_TRACE((failing == Failing::One ? "allocation " : "allocations from ") +
                         std::to_string(n));
            EXPECT_TRUE(isRight) << "another result, or another error: " << error.data();
            EXPECT_EQ(left, 0) << "blocks are lost";
            check();
            if (!isDone) count = std::max(count, n);
        }
    }
    EXPECT_GT(count, 0) << "nothing is allocated";
}

template <class Work>
void failEachAllocation(Work work) {
    failEachAllocation(work, [] {});
}

}  // namespace espalier::test
