// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

// A fake device that is the host: it implements the calls of CUDA's runtime that we make
// (fake_cuda.cpp), to test our use of them on machines without a GPU.
//
// Work on a stream runs only when something waits for the stream. There are two devices, whose
// streams are not ordered with each other. Page-locked memory of the host is read and written when
// the work runs, too. Under the address sanitizer, only work on a stream may access memory of a
// device.
namespace espalier::test::fake_cuda {

/// Returns the names of the calls since it was last called.
std::vector<std::string> takeCalls();

/// Lets a later call fail: 1 is the next one, 0 none.
/// \return the name of the call that has failed since this was last called; empty if none has
std::string failCall(int number);

/// Returns the number of allocations that have not been freed.
std::size_t allocationCount();

}  // namespace espalier::test::fake_cuda
