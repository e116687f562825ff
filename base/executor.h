// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/function_ref.h>
#include <espalier/base/index.h>

/// \file
/// Runs the library's parallel loops on the threads of a host.

namespace espalier {

/// The interface to the threads of a host. Within an ExecutorScope, parallelFor() hands its ranges
/// to this object.
class ESPALIER_API Executor {
public:
    virtual ~Executor();

    /// Calls task(0) to task(count − 1), in any order and from any threads, including the calling
    /// one, and returns when all calls have ended. A host's own parallel loop over an index does
    /// this.
    ///
    /// Tasks may call run() again (nested loops). run() must return even if no other thread is
    /// free; it does if the calling thread runs tasks too. A thread that waits in run() may run
    /// other work of the host; our scopes on this thread do not apply to that work. It may also
    /// call tasks of other loops of the library. Such a task returns at once without doing its
    /// work, because the waiting thread may hold a lock that the work needs. After run() returns,
    /// the library calls it again for the ranges that are left, with a smaller count. If such a
    /// call does not reduce the number of ranges, the thread that began the loop works on the rest
    /// itself.
    ///
    /// \param task never throws
    /// \throws anything, but only after all calls that have begun have ended; the exception reaches
    ///         the caller of the library
    virtual void run(Offset count, FunctionRef<void(Offset)> task) = 0;
};

/// Runs all work on the calling thread, in order, without locks or allocations. Use it for
/// real-time work, or in a host that has many models and gives each its own thread.
class ESPALIER_API SerialExecutor final : public Executor {
public:
    void run(Offset count, FunctionRef<void(Offset)> task) override;
};

/// While this object lives, the library's work for the calling thread runs on an executor, instead
/// of the thread's oneTBB arena (or, in a build without oneTBB, instead of this thread alone).
/// Nested loops of this work run there too, on any thread. Other threads of the host are not
/// affected. Results are the same, bit for bit.
///
///     SerialExecutor serial;
///     const ExecutorScope scope(serial);
///     table.evaluate(…);  // on this thread alone
///
/// Scopes of a thread must end in the reverse order of their beginning. The innermost one applies.
class ESPALIER_API ExecutorScope {
public:
    /// \param executor must outlive the scope
    explicit ExecutorScope(Executor& executor);
    ~ExecutorScope();
    ExecutorScope(const ExecutorScope&) = delete;
    ExecutorScope& operator=(const ExecutorScope&) = delete;

private:
    Executor* outer_;
};

}  // namespace espalier
