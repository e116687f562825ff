// SPDX-License-Identifier: Apache-2.0
#include "cuda_calls.h"

namespace espalier::osd {

void check(cudaError_t error, const std::string& call) {
    if (error == cudaSuccess) return;
    // It is told here, and not once more to whoever asks CUDA for the last error.
    cudaGetLastError();
    throw CudaError(error, call + " has failed: " + cudaGetErrorString(error) + " (" +
                               cudaGetErrorName(error) + ")");
}

int currentDevice() {
    int device = 0;
    check(cudaGetDevice(&device), "cudaGetDevice");
    return device;
}

DeviceScope::DeviceScope(int device) : before_(currentDevice()), device_(device) {
    if (before_ != device_) check(cudaSetDevice(device_), "cudaSetDevice");
}

DeviceScope::~DeviceScope() {
    if (before_ != device_) cudaSetDevice(before_);
}

void* allocateOnDevice(std::size_t bytes) {
    if (bytes == 0) return nullptr;
    void* memory = nullptr;
    check(cudaMalloc(&memory, bytes), "cudaMalloc of " + std::to_string(bytes) + " bytes");
    return memory;
}

void copyToDevice(void* to, const void* from, std::size_t bytes) {
    if (bytes == 0) return;
    check(cudaMemcpy(to, from, bytes, cudaMemcpyHostToDevice), "cudaMemcpy to the device");
    check(cudaStreamSynchronize(nullptr), "cudaStreamSynchronize");
}

DeviceArrays::~DeviceArrays() {
    for (void* const array : arrays_) cudaFree(array);
}

void* DeviceArrays::add(const void* values, std::size_t bytes) {
    arrays_.reserve(arrays_.size() + 1);
    void* const memory = allocateOnDevice(bytes);
    if (memory == nullptr) return nullptr;
    arrays_.push_back(memory);
    byteCount_ += bytes;
    copyToDevice(memory, values, bytes);
    return memory;
}

}  // namespace espalier::osd
