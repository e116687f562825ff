// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/function_ref.h>
#include <espalier/base/index.h>

#include <memory>

namespace espalier {

/// Calls body(first, last) on disjoint ranges of about `grain` items that cover [0, count). All
/// parallel work of the library goes through here.
///
/// The ranges run concurrently in the caller's oneTBB arena, or on the executor of an ExecutorScope
/// (executor.h), or one after the other in a build without oneTBB. They do not depend on the number
/// of threads: range k is [k·grain, min((k+1)·grain, count)), so a body that keeps a result per
/// range is deterministic. A single range runs on the calling thread.
/// If the host cancels a oneTBB group in which the loop runs, the loop goes on; a ProgressScope
/// (progress.h) can cancel it.
/// Calls may be nested. A thread that waits here runs no other work of the library, so the caller
/// may hold a lock that other work of the arena needs.
///
/// If bodies throw, the exception of the lowest range is rethrown, so that errors too are the same
/// for every number of threads.
///
/// The loop itself allocates nothing and takes no lock unless a body throws; oneTBB allocates tasks
/// and wakes threads.
///
/// \throws Cancelled if the callback of a ProgressScope (progress.h) cancels
ESPALIER_API void parallelFor(Offset count, Offset grain, FunctionRef<void(Offset, Offset)> body);

/// Limits the number of oneTBB threads while this object lives: for the whole process, including
/// all other users of oneTBB in it. If there are several limits, the lowest one applies. Use it in
/// programs. A host with other work should instead call the library in an arena with a limited
/// number of threads (`arena.execute([&] { … })`, and create our scopes inside), or use an
/// ExecutorScope.
class ESPALIER_API ThreadLimit {
public:
    /// \param threads at least 1; or 0 for oneTBB's default (one per core)
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
    struct Control;
    std::unique_ptr<Control> control_;
};

}  // namespace espalier
