// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>

#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <vector>

namespace espalier {

/// Arrays of this number of bytes and more are allocated by allocateLargePages(): three quarters of
/// a large page.
inline constexpr std::size_t kLargeArray = std::size_t{3} << 19;

/// Lets the system hold fresh memory in large pages. Writing to it is up to three times as fast,
/// because the system gives 2 MB at a time instead of 4 kB. Large pages begin at multiples of 2 MB.
/// Memory before the first and after the last large page has pages of the usual size. If the system
/// has no large pages, all memory has pages of the usual size.
ESPALIER_API void preferLargePages(void* memory, std::size_t bytes);

/// Allocates memory that begins at a multiple of 2 MB, and calls preferLargePages(). If the memory
/// takes at least three quarters of its last large page, it gets the whole page: so at most a
/// quarter is unused.
/// \throws std::bad_alloc
ESPALIER_API void* allocateLargePages(std::size_t bytes);
/// Frees memory that allocateLargePages() returned.
ESPALIER_API void freeLargePages(void* memory);

/// An allocator that leaves new elements uninitialized unless they are given a value.
template <class T>
struct UninitializedAllocator : std::allocator<T> {
    UninitializedAllocator() = default;
    template <class U>
    UninitializedAllocator(const UninitializedAllocator<U>&) {}
    template <class U>
    struct rebind {
        using other = UninitializedAllocator<U>;
    };

    T* allocate(std::size_t count) {
        if (count < kLargeArray / sizeof(T)) return std::allocator<T>::allocate(count);
        if (count > std::numeric_limits<std::size_t>::max() / sizeof(T))
            throw std::bad_array_new_length();
        return static_cast<T*>(allocateLargePages(count * sizeof(T)));
    }
    void deallocate(T* memory, std::size_t count) {
        if (count < kLargeArray / sizeof(T)) return std::allocator<T>::deallocate(memory, count);
        freeLargePages(memory);
    }

    template <class U>
    void construct(U* at) {
        ::new (static_cast<void*>(at)) U;
    }
};

/// A vector for large arrays of numbers that are filled in parallel: Array<T>(n) and resize(n) do
/// not write the new elements. (Setting the elements of a table to 0 first takes as long as filling
/// them.)
template <class T>
using Array = std::vector<T, UninitializedAllocator<T>>;

}  // namespace espalier
