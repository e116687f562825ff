// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <new>
#include <vector>

namespace espalier {

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
