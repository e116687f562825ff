// SPDX-License-Identifier: Apache-2.0
#include "cages/work.h"

#include <espalier/base/progress.h>
#include <gtest/gtest.h>

using namespace std::chrono_literals;

namespace espalier::cages {
namespace {

TEST(Work, endsAtItsLimit) {
    Work work(10);
    work.add(4);
    work.add(6);
    EXPECT_EQ(work.done(), 10);
    EXPECT_THROW(work.add(1), WorkError);
    EXPECT_EQ(work.done(), 10);
}

TEST(Work, canBeCancelled) {
    int calls = 0;
    const ProgressScope scope([&](const Progress&) { return ++calls < 3; }, 0ms);
    Work work(10);
    work.add(1);
    work.add(1);
    EXPECT_THROW(work.add(1), Cancelled);
    EXPECT_EQ(work.done(), 2);
}

}  // namespace
}  // namespace espalier::cages
