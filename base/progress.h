// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>

/// \file
/// Reports the progress of calls, and cancels them.

namespace espalier {

class ProgressState;

/// The progress of a call.
///
/// A call is a sequence of stages. A stage is an outermost parallel loop of more than one range.
/// bindPoints() has one stage that takes nearly all of its time, the loop over points. Tables have
/// one or two stages per level, and each level takes eight times as long as the one before;
/// refinement has several stages per level. The number of stages is not known beforehand. It
/// depends on the arguments but not on the number of threads; a second call may have fewer stages,
/// because it reuses incidences that the first call derived.
/// Work that a single thread does between stages, such as reading a file, is not counted, but the
/// callback is called and can cancel it, too (checkCancelled()).
///
/// A callback that is due is called every few milliseconds. Only steps of other libraries and of
/// the system may take longer than 0.1 s, and cannot be left:
/// - parsing a VTK XML file: 0.7 s for a gigabyte, without appended data;
/// - the sparse matrices of a fit before they are factored: 0.1 s for 40,000 targets of 64 weights
///   each; and the order in which its vertices are eliminated: 0.1 s for 4,000 vertices;
/// - HDF5 below a CGNS file, the wait for the disk when a file is complete, and the return of
///   gigabytes of memory after cancelling.
///
/// So a progress bar that shows the fraction fills once per stage. A bar for a whole call is up to
/// the host, which knows its calls and how their stages share the time.
struct Progress {
    Offset stage = 0;  ///< number of stages that have ended since the scope began
    Offset done = 0;   ///< number of items (points, rows, cells …) of this stage that are done
    Offset count = 0;  ///< number of items of this stage; 0 between two stages

    /// Returns the fraction of the stage that is done, from 0 to 1. It never falls during a stage.
    double fraction() const {
        return count > 0 ? static_cast<double>(done) / static_cast<double>(count) : 0;
    }
};

/// Thrown by a call that the callback of a ProgressScope has cancelled. It is not an Error, so that
/// code that translates errors does not take it for one.
class ESPALIER_API Cancelled : public std::exception {
public:
    const char* what() const noexcept override;
};

/// While this object lives, a callback is told the progress of calls on this thread, and may cancel
/// them.
///
///     const ProgressScope scope([&](const Progress& progress) {
///         bar.show(progress.fraction());
///         return !bar.isCancelled();
///     });
///     const auto model = embed::bindPoints(…);  // may throw Cancelled
///
/// Once the callback returns false, it is not called again, and the current call throws Cancelled
/// as soon as the running ranges on other threads reach a nested loop or their end. (If these were
/// the last ranges, the call may return normally.) All later calls of this thread throw Cancelled
/// too while the scope lives. The results of cancelled calls are lost, but all objects stay usable:
/// a refiner, for example, has the levels that were complete. If the callback throws, the effect is
/// the same, with its exception instead of Cancelled.
///
/// Scopes of a thread must end in the reverse order of their beginning. The innermost one applies.
///
/// \cost nothing without a scope; with a scope, one query of the clock for each range of a loop
class ESPALIER_API ProgressScope {
public:
    /// Returns true to go on, false to cancel. It is called from any thread that works for the
    /// scope's thread, but never from two at once. Calls of the library inside the callback are not
    /// reported. The callback delays only the thread that calls it.
    using Callback = std::function<bool(const Progress&)>;

    /// \param interval shortest time between two calls; with 0, the callback is called at the end
    ///        of every range. A range that ends during a call is not reported.
    explicit ProgressScope(Callback callback,
                           std::chrono::milliseconds interval = std::chrono::milliseconds(20));
    ~ProgressScope();
    ProgressScope(const ProgressScope&) = delete;
    ProgressScope& operator=(const ProgressScope&) = delete;

private:
    std::unique_ptr<ProgressState> state_;
    ProgressState* outer_;
    bool wasInStage_;
};

/// Calls the callback of this thread's ProgressScope, if the interval has passed. Call it every few
/// milliseconds in work that is not in a parallel loop, or that takes longer than that in one range
/// of a loop.
/// \throws Cancelled if the callback has cancelled, or the exception of the callback; MemoryError
///         (memory.h) if the process exceeds the limit
/// \cost as one range of a loop: nothing without a scope and a limit; else a query of the clock
ESPALIER_API void checkCancelled();

/// Calls checkCancelled() in the first of every 2^`bits` steps of a loop.
inline void checkCancelledEvery(Offset step, int bits) {
    if ((step & ((Offset{1} << bits) - 1)) == 0) checkCancelled();
}

/// Calls visit(first, last) for ranges of `size` items that cover [0, count), one after the other,
/// and checkCancelled() before each. For loops whose steps take less than a nanosecond or two.
template <class Visit>
void forEachBlock(std::size_t count, std::size_t size, Visit visit) {
    for (std::size_t first = 0; first < count; first += size) {
        checkCancelled();
        visit(first, std::min(first + size, count));
    }
}

}  // namespace espalier
