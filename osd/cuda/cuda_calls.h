// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>
#include <espalier/osd/cuda/cuda_evaluator.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

// CUDA's runtime, with exceptions and owners.
namespace espalier::osd {

/// \throws CudaError that names the call, if that has failed
void check(cudaError_t error, const std::string& call);

/// Makes a device current, and the one before it again.
class DeviceScope {
public:
    explicit DeviceScope(int device);
    ~DeviceScope();
    DeviceScope(const DeviceScope&) = delete;
    DeviceScope& operator=(const DeviceScope&) = delete;

private:
    int before_ = 0, device_ = 0;
};

/// The device that is current.
int currentDevice();

/// Memory of the current device; null for no bytes.
void* allocateOnDevice(std::size_t bytes);

/// Copies to memory of the current device, and waits until it is there, for any stream:
/// cudaMemcpy() alone does not, where the memory of the host is not page-locked.
void copyToDevice(void* to, const void* from, std::size_t bytes);

/// Arrays in memory of the current device.
class DeviceArrays {
public:
    DeviceArrays() = default;
    ~DeviceArrays();
    DeviceArrays(const DeviceArrays&) = delete;
    DeviceArrays& operator=(const DeviceArrays&) = delete;

    /// Copies one there.
    template <class T>
    const T* add(std::span<const T> values) {
        return static_cast<const T*>(add(values.data(), values.size_bytes()));
    }

    std::size_t byteCount() const { return byteCount_; }

private:
    void* add(const void* values, std::size_t bytes);

    std::vector<void*> arrays_;
    std::size_t byteCount_ = 0;
};

}  // namespace espalier::osd
