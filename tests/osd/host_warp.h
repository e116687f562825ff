// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "osd/device/device_kernels.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <vector>

namespace espalier::osd::device {

/// A warp on the host (device_kernels.h). It runs the lanes one by one, and reverses their order in
/// every other each(). So results change if lanes depend on each other within one each().
class HostWarp {
public:
    template <class T>
    class PerLane {
    public:
        T& operator[](int lane) { return values_[lane]; }

    private:
        std::array<T, kWarp> values_;
    };

    template <class F>
    void each(F f) {
        isForward_ = !isForward_;
        for (int i = 0; i < kWarp; ++i) f(isForward_ ? i : kWarp - 1 - i);
    }

    template <class Real, int n>
    void sumOver(PerLane<Values<Real, n>>& values, int lanes) {
        for (int c = 0; c < n; ++c) {
            const auto sums = sumsOf<Real>([&](int lane) { return values[lane].of[c]; }, lanes);
            for (int lane = 0; lane < kWarp; ++lane) values[lane].of[c] = sums[at(lane)];
        }
    }

    template <class Real, int n>
    void sumAll(PerLane<Values<Real, n>>& values) {
        static_assert(n % kWarp == 0);
        for (int t = 0; t < n / kWarp; ++t) {
            std::array<Real, kWarp> all;
            for (int i = 0; i < kWarp; ++i)
                all[at(i)] = sumsOf<Real>([&](int lane) { return values[lane].of[t * kWarp + i]; },
                                          kWarp)[at(i)];
            for (int lane = 0; lane < kWarp; ++lane) values[lane].of[t] = all[at(lane)];
        }
    }

    template <class T, class Real>
    static T load(const Real* address) {
        static_assert(sizeof(T) == 16);
        // A device would fault here.
        if (reinterpret_cast<std::uintptr_t>(address) % 16 != 0)
            throw std::logic_error("16 bytes are loaded at an address that is no multiple of 16");
        T value;
        std::memcpy(&value, address, sizeof(value));
        return value;
    }

    /// Copies as late as possible.
    template <int toBytes, int fromBytes, class T>
    void copy(T* to, const T* from) {
        if (reinterpret_cast<std::uintptr_t>(from) % sizeof(T) != 0)
            throw std::logic_error("a copy begins at an address that is no multiple of its size");
        constexpr int size = sizeof(T);
        static_assert(toBytes % size == 0 && fromBytes % size == 0);
        copies_.push_back([to, from] { to[toBytes / size] = from[fromBytes / size]; });
    }

    template <class Real>
    static void storeIf(bool isStored, Real* to, Real value) {
        if (isStored) *to = value;
    }

    void waitForCopies() {
        for (const auto& copy : copies_) copy();
        copies_.clear();
    }

private:
    static std::size_t at(int i) { return std::size_t(i); }

    /// Adds as the lanes of a device do: each adds the sum of its partner, at distances that are
    /// halved.
    template <class Real, class ValueOf>
    static std::array<Real, kWarp> sumsOf(ValueOf valueOf, int lanes) {
        std::array<Real, kWarp> sums;
        for (int lane = 0; lane < kWarp; ++lane) sums[at(lane)] = valueOf(lane);
        for (int distance = lanes / 2; distance > 0; distance /= 2) {
            const auto before = sums;
            for (int lane = 0; lane < kWarp; ++lane)
                sums[at(lane)] = before[at(lane)] + before[at(lane ^ distance)];
        }
        return sums;
    }

    bool isForward_ = false;
    std::vector<std::function<void()>> copies_;
};

/// Starts kernels on the host, warp after warp. Shared memory is filled with NaNs for each warp.
struct HostLaunch {
    template <class Kernel>
    void operator()(Kernel kernel) const {
        HostWarp warp;
        if constexpr (requires { kernel.divideAmong(0); })
            kernel.divideAmong(3);  // so that warps have several tasks, of several groups
        const unsigned bytes = kernel.sharedBytes();
        std::vector<Quad<double>> shared((bytes + sizeof(Quad<double>) - 1) / sizeof(Quad<double>));
        for (Index i = 0; i < kernel.warpCount(); ++i) {
            if (bytes > 0) std::memset(shared.data(), 0xFF, bytes);
            kernel(warp, i, reinterpret_cast<unsigned char*>(shared.data()));
        }
    }
};

}  // namespace espalier::osd::device
