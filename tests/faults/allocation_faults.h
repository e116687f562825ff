// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace espalier::test {

/// Which allocations of this process fail, by whatever library and thread they are asked for.
enum class Failing {
    One,     ///< the n-th: memory is short for a moment
    AllFrom  ///< the n-th and all that follow: there is no more
};

/// While this lives, memory is short. One at a time.
class AllocationFault {
public:
    /// \param n from 1
    AllocationFault(Failing failing, long n);
    ~AllocationFault();
    AllocationFault(const AllocationFault&) = delete;
    AllocationFault& operator=(const AllocationFault&) = delete;

    bool hasHappened() const;

    /// Allocations that were asked for since.
    long count() const;
};

/// Allocations that are not freed yet.
long liveBlocks();

}  // namespace espalier::test
