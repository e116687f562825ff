// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace espalier::test {

// Called by the functions that replace the allocation functions of the C library or of C++.

/// Counts an allocation. Returns true if it must fail.
bool allocationFails();

/// Counts a block that has been allocated, or freed.
void addLiveBlock();
void removeLiveBlock();

}  // namespace espalier::test
