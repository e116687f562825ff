// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/index.h>

#include <chrono>
#include <exception>
#include <functional>
#include <memory>

namespace espalier {

class ProgressState;

/// How far a call has come.
///
/// A call is a sequence of stages, which are its outermost parallel loops of more than one range:
/// that of bindPoints() over points, which takes nearly all of its time; one or two a level for
/// tables, each level taking eight times the last one's; several a level for refinement. How many
/// there will be is not known beforehand. It depends on the arguments, but not on threads, and what
/// the first call has left for the next (derived incidences) that one need not do again.
/// What one thread does between stages is not counted, and cannot be cancelled: sorting, and all of
/// solve::fitLattice().
///
/// So a bar that shows the fraction fills once a stage. One for a whole call is the host's: it
/// knows what it calls, and how the stages of such calls share their time.
struct Progress {
    Offset stage = 0;  ///< stages that ended before, since the scope began
    Offset done = 0;   ///< items (points, rows, cells …) of this stage that are done
    Offset count = 0;  ///< its items; 0 between two stages

    /// Of the stage, 0 to 1; it never falls while the stage lasts.
    double fraction() const {
        return count > 0 ? static_cast<double>(done) / static_cast<double>(count) : 0;
    }
};

/// Thrown by whatever was at work when the callback of a ProgressScope wanted no more of it. Not an
/// Error: nobody has offended, and nobody who translates errors should take this for one.
class ESPALIER_API Cancelled : public std::exception {
public:
    const char* what() const noexcept override;
};

/// While this object lives, a callback hears how far the calls of this thread have come, and may
/// cancel them.
///
///     const ProgressScope scope([&](const Progress& progress) {
///         bar.show(progress.fraction());
///         return !bar.isCancelled();
///     });
///     const auto model = embed::bindPoints(…);  // may throw Cancelled
///
/// Once it returns false it is not called again, and calls throw Cancelled as soon as the ranges at
/// hand on other threads have come to a nested loop or to their end, or return if that was the last
/// of them; and so do all calls that this thread begins while the scope lives. What they were about
/// to return is gone; nothing else is changed: a refiner has the levels that were complete, and all
/// objects are as usable as before. What a callback throws has the same effect, and arrives instead
/// of Cancelled.
///
/// Scopes of a thread end in the reverse order of their beginning. Of two, the inner one counts.
///
/// \cost nothing without a scope; with one a look at the clock for each range of a loop
class ESPALIER_API ProgressScope {
public:
    /// Returns whether to go on. Called from any thread that works for this one, but never from
    /// two at once; what it does to the library is not reported. It holds up the thread that calls
    /// it, not the others.
    using Callback = std::function<bool(const Progress&)>;

    /// \param interval from one call to the next, at least; 0 calls at the end of every range. A
    ///        range that ends during a call is not told of.
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

}  // namespace espalier
