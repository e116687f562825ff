// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/base/memory.h>
#include <espalier/base/parallel.h>
#include <espalier/far/topology_refiner.h>

#include <chrono>
#include <optional>
#include <thread>

#include "support/complexes.h"
#include "support/test.h"

namespace espalier::far {
namespace {

constexpr std::uint64_t kGigabyte = 1'000'000'000;

TEST(MemoryLimit, WithoutALimitNothingIsRefused) {
    EXPECT_NO_THROW(requireMemory(std::numeric_limits<std::size_t>::max(), "everything"));
    EXPECT_EQ(memoryLimit(), std::nullopt);
    EXPECT_EQ(sizeInMemory(5), 5u);
}

TEST(MemoryLimit, IsAtMostWhatAnAddressReaches) {
    if (sizeof(std::size_t) > 4) GTEST_SKIP() << "an address of this machine reaches any size";
    EXPECT_THAT(
        [] { requireMemory(5 * kGigabyte, "a cube"); },
        ThrowsMessage<MemoryError>(
            "a cube takes about 5.0 GB of memory; an address of this machine reaches 4.3 GB"));
    EXPECT_THAT([] { sizeInMemory(5 * kGigabyte); }, Throws<MemoryError>());
}

TEST(MemoryLimit, RefusesWorkBeyondTheLimitByName) {
    const MemoryLimit limit(residentMemory() + kGigabyte);
    EXPECT_NO_THROW(requireMemory(kGigabyte / 2, "a part"));
    EXPECT_THAT(
        [] { requireMemory(2 * kGigabyte, "level 15"); },
        ThrowsMessage<MemoryError>(
            AllOf(StartsWith("level 15 takes about 2.0 GB of memory"), HasSubstr("the limit is"))));
    EXPECT_THROW(requireMemory(~std::uint64_t{0}, "everything"), MemoryError);
}

TEST(MemoryLimit, LowestOfSeveralApplies) {
    const std::uint64_t held = residentMemory();
    std::optional<MemoryLimit> low(std::in_place, held + kGigabyte);
    const MemoryLimit high(held + 3 * kGigabyte);
    EXPECT_THROW(requireMemory(2 * kGigabyte, "this"), MemoryError);
    EXPECT_EQ(memoryLimit(), held + kGigabyte);
    low.reset();
    EXPECT_EQ(memoryLimit(), held + 3 * kGigabyte);
    EXPECT_NO_THROW(requireMemory(2 * kGigabyte, "this"));
}

TEST(MemoryLimit, RefusesEveryAmountOnceItIsExceeded) {
    const MemoryLimit limit(residentMemory() / 2);
    EXPECT_THAT([] { requireMemory(1, "this"); },
                ThrowsMessage<MemoryError>(StartsWith("out of memory: ")));
}

TEST(MemoryLimit, StopsLoopsThatExceedTheLimit) {
    // On many threads, the loop may end before the memory is checked.
    SerialExecutor serial;
    const ExecutorScope onThisThread(serial);
    std::vector<std::vector<char>> taken(200);
    const auto takeMemory = [&](Offset first, Offset) {
        taken[first].assign(1 << 20, 1);
        // The memory is checked every few milliseconds.
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    {
        const MemoryLimit limit(residentMemory() + 50'000'000);
        EXPECT_THAT([&] { parallelFor(200, 1, takeMemory); },
                    ThrowsMessage<MemoryError>(StartsWith("out of memory: ")));
    }
    EXPECT_TRUE(taken.back().empty()) << "went on to the end";
    EXPECT_NO_THROW(parallelFor(200, 1, takeMemory));
    EXPECT_FALSE(taken.back().empty());
}

TEST(MemoryLimit, RefusesALevelBeforeMakingTheLevelsBelow) {
    TopologyRefiner refiner = refined(grid({4, 4, 4}), 1);
    const MemoryLimit limit(residentMemory() + kGigabyte);
    EXPECT_THAT([&] { refiner.refineUniform(7); },
                ThrowsMessage<MemoryError>(StartsWith("level 7 takes about ")));
    EXPECT_EQ(refiner.maxLevel(), 1);
    refiner.refineUniform(2);
    EXPECT_EQ(refiner.maxLevel(), 2);
}

TEST(TopologyRefiner, RefusesALevelOfTooManyEntities) {
    TopologyRefiner refiner(grid({1, 1, 1}));
    for (const int level : {11, 15, 1000}) {
        const auto error = topologyErrorOf([&] { refiner.refineUniform(level); });
        EXPECT_EQ(error.cause(), TopologyCause::TooManyEntities);
        EXPECT_THAT(error.what(), StartsWith("level " + std::to_string(level) + " would have"));
        EXPECT_EQ(refiner.maxLevel(), 0);
    }
}

TEST(ResidentMemory, GrowsWithAllocatedMemory) {
    const std::uint64_t before = residentMemory();
    // Larger than what earlier tests have freed, which WebAssembly keeps.
    const std::vector<char> block(before + 100'000'000, 1);
    EXPECT_GE(residentMemory(), before + 50'000'000);
}

TEST(FormatBytes, HasOneDecimal) {
    EXPECT_EQ(formatBytes(0), "0 B");
    EXPECT_EQ(formatBytes(999), "999 B");
    EXPECT_EQ(formatBytes(1536), "1.5 kB");
    EXPECT_EQ(formatBytes(12'345'678'901), "12.3 GB");
    EXPECT_EQ(formatBytes(~std::uint64_t{0}), "18.4 EB");
}

}  // namespace
}  // namespace espalier::far
