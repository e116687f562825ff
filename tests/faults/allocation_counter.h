// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace espalier::test {

// For those who allocate: what stands in for the functions of the C library, or of C++.

/// Counts an allocation; whether it is to fail.
bool allocationFails();

/// Counts a block that is there from now on, or is not any more.
void addLiveBlock();
void removeLiveBlock();

}  // namespace espalier::test
