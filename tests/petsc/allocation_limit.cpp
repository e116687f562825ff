// SPDX-License-Identifier: Apache-2.0
#include "allocation_limit.h"

#include <cstdlib>
#include <limits>
#include <new>

namespace espalier::test {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
thread_local std::size_t limit = kNone;

}  // namespace

AllocationLimit::AllocationLimit(std::size_t bytes) {
    limit = bytes;
}

AllocationLimit::~AllocationLimit() {
    limit = kNone;
}

}  // namespace espalier::test

// Replaces these operators for the whole program, in all forms that it uses. Sanitizers have their
// own versions of the others, whose memory std::free() would not accept.
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
    return bytes <= espalier::test::limit ? std::malloc(bytes ? bytes : 1) : nullptr;
}

void* operator new(std::size_t bytes) {
    void* const memory = operator new(bytes, std::nothrow);
    if (!memory) throw std::bad_alloc();
    return memory;
}

void operator delete(void* memory) noexcept {
    std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}

void operator delete(void* memory, const std::nothrow_t&) noexcept {
    std::free(memory);
}
