// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

// A device that is the host, behind the calls of CUDA's runtime that we make (fake_cuda.cpp): to
// test what we do with these on machines without a GPU.
//
// What is put on a stream runs when something waits for the stream, and no earlier. Under the
// address sanitizer, memory of the device may be touched by what runs on a stream and by nothing
// else.
namespace espalier::test::fake_cuda {

/// The calls since the last time that this was called, by name.
std::vector<std::string> takeCalls();

/// Lets the call with this number fail, counted from 1 from here on; 0: none.
/// \return whether the one that was to fail before has come
bool failCall(int number);

/// Allocations that have not been freed.
std::size_t allocationCount();

}  // namespace espalier::test::fake_cuda
