// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace espalier::test {

/// While it lives, operator new throws std::bad_alloc for more bytes than this at once. (PETSc and
/// MPI do not allocate by it.)
class AllocationLimit {
public:
    explicit AllocationLimit(std::size_t bytes);
    ~AllocationLimit();
    AllocationLimit(const AllocationLimit&) = delete;
    AllocationLimit& operator=(const AllocationLimit&) = delete;
};

}  // namespace espalier::test
