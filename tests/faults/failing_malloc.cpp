// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstddef>

#include "allocation_counter.h"

// Replaces malloc and its relatives. The C library allows this, and offers its own allocator under
// second names. Operator new uses these functions too.

using namespace espalier::test;

extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* memory);

}  // extern "C"

namespace {

void* refused() {
    errno = ENOMEM;
    return nullptr;
}

void* counted(void* memory) {
    if (memory != nullptr) addLiveBlock();
    return memory;
}

}  // namespace

extern "C" {

void* malloc(std::size_t size) {
    return allocationFails() ? refused() : counted(__libc_malloc(size));
}

void* calloc(std::size_t count, std::size_t size) {
    return allocationFails() ? refused() : counted(__libc_calloc(count, size));
}

void free(void* memory) {
    if (memory != nullptr) removeLiveBlock();
    __libc_free(memory);
}

void* realloc(void* memory, std::size_t size) {
    if (memory == nullptr) return malloc(size);
    if (size != 0) return allocationFails() ? refused() : __libc_realloc(memory, size);
    free(memory);
    return nullptr;
}

void* memalign(std::size_t alignment, std::size_t size) {
    return allocationFails() ? refused() : counted(__libc_memalign(alignment, size));
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
    return memalign(alignment, size);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
    void* const got = memalign(alignment, size);
    if (got == nullptr) return ENOMEM;
    *memory = got;
    return 0;
}

}  // extern "C"
