// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/kernels/kernels.h>

#include <cstddef>
#include <new>
#include <vector>

// How values lie in memory that kernels read.
namespace espalier::osd {

/// Memory at an address that registers are loaded from.
template <class T>
struct Aligned {
    using value_type = T;
    static constexpr std::align_val_t kAlignment{64};

    Aligned() = default;
    template <class U>
    Aligned(const Aligned<U>&) {}
    T* allocate(std::size_t count) {
        return static_cast<T*>(::operator new(count * sizeof(T), kAlignment));
    }
    void deallocate(T* values, std::size_t) { ::operator delete(values, kAlignment); }
    friend bool operator==(const Aligned&, const Aligned&) { return true; }
};

template <class T>
using AlignedVector = std::vector<T, Aligned<T>>;

/// Numbers from one entry of so many components to the next.
inline Offset paddedLength(Offset length) {
    return (length + kernels::kPadding - 1) / kernels::kPadding * kernels::kPadding;
}

}  // namespace espalier::osd
