// SPDX-License-Identifier: Apache-2.0
#include "fake_cuda.h"

#include <cuda_runtime_api.h>
#include "osd/cuda/cuda_launch.h"
#include "osd/device/device_evaluation.h"

#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <utility>

#include "host_warp.h"
#include "support/sanitizers.h"
#ifdef ESPALIER_ADDRESS_SANITIZER
#include <sanitizer/asan_interface.h>
#endif

using Work = std::vector<std::function<void()>>;

struct CUstream_st {
    int device = 0;
    Work queue;
    CUgraph_st* captured = nullptr;  ///< receives the work instead of the queue while the stream is
                                     ///< captured
};
struct CUgraph_st {
    Work work;
};
struct CUgraphExec_st {
    Work work;
};

namespace {

constexpr int kDeviceCount = 2;
constexpr std::align_val_t kAlignment{256};

struct Device {
    std::vector<std::string> calls;
    int failing = 0;  ///< number of the call from now on that is to fail; 0: none
    std::string failed;
    cudaError_t lastError = cudaSuccess;
    int current = 0;
    CUstream_st defaultStreams[kDeviceCount] = {{0, {}, nullptr}, {1, {}, nullptr}};
    std::set<CUstream_st*> streams;  ///< streams other than the default ones
    std::map<void*, std::size_t> memory, pageLocked;
} device;

/// Begins every call: records it, and returns an error if it is the call that is to fail.
cudaError_t enter(const char* name, cudaError_t how = cudaErrorUnknown) {
    device.calls.emplace_back(name);
    if (device.failing == 0 || --device.failing > 0) return cudaSuccess;
    device.failed = name;
    return device.lastError = how;
}

void setAccess([[maybe_unused]] bool isOpen) {
#ifdef ESPALIER_ADDRESS_SANITIZER
    for (const auto& [memory, size] : device.memory)
        isOpen ? __asan_unpoison_memory_region(memory, size)
               : __asan_poison_memory_region(memory, size);
#endif
}

/// Allows access to memory of the device within a scope.
struct DeviceAccess {
    DeviceAccess() { setAccess(true); }
    ~DeviceAccess() { setAccess(false); }
};

CUstream_st& streamOf(cudaStream_t stream) {
    return stream == nullptr ? device.defaultStreams[device.current] : *stream;
}

void put(cudaStream_t stream, std::function<void()> work) {
    CUstream_st& on = streamOf(stream);
    (on.captured == nullptr ? on.queue : on.captured->work).push_back(std::move(work));
}

void finish(CUstream_st& stream) {
    const DeviceAccess access;
    for (const auto& work : std::exchange(stream.queue, {})) work();
}

void finishAll() {
    for (CUstream_st& stream : device.defaultStreams) finish(stream);
    for (CUstream_st* const stream : device.streams) finish(*stream);
}

/// Frees memory at the end that was given back on a stream for which nothing waited.
struct AtExit {
    ~AtExit() { finishAll(); }
} atExit;

void* allocate(std::size_t size) {
    void* const memory = ::operator new(size, kAlignment);
    std::memset(memory, 0xFF, size);  // fills it with NaNs
    device.memory.emplace(memory, size);
    setAccess(false);
    return memory;
}

void release(void* memory) {
    setAccess(true);
    device.memory.erase(memory);
    ::operator delete(memory, kAlignment);
    setAccess(false);
}

/// Returns true if a range is within one of these allocations.
bool isIn(const std::map<void*, std::size_t>& all, const void* first, std::size_t bytes) {
    const auto* const address = static_cast<const std::byte*>(first);
    for (const auto& [memory, size] : all) {
        const auto* const start = static_cast<const std::byte*>(memory);
        if (address >= start && address + bytes <= start + size) return true;
    }
    return false;
}

/// Copies rows between host and device. Rows on the host may be contiguous or a pitch apart.
cudaError_t copy(void* to, std::size_t toPitch, const void* from, std::size_t fromPitch,
                 std::size_t width, std::size_t height, cudaMemcpyKind kind, cudaStream_t stream) {
    if (height == 0 || width == 0) return cudaSuccess;
    const bool isUpload = kind == cudaMemcpyHostToDevice;
    const void* const onDevice = isUpload ? to : from;
    const std::size_t pitch = isUpload ? toPitch : fromPitch;
    if (!isIn(device.memory, onDevice, (height - 1) * pitch + width))
        return device.lastError = cudaErrorInvalidValue;
    const bool isPageLocked = isIn(device.pageLocked, isUpload ? from : to,
                                   (height - 1) * (isUpload ? fromPitch : toPitch) + width);
    const auto rows = [=](void* target, std::size_t targetPitch, const void* source,
                          std::size_t sourcePitch) {
        for (std::size_t i = 0; i < height; ++i)
            std::memcpy(static_cast<std::byte*>(target) + i * targetPitch,
                        static_cast<const std::byte*>(source) + i * sourcePitch, width);
    };
    if (isPageLocked) {
        put(stream, [=] { rows(to, toPitch, from, fromPitch); });
    } else if (isUpload) {
        // The host's memory is read before the call returns, the device's is written later.
        auto staged = std::make_shared<std::vector<std::byte>>(width * height);
        rows(staged->data(), width, from, fromPitch);
        put(stream, [=] { rows(to, toPitch, staged->data(), width); });
    } else {
        put(stream, [=] { rows(to, toPitch, from, fromPitch); });
        if (streamOf(stream).captured == nullptr) finish(streamOf(stream));
    }
    return cudaSuccess;
}

}  // namespace

namespace espalier::test::fake_cuda {

std::vector<std::string> takeCalls() {
    return std::exchange(device.calls, {});
}

std::string failCall(int number) {
    device.failing = number;
    return std::exchange(device.failed, {});
}

std::size_t allocationCount() {
    return device.memory.size();
}

}  // namespace espalier::test::fake_cuda

cudaError_t cudaGetDeviceCount(int* count) {
    *count = kDeviceCount;
    return enter("cudaGetDeviceCount");
}

cudaError_t cudaGetDevice(int* current) {
    *current = device.current;
    return enter("cudaGetDevice");
}

cudaError_t cudaSetDevice(int current) {
    if (const auto error = enter("cudaSetDevice")) return error;
    if (current < 0 || current >= kDeviceCount) return device.lastError = cudaErrorInvalidDevice;
    device.current = current;
    return cudaSuccess;
}

cudaError_t cudaGetLastError() {
    return std::exchange(device.lastError, cudaSuccess);
}

const char* cudaGetErrorName(cudaError_t error) {
    return error == cudaErrorMemoryAllocation ? "cudaErrorMemoryAllocation" : "cudaErrorOfATest";
}

const char* cudaGetErrorString(cudaError_t error) {
    return error == cudaErrorMemoryAllocation ? "out of memory" : "as the test wants it";
}

cudaError_t cudaMalloc(void** memory, std::size_t size) {
    if (const auto error = enter("cudaMalloc", cudaErrorMemoryAllocation)) return error;
    *memory = allocate(size);
    return cudaSuccess;
}

cudaError_t cudaFree(void* memory) {
    device.calls.emplace_back("cudaFree");
    if (memory == nullptr) return cudaSuccess;
    finishAll();
    release(memory);
    return cudaSuccess;
}

cudaError_t cudaMallocAsync(void** memory, std::size_t size, cudaStream_t) {
    if (const auto error = enter("cudaMallocAsync", cudaErrorMemoryAllocation)) return error;
    *memory = allocate(size);
    return cudaSuccess;
}

cudaError_t cudaFreeAsync(void* memory, cudaStream_t stream) {
    device.calls.emplace_back("cudaFreeAsync");
    // A graph may free only memory that was allocated in it.
    if (streamOf(stream).captured != nullptr) return device.lastError = cudaErrorInvalidValue;
    put(stream, [=] {
        release(memory);
        setAccess(true);
    });
    return cudaSuccess;
}

cudaError_t cudaMallocHost(void** memory, std::size_t size) {
    *memory = ::operator new(size, kAlignment);
    device.pageLocked.emplace(*memory, size);
    return cudaSuccess;
}

cudaError_t cudaFreeHost(void* memory) {
    device.pageLocked.erase(memory);
    ::operator delete(memory, kAlignment);
    return cudaSuccess;
}

// A copy to the device returns before the data has arrived there.
cudaError_t cudaMemcpy(void* to, const void* from, std::size_t size, cudaMemcpyKind kind) {
    if (const auto error = enter("cudaMemcpy")) return error;
    return copy(to, size, from, size, size, 1, kind, nullptr);
}

cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t size, cudaMemcpyKind kind,
                            cudaStream_t stream) {
    if (const auto error = enter("cudaMemcpyAsync")) return error;
    return copy(to, size, from, size, size, 1, kind, stream);
}

cudaError_t cudaMemcpy2DAsync(void* to, std::size_t toPitch, const void* from,
                              std::size_t fromPitch, std::size_t width, std::size_t height,
                              cudaMemcpyKind kind, cudaStream_t stream) {
    if (const auto error = enter("cudaMemcpy2DAsync")) return error;
    return copy(to, toPitch, from, fromPitch, width, height, kind, stream);
}

cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned) {
    device.streams.insert(*stream = new CUstream_st{device.current, {}, nullptr});
    return cudaSuccess;
}

cudaError_t cudaStreamDestroy(cudaStream_t stream) {
    finish(*stream);
    device.streams.erase(stream);
    delete stream;
    return cudaSuccess;
}

cudaError_t cudaStreamSynchronize(cudaStream_t stream) {
    if (const auto error = enter("cudaStreamSynchronize")) return error;
    finish(streamOf(stream));
    return cudaSuccess;
}

cudaError_t cudaStreamIsCapturing(cudaStream_t stream, cudaStreamCaptureStatus* status) {
    if (const auto error = enter("cudaStreamIsCapturing")) return error;
    *status = streamOf(stream).captured == nullptr ? cudaStreamCaptureStatusNone
                                                   : cudaStreamCaptureStatusActive;
    return cudaSuccess;
}

cudaError_t cudaStreamBeginCapture(cudaStream_t stream, cudaStreamCaptureMode) {
    stream->captured = new CUgraph_st;
    return cudaSuccess;
}

cudaError_t cudaStreamEndCapture(cudaStream_t stream, cudaGraph_t* graph) {
    *graph = std::exchange(stream->captured, nullptr);
    return cudaSuccess;
}

cudaError_t cudaGraphInstantiate(cudaGraphExec_t* executable, cudaGraph_t graph,
                                 unsigned long long) {
    *executable = new CUgraphExec_st{graph->work};
    return cudaSuccess;
}

cudaError_t cudaGraphLaunch(cudaGraphExec_t executable, cudaStream_t stream) {
    for (const auto& work : executable->work) put(stream, work);
    return cudaSuccess;
}

cudaError_t cudaGraphDestroy(cudaGraph_t graph) {
    delete graph;
    return cudaSuccess;
}

cudaError_t cudaGraphExecDestroy(cudaGraphExec_t executable) {
    delete executable;
    return cudaSuccess;
}

namespace espalier::osd::device {
namespace {

template <class Kernel>
cudaError_t loadKernel(const Kernel&) {
    return enter("cudaFuncGetAttributes");
}

template <class Kernel>
cudaError_t startKernel(const Kernel& kernel, cudaStream_t stream) {
    if (kernel.warpCount() <= 0) return cudaSuccess;
    if (const auto error = enter("cudaLaunchKernel", cudaErrorLaunchOutOfResources)) return error;
    if (streamOf(stream).device != ::device.current) return cudaErrorInvalidResourceHandle;
    put(stream, [kernel] { HostLaunch{}(kernel); });
    return cudaSuccess;
}

}  // namespace

#include "osd/cuda/cuda_launch_body.h"

}  // namespace espalier::osd::device
