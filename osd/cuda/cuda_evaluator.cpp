// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/cuda/cuda_evaluator.h>

#include <cuda_runtime_api.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../device/device_table.h"
#include "../kernels/scratch.h"
#include "cuda_launch.h"

// CUDA's runtime behind exceptions and owning types.

namespace espalier::osd {

namespace {

/// \throws CudaError that names the call, if the call failed
void check(cudaError_t error, const std::string& call) {
    if (error == cudaSuccess) return;
    // Clears the error, so that the next caller of cudaGetLastError() does not get it again.
    cudaGetLastError();
    throw CudaError(error, concat(call, " has failed: ", cudaGetErrorString(error), " (",
                                  cudaGetErrorName(error), ")"));
}

int currentDevice() {
    int device = 0;
    check(cudaGetDevice(&device), "cudaGetDevice");
    return device;
}

/// Makes a device current, and restores the previous one at the end of the scope.
class DeviceScope {
public:
    explicit DeviceScope(int device) : before_(currentDevice()), device_(device) {
        if (before_ != device_) check(cudaSetDevice(device_), "cudaSetDevice");
    }
    ~DeviceScope() {
        if (before_ != device_) cudaSetDevice(before_);
    }
    DeviceScope(const DeviceScope&) = delete;
    DeviceScope& operator=(const DeviceScope&) = delete;

private:
    int before_ = 0, device_ = 0;
};

/// Allocates memory on the current device. Returns null for 0 bytes.
void* allocateOnDevice(std::size_t bytes) {
    if (bytes == 0) return nullptr;
    void* memory = nullptr;
    check(cudaMalloc(&memory, bytes), concat("cudaMalloc of ", bytes, " bytes"));
    return memory;
}

/// Copies to memory of the current device, and waits until the copy is visible to every stream.
/// cudaMemcpy() alone does not wait for that if the memory of the host is not page-locked.
void copyToDevice(void* to, const void* from, std::size_t bytes) {
    if (bytes == 0) return;
    check(cudaMemcpy(to, from, bytes, cudaMemcpyHostToDevice), "cudaMemcpy to the device");
    check(cudaStreamSynchronize(nullptr), "cudaStreamSynchronize");
}

/// Owns arrays in memory of the current device.
class DeviceArrays {
public:
    DeviceArrays() = default;
    ~DeviceArrays() {
        for (void* const array : arrays_) cudaFree(array);
    }
    DeviceArrays(const DeviceArrays&) = delete;
    DeviceArrays& operator=(const DeviceArrays&) = delete;

    /// Copies an array to the device and returns its address there.
    template <class T>
    const T* add(std::span<const T> values) {
        arrays_.reserve(arrays_.size() + 1);
        void* const memory = allocateOnDevice(values.size_bytes());
        if (memory == nullptr) return nullptr;
        arrays_.push_back(memory);
        byteCount_ += values.size_bytes();
        copyToDevice(memory, values.data(), values.size_bytes());
        return static_cast<const T*>(memory);
    }

    std::size_t byteCount() const { return byteCount_; }

private:
    std::vector<void*> arrays_;
    std::size_t byteCount_ = 0;
};

/// Returns the size in bytes of a part of a workspace. Parts start at multiples of 256, as CUDA's
/// own allocations do.
template <class Real>
std::size_t deviceScratchBytes(Offset count) {
    return osd::scratchBytes<Real, 256>(count);
}

template <class Real>
std::size_t bytesOf(Offset count) {
    return count * sizeof(Real);
}

/// Copies contiguous entries of the device to a destination on the host that has the given layout.
template <class Real>
void copyToHost(const Real* entries, Offset count, Real* to, const BufferDescriptor& layout,
                cudaStream_t stream) {
    const std::size_t bytes = bytesOf<Real>(layout.length);
    // A single row may have any stride, even one that is too large for CUDA.
    if (layout.stride == layout.length || count == 1)
        check(cudaMemcpyAsync(to, entries, bytesOf<Real>(count * layout.length),
                              cudaMemcpyDeviceToHost, stream),
              "cudaMemcpyAsync to the host");
    else
        check(cudaMemcpy2DAsync(to, bytesOf<Real>(layout.stride), entries, bytes, bytes, count,
                                cudaMemcpyDeviceToHost, stream),
              "cudaMemcpy2DAsync to the host");
}

/// Calls start(evaluation, slots, stream) for arguments that are already checked. If the source is
/// on the host, it copies the source to the device before; if the destination is on the host, it
/// copies the results there afterwards.
/// \param slotCount numbers that the evaluation needs as temporary memory
template <class Real, class Start>
void runOnDevice(Index sourceCount, CudaSource<Real> source, const BufferDescriptor& sourceLayout,
                 CudaDestination<Real> destination, const BufferDescriptor& destinationLayout,
                 RowRange rows, Offset slotCount, CudaWorkspace& workspace, Start start) {
    const cudaStream_t stream = workspace.stream();
    const Offset length = sourceLayout.length, rowCount = rows.last - rows.first;
    const Offset sourceNumbers =
        source.isOnHost && sourceCount > 0 ? (sourceCount - 1) * sourceLayout.stride + length : 0;
    const Offset destinationNumbers = destination.isOnHost ? rowCount * length : 0;
    std::byte* const memory = workspace.reserve(deviceScratchBytes<Real>(slotCount) +
                                                deviceScratchBytes<Real>(sourceNumbers) +
                                                deviceScratchBytes<Real>(destinationNumbers));
    Real* const slots = reinterpret_cast<Real*>(memory);
    Real* const sourceCopy = reinterpret_cast<Real*>(memory + deviceScratchBytes<Real>(slotCount));
    Real* const results = reinterpret_cast<Real*>(memory + deviceScratchBytes<Real>(slotCount) +
                                                  deviceScratchBytes<Real>(sourceNumbers));
    if (sourceNumbers > 0)
        check(cudaMemcpyAsync(sourceCopy, source.data + sourceLayout.offset,
                              bytesOf<Real>(sourceNumbers), cudaMemcpyHostToDevice, stream),
              "cudaMemcpyAsync to the device");

    device::Evaluation<Real> evaluation = {};
    evaluation.source = source.isOnHost ? sourceCopy : source.data + sourceLayout.offset;
    evaluation.sourceStride = sourceLayout.stride;
    evaluation.length = length;
    evaluation.first = rows.first;
    evaluation.last = rows.last;
    if (destination.isOnHost) {
        evaluation.destination = results;
        evaluation.destinationStride = length;
        evaluation.destinationFirst = rows.first;
    } else {
        evaluation.destination = destination.data + destinationLayout.offset;
        evaluation.destinationStride = destinationLayout.stride;
    }
    check(start(evaluation, slots, stream), "cudaLaunchKernel");
    if (destination.isOnHost)
        copyToHost(
            results, rowCount,
            destination.data + destinationLayout.offset + rows.first * destinationLayout.stride,
            destinationLayout, stream);
}

}  // namespace

int cudaDeviceCount() {
    int count = 0;
    const cudaError_t error = cudaGetDeviceCount(&count);
    if (error == cudaErrorNoDevice || error == cudaErrorInsufficientDriver) {
        cudaGetLastError();
        return 0;
    }
    check(error, "cudaGetDeviceCount");
    return count;
}

template <class Real>
CudaBuffer<Real>::CudaBuffer(std::size_t size)
    : device_(currentDevice()),
      data_(static_cast<Real*>(allocateOnDevice(scratchBytes<Real>(static_cast<Offset>(size))))),
      size_(size) {}

template <class Real>
CudaBuffer<Real>::CudaBuffer(std::span<const Real> values) : CudaBuffer(values.size()) {
    copyToDevice(data_, values.data(), values.size_bytes());
}

template <class Real>
CudaBuffer<Real>::~CudaBuffer() {
    // cudaFree() of a null pointer has an effect: it creates a context.
    if (data_ != nullptr) cudaFree(data_);
}

template <class Real>
CudaBuffer<Real>::CudaBuffer(CudaBuffer&& other) noexcept
    : device_(other.device_),
      data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

template <class Real>
CudaBuffer<Real>& CudaBuffer<Real>::operator=(CudaBuffer&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
}

template <class Real>
void CudaBuffer<Real>::upload(std::span<const Real> values, CudaStream stream) {
    checkSize(values.size());
    if (values.empty()) return;
    const DeviceScope scope(device_);
    check(
        cudaMemcpyAsync(data_, values.data(), values.size_bytes(), cudaMemcpyHostToDevice, stream),
        "cudaMemcpyAsync to the device");
}

template <class Real>
void CudaBuffer<Real>::download(std::span<Real> values, CudaStream stream) const {
    checkSize(values.size());
    if (values.empty()) return;
    const DeviceScope scope(device_);
    check(
        cudaMemcpyAsync(values.data(), data_, values.size_bytes(), cudaMemcpyDeviceToHost, stream),
        "cudaMemcpyAsync to the host");
}

template <class Real>
void CudaBuffer<Real>::checkSize(std::size_t size) const {
    if (size > size_)
        throw Error(concat("the buffer on the device holds ", size_, " numbers; ", size,
                           " were to be copied"));
}

CudaWorkspace::CudaWorkspace(CudaStream stream) : stream_(stream), device_(currentDevice()) {}

CudaWorkspace::~CudaWorkspace() {
    release();
}

CudaWorkspace::CudaWorkspace(CudaWorkspace&& other) noexcept
    : stream_(other.stream_),
      device_(other.device_),
      memory_(std::exchange(other.memory_, nullptr)),
      byteCount_(std::exchange(other.byteCount_, 0)),
      isInGraph_(std::exchange(other.isInGraph_, false)) {}

CudaWorkspace& CudaWorkspace::operator=(CudaWorkspace&& other) noexcept {
    std::swap(stream_, other.stream_);
    std::swap(device_, other.device_);
    std::swap(memory_, other.memory_);
    std::swap(byteCount_, other.byteCount_);
    std::swap(isInGraph_, other.isInGraph_);
    return *this;
}

void CudaWorkspace::release() noexcept {
    if (memory_ == nullptr) return;
    // The default stream belongs to the current device.
    int before = device_;
    cudaGetDevice(&before);
    if (before != device_) cudaSetDevice(device_);
    cudaFreeAsync(memory_, stream_);
    if (before != device_) cudaSetDevice(before);
    memory_ = nullptr;
    byteCount_ = 0;
}

void CudaWorkspace::synchronize() const {
    const DeviceScope scope(device_);
    check(cudaStreamSynchronize(stream_), "cudaStreamSynchronize");
}

std::byte* CudaWorkspace::reserve(std::size_t bytes) {
    if (bytes == 0) return memory_;
    const DeviceScope scope(device_);
    cudaStreamCaptureStatus status = cudaStreamCaptureStatusNone;
    check(cudaStreamIsCapturing(stream_, &status), "cudaStreamIsCapturing");
    isInGraph_ = isInGraph_ || status != cudaStreamCaptureStatusNone;
    if (bytes <= byteCount_) return memory_;
    if (isInGraph_)
        throw Error(concat(
            "the workspace is used in a CUDA graph and holds ", byteCount_, " bytes; ", bytes,
            " are needed: CudaEvaluator::workspace() makes one that is large enough"));
    release();
    void* memory = nullptr;
    check(cudaMallocAsync(&memory, bytes, stream_), concat("cudaMallocAsync of ", bytes, " bytes"));
    memory_ = static_cast<std::byte*>(memory);
    byteCount_ = bytes;
    return memory_;
}

template <class Real>
struct CudaEvaluator<Real>::Data {
    int device = currentDevice();
    DeviceArrays tableMemory = {}, adjointMemory = {};
    device::TableView<Real> table = {};
    Index parametricRowCount = 0;
    std::vector<device::SumStep<Real>> steps = {};
    std::optional<device::AdjointView<Real>> adjoint = {};

    Data(const stencils::StencilTable<Real>& source, const CudaTableOptions& options) {
        const auto inMemory = [](DeviceArrays& memory) {
            return [&memory](const auto& values) { return memory.add(std::span(values)); };
        };
        if (options.hasParameters && !options.isGrouped)
            throw Error(
                "rows are stored as parameters only in groups: CudaTableOptions::hasParameters "
                "needs isGrouped");
        const device::TableArrays<Real> arrays(source, options.isGrouped, options.hasParameters);
        parametricRowCount = arrays.parametricRowCount;
        table = device::viewOf(arrays, inMemory(tableMemory));
        if (options.hasAdjoint)
            adjoint = device::viewOf(device::AdjointArrays<Real>(source, arrays), steps,
                                     inMemory(adjointMemory));
        check(device::loadKernels<Real>(), "cudaFuncGetAttributes");
    }

    /// Makes the device of this table current.
    /// \throws Error unless the workspace is of that device
    DeviceScope scopeFor(const CudaWorkspace& workspace) const {
        if (workspace.device() != device)
            throw Error(concat("the workspace is of CUDA device ", workspace.device(),
                               ", the table of device ", device));
        return DeviceScope(device);
    }
};

template <class Real>
CudaEvaluator<Real>::CudaEvaluator(const stencils::StencilTable<Real>& table,
                                   const CudaTableOptions& options)
    : data_(std::make_shared<const Data>(table, options)) {}

template <class Real>
Index CudaEvaluator<Real>::rowCount() const {
    return data_->table.rowCount;
}

template <class Real>
Index CudaEvaluator<Real>::columnCount() const {
    return data_->table.columnCount;
}

template <class Real>
int CudaEvaluator<Real>::device() const {
    return data_->device;
}

template <class Real>
Index CudaEvaluator<Real>::parametricRowCount() const {
    return data_->parametricRowCount;
}

template <class Real>
std::size_t CudaEvaluator<Real>::byteCount() const {
    return data_->tableMemory.byteCount() + data_->adjointMemory.byteCount();
}

template <class Real>
std::size_t CudaEvaluator<Real>::tableByteCount() const {
    return data_->tableMemory.byteCount();
}

template <class Real>
CudaWorkspace CudaEvaluator<Real>::workspace(Offset length, CudaStream stream) const {
    checkLength(length);
    const DeviceScope scope(data_->device);
    CudaWorkspace workspace(stream);
    if (data_->adjoint)
        workspace.reserve(deviceScratchBytes<Real>(data_->adjoint->slotCount * length));
    return workspace;
}

template <class Real>
void CudaEvaluator<Real>::evaluate(CudaSource<Real> source, const BufferDescriptor& sourceLayout,
                                   CudaDestination<Real> destination,
                                   const BufferDescriptor& destinationLayout, RowRange rows,
                                   CudaWorkspace& workspace, const CudaAddend<Real>& addend) const {
    checkEvaluation(rowCount(), columnCount(), source.size, sourceLayout, destination.size,
                    destinationLayout, rows);
    checkAddend(addend.values.size, addend.layout, destinationLayout, rows);
    if (rows.first == rows.last) return;
    const DeviceScope scope = data_->scopeFor(workspace);
    runOnDevice(columnCount(), source, sourceLayout, destination, destinationLayout, rows, 0,
                workspace, [&](device::Evaluation<Real> evaluation, Real*, cudaStream_t stream) {
                    if (addend.layout.length > 0) {
                        evaluation.addend = addend.values.data + addend.layout.offset;
                        evaluation.addendStride = addend.layout.stride;
                        evaluation.addendLength = addend.layout.length;
                    }
                    return device::startTable(data_->table, evaluation, stream);
                });
}

template <class Real>
void CudaEvaluator<Real>::evaluateAdjoint(CudaSource<Real> source,
                                          const BufferDescriptor& sourceLayout,
                                          CudaDestination<Real> destination,
                                          const BufferDescriptor& destinationLayout,
                                          RowRange columns, CudaWorkspace& workspace) const {
    if (!data_->adjoint)
        throw Error(
            "the table was copied to the device without its adjoint: "
            "CudaTableOptions::hasAdjoint");
    checkEvaluation(columnCount(), rowCount(), source.size, sourceLayout, destination.size,
                    destinationLayout, columns);
    if (columns.first == columns.last) return;
    const DeviceScope scope = data_->scopeFor(workspace);
    runOnDevice(rowCount(), source, sourceLayout, destination, destinationLayout, columns,
                data_->adjoint->slotCount * sourceLayout.length, workspace,
                [&](const auto& evaluation, Real* slots, cudaStream_t stream) {
                    return device::startAdjoint(data_->table, *data_->adjoint, evaluation, slots,
                                                stream);
                });
}

template class CudaBuffer<float>;
template class CudaBuffer<double>;
template class CudaEvaluator<float>;
template class CudaEvaluator<double>;

}  // namespace espalier::osd
