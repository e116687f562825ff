// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdlib>
#include <new>

#include "allocation_counter.h"

// Replaces operator new instead of malloc, for builds in which a sanitizer has its own malloc.
// Allocations of C code do not fail then, but the sanitizer finds uses of freed memory.

namespace {

void* counted(void* memory) {
    if (memory != nullptr) espalier::test::addLiveBlock();
    return memory;
}

void* orNull(std::size_t size) {
    return espalier::test::allocationFails() ? nullptr : counted(std::malloc(size > 0 ? size : 1));
}

void* orNull(std::size_t size, std::align_val_t alignment) {
    if (espalier::test::allocationFails()) return nullptr;
    const auto unit = std::size_t(alignment);
    return counted(std::aligned_alloc(unit, (size / unit + 1) * unit));
}

void* orThrow(void* memory) {
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

void release(void* memory) {
    if (memory != nullptr) espalier::test::removeLiveBlock();
    std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) {
    return orThrow(orNull(size));
}
void* operator new[](std::size_t size) {
    return orThrow(orNull(size));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    return orNull(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
    return orNull(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
    return orThrow(orNull(size, alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
    return orThrow(orNull(size, alignment));
}

void operator delete(void* memory) noexcept {
    release(memory);
}
void operator delete[](void* memory) noexcept {
    release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    release(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
    release(memory);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
    release(memory);
}
void operator delete[](void* memory, const std::nothrow_t&) noexcept {
    release(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    release(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
    release(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    release(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
    release(memory);
}
