// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace espalier::test {

/// The allocations of this process that fail, in any library and on any thread.
enum class Failing {
    One,     ///< the n-th only: memory is short for a moment
    AllFrom  ///< the n-th and all later ones: memory is exhausted
};

/// Makes allocations fail until destruction. Only one may exist at a time.
class AllocationFault {
public:
    /// \param n number of the first allocation that fails, from 1
    AllocationFault(Failing failing, long n);
    ~AllocationFault();
    AllocationFault(const AllocationFault&) = delete;
    AllocationFault& operator=(const AllocationFault&) = delete;

    bool hasHappened() const;

    /// Returns the number of allocations since construction.
    long count() const;
};

/// Returns the number of allocated blocks that are not freed yet.
long liveBlocks();

}  // namespace espalier::test
