// SPDX-License-Identifier: Apache-2.0
#include <espalier/far/parallel.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>

#ifdef ESPALIER_WITH_TBB
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace espalier::far {

#ifdef ESPALIER_WITH_TBB

void parallelFor(Offset count, Offset grain, const std::function<void(Offset, Offset)>& body) {
    const Offset chunkCount = (count + grain - 1) / grain;
    if (chunkCount <= 1) {
        if (count > 0) body(0, count);
        return;
    }
    std::atomic<Offset> failedChunk = chunkCount;
    std::exception_ptr failure;
    std::mutex failureMutex;
    const auto runChunk = [&](Offset chunk) {
        if (chunk > failedChunk.load(std::memory_order_relaxed)) return;
        try {
            body(chunk * grain, std::min((chunk + 1) * grain, count));
        } catch (...) {
            const std::lock_guard lock(failureMutex);
            if (chunk < failedChunk) {
                failedChunk = chunk;
                failure = std::current_exception();
            }
        }
    };
    // Isolated: the caller may hold a lock that other work of the arena wants.
    tbb::this_task_arena::isolate([&] { tbb::parallel_for(Offset{0}, chunkCount, runChunk); });
    if (failure) std::rethrow_exception(failure);
}

struct ThreadLimit::Control {
    explicit Control(int threads)
        : limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)) {}
    tbb::global_control limit;
};

ThreadLimit::ThreadLimit(int threads)
    : control_(threads > 0 ? std::make_unique<Control>(threads) : nullptr) {}

#else

void parallelFor(Offset count, Offset grain, const std::function<void(Offset, Offset)>& body) {
    for (Offset first = 0; first < count; first += grain)
        body(first, std::min(first + grain, count));
}

struct ThreadLimit::Control {};

ThreadLimit::ThreadLimit(int) {}

#endif

ThreadLimit::~ThreadLimit() = default;

}  // namespace espalier::far
