// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/far/api.h>
#include <espalier/far/index.h>

#include <functional>
#include <memory>

namespace espalier::far {

/// Calls body(first, last) on disjoint ranges of about `grain` items that cover [0, count).
///
/// The ranges run concurrently in the caller's oneTBB arena, or one after the other in a build
/// without oneTBB. They do not depend on the number of threads: range k is
/// [k·grain, min((k+1)·grain, count)), so a body that keeps a result per range is deterministic.
/// Calls nest: a thread that waits here does nothing else meanwhile, so that the caller may hold a
/// lock that other work of the arena wants.
///
/// Of the exceptions that bodies throw, that of the lowest range is rethrown here: errors too are
/// the same for every number of threads.
ESPALIER_API void parallelFor(Offset count, Offset grain,
                              const std::function<void(Offset, Offset)>& body);

/// Upper bound on the threads that parallelFor uses while this object lives.
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

}  // namespace espalier::far
