// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace espalier::test {

/// While an object exists, operator new throws std::bad_alloc for single allocations of more than
/// `bytes`. (PETSc and MPI do not use operator new.)
class AllocationLimit {
public:
    explicit AllocationLimit(std::size_t bytes);
    ~AllocationLimit();
    AllocationLimit(const AllocationLimit&) = delete;
    AllocationLimit& operator=(const AllocationLimit&) = delete;
};

}  // namespace espalier::test
