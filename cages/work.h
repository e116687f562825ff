// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/error.h>

namespace espalier::cages {

/// Thrown when a cage needs more work than it may take.
class WorkError : public Error {
public:
    using Error::Error;
};

/// Bounds the work of a cage, and lets the host of the library cancel it.
///
/// Work is counted in steps, from the sizes of what is processed: cells, points, voxels. So a bound
/// is reached at the same place on every machine, with any number of threads. A step takes one or
/// two nanoseconds on one core of 2020; the factors beside the sizes are measured and rounded.
class Work {
public:
    explicit Work(double limit) : limit_(limit) {}

    /// Counts work that is about to be done. Call it every few milliseconds.
    /// \throws WorkError if this is more than the limit allows; as checkCancelled()
    ///         (base/progress.h) does
    void add(double steps);

    double done() const { return done_; }

private:
    double limit_;
    double done_ = 0;
};

}  // namespace espalier::cages
