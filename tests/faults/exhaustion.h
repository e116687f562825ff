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

/// The outcome of work while an allocation fails.
template <class Result>
struct Attempt {
    bool hasHappened = false;            ///< true if an allocation failed
    std::optional<Result> result = {};   ///< the result, if the work returned
    bool isOutOfMemory = false;          ///< true if it threw std::bad_alloc
    std::array<char, 200> otherError{};  ///< message of another exception; a string would allocate
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

/// Repeats work while its first, second, third … allocation fails, until each of them has failed.
/// Expects each time that the work throws std::bad_alloc or returns the right result, and that it
/// leaks nothing. Then calls check().
///
/// \param work returns a value that can be compared; with the value, everything that work has made
///        must be destroyed
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
