// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/array.h>
#include <espalier/osd/evaluation.h>
#include <espalier/osd/kernels/kernels.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <span>
#include <vector>

// The memory layout of values that kernels read, and the division of a workspace into parts.

namespace espalier::osd {

/// Allocates memory aligned to 64 bytes, the size of the widest register. Like the allocator of
/// Array, it leaves new elements uninitialized unless they are given a value.
template <class T>
struct Aligned : UninitializedAllocator<T> {
    static constexpr std::align_val_t kAlignment{64};
    template <class U>
    struct rebind {
        using other = Aligned<U>;
    };

    Aligned() = default;
    template <class U>
    Aligned(const Aligned<U>&) {}
    T* allocate(std::size_t count) {
        // Large arrays are aligned to 2 MB.
        if (count >= kLargeArray / sizeof(T)) return UninitializedAllocator<T>::allocate(count);
        return static_cast<T*>(::operator new(count * sizeof(T), kAlignment));
    }
    void deallocate(T* values, std::size_t count) {
        if (count >= kLargeArray / sizeof(T))
            return UninitializedAllocator<T>::deallocate(values, count);
        ::operator delete(values, kAlignment);
    }
};

template <class T>
using AlignedVector = std::vector<T, Aligned<T>>;

/// Returns the distance between entries of `length` components that are padded for the kernels.
inline Offset paddedLength(Offset length) {
    return (length + kernels::kPadding - 1) / kernels::kPadding * kernels::kPadding;
}

/// Returns the number of bytes that Scratch::take() uses for `count` · `length` values, rounded up
/// to a multiple of `alignment`. The result is small enough that a few of them add up without
/// overflow.
/// \throws std::bad_array_new_length if no memory could hold that many values
template <class T, std::size_t alignment = 64>
constexpr std::size_t scratchBytes(Offset count, Offset length = 1) {
    constexpr std::size_t kMaxBytes = std::numeric_limits<std::size_t>::max() / 16;
    std::size_t bytes = 0;
    if (__builtin_mul_overflow(count, length, &bytes) ||
        __builtin_mul_overflow(bytes, sizeof(T), &bytes) || bytes > kMaxBytes)
        throw std::bad_array_new_length();
    return (bytes + alignment - 1) / alignment * alignment;
}

/// Divides a block of memory into parts, each aligned to 64 bytes. The parts are not initialized.
class Scratch {
public:
    explicit Scratch(std::byte* memory) : memory_(memory) {}

    template <class T>
    std::span<T> take(Offset count) {
        T* const values = reinterpret_cast<T*>(memory_);
        memory_ += scratchBytes<T>(count);
        return {values, values + count};
    }

private:
    std::byte* memory_;
};

/// Gives each task of a parallel loop a buffer for its numbers: on the stack of the task if it is
/// small, otherwise in a part of the workspace that belongs to the task.
template <class Real>
class TaskBuffers {
public:
    /// \param count numbers in the buffer of each task
    TaskBuffers(Offset taskCount, Offset count)
        : taskCount_(taskCount), count_(count <= kOnStack ? 0 : count) {}

    std::size_t bytes() const {
        return scratchBytes<std::byte>(taskCount_, static_cast<Offset>(scratchBytes<Real>(count_)));
    }

    /// Must be called before the loop.
    void allocateFrom(Scratch& scratch) {
        if (count_ > 0) values_ = scratch.take<std::byte>(static_cast<Offset>(bytes())).data();
    }

    /// The buffer of one task, to be created on its stack.
    class Local {
    public:
        Local(const TaskBuffers& all, Offset task)
            : values_(all.count_ == 0 ? onStack_
                                      : reinterpret_cast<Real*>(
                                            all.values_ + task * scratchBytes<Real>(all.count_))) {}
        Local(const Local&) = delete;
        Local& operator=(const Local&) = delete;
        Real* data() { return values_; }

    private:
        alignas(64) Real onStack_[(1 << 14) / sizeof(Real)];
        Real* values_;
    };

private:
    static constexpr Offset kOnStack = (1 << 14) / sizeof(Real);

    Offset taskCount_;
    Offset count_;  ///< 0 if the buffers are on the stacks
    std::byte* values_ = nullptr;
};

/// Returns true if the source has the layout that kernels read directly: its stride is padded and
/// its first entry is aligned.
template <class Real>
bool isPadded(Index count, std::span<const Real> source, const BufferDescriptor& layout) {
    return layout.stride == paddedLength(layout.length) &&
           static_cast<Offset>(source.size()) >= layout.offset + count * layout.stride &&
           reinterpret_cast<std::uintptr_t>(source.data() + layout.offset) %
                   (kernels::kPadding * sizeof(Real)) ==
               0;
}

/// Copies an entry and fills the padding behind it with zeros.
template <class Real>
void copyPadded(const Real* entry, Offset length, Offset paddedStride, Real* to) {
    if (length == 3) {  // points, without loops of unknown length
        to[0] = entry[0], to[1] = entry[1], to[2] = entry[2], to[3] = 0;
        return;
    }
    std::fill(std::copy_n(entry, length, to), to + paddedStride, Real{0});
}

/// Adds an addend to the result of a row.
template <class Real>
void addTo(Real* result, Offset length, Index row, const Addend<Real>& addend) {
    const auto& layout = addend.layout;
    if (layout.length == 0) return;
    const Real* const own = addend.values.data() + layout.offset + row * layout.stride;
    for (; length > 0; length -= layout.length, result += layout.length)
        for (Offset c = 0; c < layout.length; ++c) result[c] += own[c];
}

}  // namespace espalier::osd
