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
/// That a host cancels a group of oneTBB's in which this runs has no effect on it; a ProgressScope
/// (progress.h) cancels.
/// Calls nest: a thread that waits here does nothing else of the library's meanwhile, so that the
/// caller may hold a lock that other work of the arena wants.
///
/// Of the exceptions that bodies throw, that of the lowest range is rethrown here: errors too are
/// the same for every number of threads.
///
/// Allocates nothing and takes no lock of its own, unless a body throws; oneTBB has tasks to
/// allocate, and threads to wake.
///
/// \throws Cancelled where the callback of a ProgressScope (progress.h) wants that
ESPALIER_API void parallelFor(Offset count, Offset grain, FunctionRef<void(Offset, Offset)> body);

/// Upper bound on the threads that oneTBB uses while this object lives: of the whole process, for
/// whoever uses oneTBB in it, and of several the lowest. For programs; a host that has other work
/// than ours calls us in an arena of so many threads (`arena.execute([&] { … })`, with scopes of
/// ours made in there), or makes an ExecutorScope.
class ESPALIER_API ThreadLimit {
public:
    /// \param threads at least 1; 0 leaves the number to oneTBB (one a core)
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
    struct Control;
    std::unique_ptr<Control> control_;
};

}  // namespace espalier
