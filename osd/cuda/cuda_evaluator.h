// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <espalier/base/api.h>
#include <espalier/base/error.h>
#include <espalier/base/point.h>
#include <espalier/osd/evaluation.h>

#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

struct CUstream_st;

// Evaluates tables on NVIDIA's GPUs, as OpenSubdiv's Osd::CudaEvaluator. This is the only header of
// the component `cuda`; it includes no header of CUDA.
namespace espalier::osd {

/// CUDA's cudaStream_t. Null is the default stream.
using CudaStream = CUstream_st*;

/// Reports a call to CUDA that failed. what() names the call and gives the reason. The reason may
/// be work that was put on a stream earlier, because CUDA reports such failures at any later call.
class ESPALIER_API CudaError : public Error {
public:
    CudaError(int code, const std::string& what) : Error(what), code_(code) {}

    int code() const { return code_; }  ///< CUDA's cudaError_t

private:
    int code_;
};

/// Returns the number of usable devices: 0 if there is none, or no driver.
/// \throws CudaError for any other failure
ESPALIER_API int cudaDeviceCount();

/// Refers to numbers in memory of a device, which the caller or a CudaBuffer owns. Real may be
/// const.
template <class Real>
struct DeviceSpan {
    Real* data = nullptr;
    std::size_t size = 0;

    DeviceSpan() = default;
    DeviceSpan(Real* first, std::size_t count) : data(first), size(count) {}
    template <class Other>
    requires std::same_as<const Other, Real> DeviceSpan(DeviceSpan<Other> values)
        : data(values.data), size(values.size) {}
};

/// Owns numbers in memory of a device, as OpenSubdiv's Osd::CudaVertexBuffer. Deformed points can
/// stay there, to be drawn or to be read by other kernels. The device is the one that is current
/// when the buffer is made.
template <class Real>
class ESPALIER_API CudaBuffer {
public:
    /// Allocates the buffer. The numbers are not initialized.
    /// \throws CudaError
    explicit CudaBuffer(std::size_t size);

    /// Allocates the buffer and copies `values` to it. Any stream may use it when this returns.
    /// \throws CudaError
    explicit CudaBuffer(std::span<const Real> values);

    /// Waits until the device is idle, as cudaFree() does.
    ~CudaBuffer();
    CudaBuffer(CudaBuffer&&) noexcept;
    CudaBuffer& operator=(CudaBuffer&&) noexcept;

    Real* data() { return data_; }
    const Real* data() const { return data_; }
    std::size_t size() const { return size_; }

    operator DeviceSpan<Real>() { return {data_, size_}; }
    operator DeviceSpan<const Real>() const { return {data_, size_}; }

    /// Copies from or to the host, in the order of the stream, as cudaMemcpyAsync() does. If the
    /// memory of the host is not page-locked, upload() has read it when it returns, and download()
    /// may wait for the stream. Synchronize the stream before you read what was downloaded.
    ///
    /// \throws Error if there are more numbers than the buffer holds; CudaError
    void upload(std::span<const Real> values, CudaStream stream = nullptr);
    void download(std::span<Real> values, CudaStream stream = nullptr) const;

private:
    void checkSize(std::size_t size) const;

    int device_ = 0;
    Real* data_ = nullptr;
    std::size_t size_ = 0;
};

/// The source of an evaluation: numbers on the host or on the device.
template <class Real>
struct CudaSource {
    const Real* data;
    std::size_t size;
    bool isOnHost;

    template <std::convertible_to<std::span<const Real>> Host>
    CudaSource(const Host& values)
        : CudaSource(std::span<const Real>(values).data(), std::span<const Real>(values).size(),
                     true) {}
    CudaSource(DeviceSpan<const Real> values) : CudaSource(values.data, values.size, false) {}
    CudaSource(DeviceSpan<Real> values) : CudaSource(values.data, values.size, false) {}
    CudaSource(const CudaBuffer<Real>& values) : CudaSource(values.data(), values.size(), false) {}

private:
    CudaSource(const Real* first, std::size_t count, bool onHost)
        : data(first), size(count), isOnHost(onHost) {}
};

/// The destination of an evaluation: numbers on the host or on the device.
template <class Real>
struct CudaDestination {
    Real* data;
    std::size_t size;
    bool isOnHost;

    template <class Host>
    requires std::convertible_to<Host&, std::span<Real>> CudaDestination(Host& values)
        : CudaDestination(std::span<Real>(values).data(), std::span<Real>(values).size(), true) {}
    CudaDestination(std::span<Real> values) : CudaDestination(values.data(), values.size(), true) {}
    CudaDestination(DeviceSpan<Real> values) : CudaDestination(values.data, values.size, false) {}
    CudaDestination(CudaBuffer<Real>& values)
        : CudaDestination(values.data(), values.size(), false) {}

private:
    CudaDestination(Real* first, std::size_t count, bool onHost)
        : data(first), size(count), isOnHost(onHost) {}
};

/// Values on the device that an evaluation adds to its results, in one addition each, last: see
/// Addend. With the displacements of the lattice as the source and the points at rest as the
/// addend, the results are x + D · (p' − p).
template <class Real>
struct CudaAddend {
    DeviceSpan<const Real> values = {};
    BufferDescriptor layout = {};  ///< has the rules of Addend::layout; a length of 0 adds nothing

    /// Returns `values` as packed entries of `length` components.
    static CudaAddend packed(DeviceSpan<const Real> values, Offset length) {
        return {values, BufferDescriptor::packed(length)};
    }
};

/// A stream, on which evaluations are put, and the temporary memory of the device that they need.
///
/// The memory grows when an evaluation needs more, and is kept for the next one. It grows in the
/// order of the stream and without waiting for it (cudaMallocAsync()). It cannot grow any more once
/// a CUDA graph uses it, because the graph holds its address.
///
/// The stream belongs to the device that is current when the workspace is made. Only one thread at
/// a time may use a workspace. Destroy it before its stream, after all graphs that use it, and not
/// while its stream is being captured.
class ESPALIER_API CudaWorkspace {
public:
    /// Allocates nothing yet.
    /// \param stream of the current device; null is the default stream
    /// \throws CudaError
    explicit CudaWorkspace(CudaStream stream = nullptr);
    ~CudaWorkspace();
    CudaWorkspace(CudaWorkspace&&) noexcept;
    CudaWorkspace& operator=(CudaWorkspace&&) noexcept;

    CudaStream stream() const { return stream_; }
    int device() const { return device_; }
    std::size_t byteCount() const { return byteCount_; }

    /// Waits until all work on the stream is done.
    /// \throws CudaError also if any of that work has failed
    void synchronize() const;

    /// Makes sure that the workspace holds at least `bytes` bytes. If it has to grow, its contents
    /// are lost.
    /// \throws Error if it has to grow, but a CUDA graph uses it or its stream is being captured;
    ///         CudaError
    std::byte* reserve(std::size_t bytes);

private:
    void release() noexcept;

    CudaStream stream_ = nullptr;
    int device_ = 0;
    std::byte* memory_ = nullptr;
    std::size_t byteCount_ = 0;
    bool isInGraph_ = false;
};

struct CudaTableOptions {
    /// If true, rows that share their columns are stored as groups, and outer products as factors,
    /// as in CompiledTable. If false, the device holds the table as compressed sparse rows.
    bool isGrouped = true;

    /// If true, points in regular cells, bound to the limit or to a level up to 10, are stored
    /// without weights, if a cell has enough of them to fill a panel: as the cell and three
    /// parameters, from which kernels compute the point. A row
    /// takes 16 bytes instead of 52 (28 instead of 100 in double). Its error is then relative to
    /// the largest |x|: see evaluate(). Needs isGrouped.
    bool hasParameters = false;

    /// If true, evaluateAdjoint() may be called. This takes a few bytes more for each group of rows
    /// and for each of its columns, and stores all rows that are in no group a second time.
    bool hasAdjoint = false;
};

/// Holds a stencil table on a device, and multiplies it by values there.
///
///     const osd::CudaEvaluator<float> table(binding.table);   // once
///     osd::CudaBuffer<float> points(3 * count);
///     osd::CudaWorkspace workspace(stream);
///     …
///     table.evaluate(pose, xyz, points, xyz, {0, count}, workspace);  // for each pose
///
/// The device is the one that is current when the table is made. Immutable, so threads may share
/// it, each with its own workspace. Copies share the table; destroying the last one waits until the
/// device is idle.
///
/// Calls put work on the stream of the workspace. They may come from any thread, whatever its
/// current device. If source and destination are on the device, calls wait for nothing.
template <class Real>
class ESPALIER_API CudaEvaluator {
public:
    /// Copies the table to the device. When this returns, the table is ready for any stream, and
    /// the kernels are loaded.
    ///
    /// \throws CudaError if there is no device, or not enough memory on it; Error if the adjoint
    ///         needs too many intermediate sums, or for hasParameters without isGrouped
    /// \cost O(entries + rows log rows) on the host. Temporary memory of the host, as much as the
    ///       table takes on the device, and with parameters up to six times as much; if not
    ///       grouped, none, or with an adjoint as much as the table takes
    explicit CudaEvaluator(const stencils::StencilTable<Real>& table,
                           const CudaTableOptions& options = {});

    Index rowCount() const;
    Index columnCount() const;
    int device() const;

    /// Number of rows that are stored as parameters.
    Index parametricRowCount() const;

    /// Memory of the device in bytes: in total, and without the part that only the adjoint needs.
    std::size_t byteCount() const;
    std::size_t tableByteCount() const;

    /// Returns a workspace that is large enough for evaluations of entries of `length` components
    /// with source and destination on the device; also for the adjoint, if there is one.
    /// \param stream must belong to the device of this table
    /// \throws Error as checkLength() does; CudaError
    CudaWorkspace workspace(Offset length, CudaStream stream = nullptr) const;

    /// Evaluates `rows`, with the contract of checkEvaluation(). Source and destination may be on
    /// the host or on the device.
    ///
    /// The error is at most 1 ulp of Σ |w · x| for each entry, plus 4 ulp: terms are not added in
    /// the order of the columns, and products of factors differ slightly from the weights. Results
    /// do not depend on the device or on the range, bit for bit. A source value that is not finite
    /// may also reach rows of its group whose weight for it is 0.
    ///
    /// The error of rows that are stored as parameters is at most 64 ulp of the largest |x| of
    /// their columns: 8 for the weights, which are compared with the table when it is copied, and
    /// 56 for the rounding of coefficients and sums (docs/gpu.md). In the tests it is below 4.
    ///
    /// A source on the host is first copied to the device, and results for the host are copied
    /// there after the evaluation, both by cudaMemcpyAsync(). If that memory is page-locked, do not
    /// change the source, or read the destination, before the copies are done. If it is not
    /// page-locked, the source has been read when this returns, and this call may wait for the
    /// results. In both cases, synchronize before you read the destination. If its entries are not
    /// contiguous, each is copied separately, which is slow.
    ///
    /// If source and destination are on the device, a CUDA graph may capture this call. Table,
    /// buffers and workspace must live as long as the graph, and nothing else may use the workspace
    /// while the graph runs.
    ///
    /// \throws Error as checkEvaluation() and checkAddend() say; if the workspace is of another
    ///         device; as CudaWorkspace::reserve() says; CudaError if CUDA rejects a copy or a
    ///         kernel
    /// \cost O(entries of the range × components), and one check for each group and for each row
    ///       that is in no group; memory of the workspace for what is copied
    void evaluate(CudaSource<Real> source, const BufferDescriptor& sourceLayout,
                  CudaDestination<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows, CudaWorkspace& workspace,
                  const CudaAddend<Real>& addend = {}) const;

    /// Evaluates rows of the transpose in the same way: gradients by the rows of the table become
    /// gradients by its columns. The error is at most 1 ulp for each entry of the column, plus 4
    /// ulp; in practice it grows by 1 ulp when the number of entries doubles. Rows that are stored
    /// as parameters add at most 8 ulp of their value. No two threads add to the same number.
    ///
    /// \param columns of the table, which are the rows of the transpose
    /// \throws Error also if the table was made without its adjoint
    /// \cost O(entries × components), whatever the range; memory of the workspace for one sum of
    ///       each column of each group of rows
    void evaluateAdjoint(CudaSource<Real> source, const BufferDescriptor& sourceLayout,
                         CudaDestination<Real> destination,
                         const BufferDescriptor& destinationLayout, RowRange columns,
                         CudaWorkspace& workspace) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

}  // namespace espalier::osd
