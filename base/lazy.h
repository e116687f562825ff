// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>

namespace espalier {

/// A value that is made when it is first asked for, by any thread.
///
/// Nobody waits: threads that ask at the same time all make the value, and the first result wins.
/// Waiting could deadlock a thread that takes up other work meanwhile, or that a signal handler
/// interrupts, and that then asks for the same value.
template <class T>
class Lazy {
public:
    Lazy() = default;
    ~Lazy() { delete known_.load(std::memory_order_relaxed); }
    Lazy(const Lazy&) = delete;
    Lazy& operator=(const Lazy&) = delete;

    /// The value, or null if it has not been made.
    const T* known() const { return known_.load(std::memory_order_acquire); }

    template <class Make>
    const T& get(Make make) {
        if (const T* value = known()) return *value;
        auto made = std::make_unique<const T>(make());
        const T* first = nullptr;
        if (!known_.compare_exchange_strong(first, made.get(), std::memory_order_acq_rel))
            return *first;
        return *made.release();
    }

private:
    std::atomic<const T*> known_ = nullptr;
};

}  // namespace espalier
