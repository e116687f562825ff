// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

// A device that is the host, behind the calls of CUDA's runtime that we make (fake_cuda.cpp): to
// test what we do with these on machines without a GPU.
//
// What is put on a stream runs when something waits for the stream, and no earlier; there are two
// devices, whose streams are not ordered with each other. Memory of the host is read and written at
// that time, too, where it is page-locked. Under the address sanitizer, memory of a device may be
// touched by what runs on a stream and by nothing else.
namespace espalier::test::fake_cuda {

/// The calls since the last time that this was called, by name.
std::vector<std::string> takeCalls();

/// Lets the call with this number fail, counted from 1 from here on; 0: none.
/// \return the name of the one that has failed since this was called before; empty if none has
std::string failCall(int number);

/// Allocations that have not been freed.
std::size_t allocationCount();

}  // namespace espalier::test::fake_cuda
