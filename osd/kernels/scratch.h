// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/osd/kernels/kernels.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <vector>

// How values lie in memory that kernels read.

// How the memory of a workspace is shared out.

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

/// Bytes of `count` times `each` values in a Room: a multiple of `alignment`. A few of these
/// can be added without overflow.
/// \throws std::bad_array_new_length if that is more than any memory holds
template <class T, std::size_t alignment = 64>
constexpr std::size_t scratchBytes(Offset count, Offset each = 1) {
    constexpr std::size_t kMaxBytes = std::size_t{1} << 60;
    std::size_t bytes = 0;
    if (__builtin_mul_overflow(count, each, &bytes) ||
        __builtin_mul_overflow(bytes, sizeof(T), &bytes) || bytes > kMaxBytes)
        throw std::bad_array_new_length();
    return (bytes + alignment - 1) / alignment * alignment;
}

/// Memory that is handed out part by part, each aligned to 64 bytes. Not initialized.
class Scratch {
public:
    explicit Scratch(std::byte* memory) : memory_(memory) {}

    template <class T>
    std::span<T> take(Offset count) {
        T* const values = reinterpret_cast<T*>(memory_);
        memory_ += scratchBytes<T>(count);
        return {values, static_cast<std::size_t>(count)};
    }

private:
    std::byte* memory_;
};

/// What each task of a parallel loop holds its numbers in: on its stack if that is not much, and
/// else in a part of the room that it has for itself.
template <class Real>
class TaskBuffers {
public:
    /// So many at a time.
    TaskBuffers(Offset taskCount, Offset count)
        : taskCount_(taskCount), count_(count <= kOnStack ? 0 : count) {}

    std::size_t bytes() const {
        return scratchBytes<std::byte>(taskCount_, static_cast<Offset>(scratchBytes<Real>(count_)));
    }

    /// Before the tasks.
    void allocateFrom(Scratch& scratch) {
        if (count_ > 0) values_ = scratch.take<std::byte>(static_cast<Offset>(bytes())).data();
    }

    /// On the stack of a task.
    class Local {
    public:
        Local(const TaskBuffers& all, Offset task)
            : values_(all.count_ == 0 ? onStack_
                                      : reinterpret_cast<Real*>(
                                            all.values_ + static_cast<std::size_t>(task) *
                                                              scratchBytes<Real>(all.count_))) {}
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
    Offset count_;  ///< 0 if they are on the stack
    std::byte* values_ = nullptr;
};

/// Whether entries lie as the kernels want them: apart by their length as padded, and aligned.
template <class Real>
bool isPadded(Index count, std::span<const Real> source, const BufferDescriptor& layout) {
    return layout.stride == paddedLength(layout.length) &&
           static_cast<Offset>(source.size()) >= layout.offset + count * layout.stride &&
           reinterpret_cast<std::uintptr_t>(source.data() + layout.offset) %
                   (kernels::kPadding * sizeof(Real)) ==
               0;
}

/// An entry as the kernels want it, with zeros behind.
template <class Real>
void copyPadded(const Real* entry, Offset length, Offset paddedStride, Real* to) {
    std::fill(std::copy_n(entry, length, to), to + paddedStride, Real{0});
}

}  // namespace espalier::osd
