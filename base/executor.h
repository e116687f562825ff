// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/function_ref.h>
#include <espalier/base/index.h>

namespace espalier {

/// The threads of a host: what runs the ranges of parallelFor() where an ExecutorScope says so.
class ESPALIER_API Executor {
public:
    virtual ~Executor();

    /// Calls task(0) to task(count − 1), in any order and from any threads, this one included, and
    /// returns on the thread that it was called on when all calls have ended. A host's own parallel
    /// loop over an index does that.
    ///
    /// Calls nest, from the threads that run tasks: there must be an end to it even if no other
    /// thread is free, as there is where the calling thread takes part. A thread that waits may run
    /// other work of the host, to which none of our scopes on that thread applies; of ours it turns
    /// away what it must not begin then. What is turned away is asked for again, in a call of run()
    /// for fewer, as are calls that were left out, and is done by the thread that began the loop if
    /// that is of no use.
    ///
    /// \param task throws nothing
    /// \throws what it likes, which arrives at the caller of the library, but not before all calls
    ///         that have begun have ended
    virtual void run(Offset count, FunctionRef<void(Offset)> task) = 0;
};

/// No threads: all work is done by the thread that calls, in order, without a lock and without
/// memory of its own. For real time, and for hosts that have a thread for each of many models.
class ESPALIER_API SerialExecutor final : public Executor {
public:
    void run(Offset count, FunctionRef<void(Offset)> task) override;
};

/// While this object lives, what the calling thread asks of the library runs on an executor, and
/// not in its oneTBB arena; in a build without oneTBB, not on the calling thread alone. So do the
/// loops inside those that the executor runs, on whatever thread. Other threads of the host are as
/// they were. Results are the same, bit for bit.
///
///     SerialExecutor serial;
///     const ExecutorScope scope(serial);
///     table.evaluate(…);  // on this thread alone
///
/// Scopes of a thread end in the reverse order of their beginning. Of two, the inner one counts.
class ESPALIER_API ExecutorScope {
public:
    /// \param executor lives longer than this
    explicit ExecutorScope(Executor& executor);
    ~ExecutorScope();
    ExecutorScope(const ExecutorScope&) = delete;
    ExecutorScope& operator=(const ExecutorScope&) = delete;

private:
    Executor* outer_;
};

}  // namespace espalier
