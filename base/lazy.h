// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>

namespace espalier {

/// A value that is made on first use, by any thread.
///
/// No thread waits: threads that request the value at the same time all make it, and the first
/// result wins. Waiting could deadlock a thread that requests the same value again, from other work
/// that it takes up while it waits, or from a signal handler.
template <class T>
class Lazy {
public:
    Lazy() = default;
    ~Lazy() { delete known_.load(std::memory_order_relaxed); }
    Lazy(const Lazy&) = delete;
    Lazy& operator=(const Lazy&) = delete;

    /// Returns the value, or null if it has not been made yet.
    const T* known() const { return known_.load(std::memory_order_acquire); }

    /// Returns the value. Calls make() if it has not been made yet.
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
