// SPDX-License-Identifier: Apache-2.0
#include "call_counts.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <cstddef>

// Replaces functions of the C library. The C library allows this, and offers its own allocator
// under second names.
namespace {

std::atomic<long> allocations = 0;
std::atomic<long> locks = 0;

template <class Function>
Function* realFunction(std::atomic<Function*>& known, const char* name) {
    Function* function = known.load();
    if (function == nullptr) {
        function = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
        known = function;
    }
    return function;
}

std::atomic<int (*)(pthread_mutex_t*)> realLock = nullptr;
std::atomic<int (*)(pthread_once_t*, void (*)())> realOnce = nullptr;

}  // namespace

extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
    ++allocations;
    return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
    ++allocations;
    return __libc_calloc(count, size);
}

void* realloc(void* memory, std::size_t size) {
    ++allocations;
    return __libc_realloc(memory, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
    ++allocations;
    return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
    return memalign(alignment, size);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
    *memory = memalign(alignment, size);
    return *memory != nullptr ? 0 : ENOMEM;
}

int pthread_mutex_lock(pthread_mutex_t* mutex) {
    ++locks;
    return realFunction(realLock, "pthread_mutex_lock")(mutex);
}

int pthread_once(pthread_once_t* flag, void (*function)()) {
    ++locks;
    return realFunction(realOnce, "pthread_once")(flag, function);
}

}  // extern "C"

namespace espalier::test {

CallCounts callCounts() {
    return {allocations, locks};
}

}  // namespace espalier::test
