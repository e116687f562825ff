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

// Tables on NVIDIA's GPUs, as OpenSubdiv's Osd::CudaEvaluator. The only header of the component
// `cuda`; it includes nothing of CUDA's.
namespace espalier::osd {

/// CUDA's cudaStream_t. Null is the default stream.
using CudaStream = CUstream_st*;

/// A call of CUDA's that has failed. what() names it, and says why: also for work that was put on a
/// stream earlier, since CUDA tells of that at any later call.
class ESPALIER_API CudaError : public Error {
public:
    CudaError(int code, const std::string& what) : Error(what), code_(code) {}

    int code() const { return code_; }  ///< CUDA's cudaError_t

private:
    int code_;
};

/// The devices that can be used: 0 where there is none, or no driver.
/// \throws CudaError for any other reason
ESPALIER_API int cudaDeviceCount();

/// Numbers in memory of a device: the caller's, or a CudaBuffer's. Real may be const.
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

/// Numbers in memory of the device that is current when it is made, as OpenSubdiv's
/// Osd::CudaVertexBuffer: deformed points that stay there, to be drawn or read by other kernels.
template <class Real>
class ESPALIER_API CudaBuffer {
public:
    /// Not initialised.
    /// \throws CudaError
    explicit CudaBuffer(std::size_t size);

    /// A copy, which is there for any stream when this returns.
    /// \throws CudaError
    explicit CudaBuffer(std::span<const Real> values);

    /// Waits for what the device is doing, as cudaFree().
    ~CudaBuffer();
    CudaBuffer(CudaBuffer&&) noexcept;
    CudaBuffer& operator=(CudaBuffer&&) noexcept;

    Real* data() { return data_; }
    const Real* data() const { return data_; }
    std::size_t size() const { return size_; }

    operator DeviceSpan<Real>() { return {data_, size_}; }
    operator DeviceSpan<const Real>() const { return {data_, size_}; }

    /// Copies from or to the host, behind what is on the stream, as cudaMemcpyAsync(): of memory
    /// that is not page-locked it reads what it takes before it returns; where it writes, it may
    /// wait for the stream. Synchronize before what was downloaded is read.
    ///
    /// \throws Error if there are more numbers than the buffer has; CudaError
    void upload(std::span<const Real> values, CudaStream stream = nullptr);
    void download(std::span<Real> values, CudaStream stream = nullptr) const;

private:
    void checkSize(std::size_t size) const;

    int device_ = 0;
    Real* data_ = nullptr;
    std::size_t size_ = 0;
};

/// What an evaluation reads: numbers of the host, or of the device.
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

/// Where an evaluation writes.
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

/// A stream of the device that is current when it is made, for evaluations to be put on, and the
/// memory of the device that they take besides what they are given. It grows when an evaluation
/// needs more, in the order of the stream and without waiting for it (cudaMallocAsync()), and is
/// kept for the next one; but not once it has been used in a CUDA graph, which knows where it is.
///
/// For one stream; not for several threads at a time. It must go before its stream does, after the
/// graphs that it was used in, and not while its stream is captured.
class ESPALIER_API CudaWorkspace {
public:
    /// Takes no memory yet.
    /// \param stream null is the default stream of that device
    /// \throws CudaError
    explicit CudaWorkspace(CudaStream stream = nullptr);
    ~CudaWorkspace();
    CudaWorkspace(CudaWorkspace&&) noexcept;
    CudaWorkspace& operator=(CudaWorkspace&&) noexcept;

    CudaStream stream() const { return stream_; }
    int device() const { return device_; }
    std::size_t byteCount() const { return byteCount_; }

    /// Waits until all that is on the stream is done.
    /// \throws CudaError also for what has failed there
    void synchronize() const;

    /// Makes it hold so many bytes. What it held is lost if it has to grow.
    /// \throws Error if it has to grow and is used in a CUDA graph, or its stream is captured;
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
    /// Whether rows that share their columns are kept together, and outer products by their
    /// factors, as in CompiledTable. Else the table lies on the device as it is, in compressed
    /// rows.
    bool isGrouped = true;

    /// Whether evaluateAdjoint() may be called. That takes a few more bytes for each group of rows
    /// and each of its columns; and what rows have that are in no group, a second time.
    bool hasAdjoint = false;
};

/// A stencil table on the device that is current when it is made, and products with it.
///
///     const osd::CudaEvaluator<float> table(binding.table);   // once
///     osd::CudaBuffer<float> points(3 * count);
///     osd::CudaWorkspace workspace(stream);
///     …
///     table.evaluate(pose, xyz, points, xyz, {0, count}, workspace);  // for each pose
///
/// Immutable, and so safe to share between threads, each with a workspace of its own. Copies share
/// the table; the last one, when it goes, waits for what the device is doing. Calls put
/// work on the stream of the workspace, and may come from any thread, whatever its current device.
/// From device to device they wait for nothing.
template <class Real>
class ESPALIER_API CudaEvaluator {
public:
    /// Copies the table, and returns when it is there for any stream, and the kernels are loaded.
    ///
    /// \throws CudaError where there is no device, or not enough memory on it; Error if the adjoint
    ///         has too many sums on the way
    /// \cost O(entries + rows log rows) on the host, and there, for a moment, as much memory as it
    ///       takes on the device; ungrouped none, but for an adjoint that of the table
    explicit CudaEvaluator(const stencils::StencilTable<Real>& table,
                           const CudaTableOptions& options = {});

    Index rowCount() const;
    Index columnCount() const;
    int device() const;

    /// Memory of the device that it takes: in all, and without what the adjoint takes besides.
    std::size_t byteCount() const;
    std::size_t tableByteCount() const;

    /// One that is large enough for evaluations of so many components from the device to the
    /// device: of the adjoint, if there is one.
    /// \param stream of the device of this table
    /// \throws Error as checkLength() does; CudaError
    CudaWorkspace workspace(Offset length, CudaStream stream = nullptr) const;

    /// As checkEvaluation() says, of source and destination on the host or on the device.
    ///
    /// Results are off the sums by no more than an ulp of Σ |w · x| for each entry and 4 more,
    /// since they are made in another order than that of the columns, and weights of outer products
    /// are a little off. They do not depend on the device nor on the range, bit for bit. A source
    /// value that is not finite may reach rows beside its own, whose weight for it is 0.
    ///
    /// From the host, the source is copied to the device first; to the host, the rows of the range
    /// are copied there after it, by cudaMemcpyAsync(). Memory that is page-locked must stay as it
    /// is, or not be read, until these copies are done; of other memory the source is read before
    /// this returns, and it may wait for the destination. Synchronize before that is read. Where
    /// entries of the destination do not lie one behind the other, each is a copy of its own, which
    /// is slow.
    ///
    /// From device to device, this may be captured as a part of a CUDA graph. Table, buffers and
    /// workspace must be there as long as the graph is, and no one else may use the workspace while
    /// it runs.
    ///
    /// \throws Error as checkEvaluation() says, if the workspace is another device's, or as
    ///         CudaWorkspace::reserve() says; CudaError if CUDA refuses a copy or a kernel
    /// \cost O(entries of the range × components), and a look at each group of rows and each row in
    ///       none; memory of the workspace for what is copied
    void evaluate(CudaSource<Real> source, const BufferDescriptor& sourceLayout,
                  CudaDestination<Real> destination, const BufferDescriptor& destinationLayout,
                  RowRange rows, CudaWorkspace& workspace) const;

    /// The same of the transpose: gradients by the rows of the table become gradients by its
    /// columns. Results are off by no more than an ulp for each entry of the column, and 4; in
    /// practice for each doubling of their number. No two threads add to the same number.
    ///
    /// \param columns of the table, which are rows of the transpose
    /// \throws Error also if the table was made without adjoint
    /// \cost O(entries × components), whatever the range; memory of the workspace for a sum of each
    ///       column of each group of rows
    void evaluateAdjoint(CudaSource<Real> source, const BufferDescriptor& sourceLayout,
                         CudaDestination<Real> destination,
                         const BufferDescriptor& destinationLayout, RowRange columns,
                         CudaWorkspace& workspace) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

/// The kept points of a bound model on the device that is current when it is made: those that
/// evaluators of its table have made 0 (binding_evaluator.h).
template <class Real>
class ESPALIER_API CudaKeptPoints {
public:
    /// \param pointCount rows of the table
    /// \param kept, keptAt as Binding has them: which points, and where they stay
    /// \throws Error if these are not as many, or a point is not one of the model's; CudaError
    CudaKeptPoints(Index pointCount, std::span<const Index> kept, std::span<const Point3> keptAt);

    /// Puts them where they were, behind what is on the stream.
    ///
    /// \param destination on the device, where entry i is point i; of `layout`, whose length is 3
    /// \throws Error if the layout does not make sense, or not all points have room; CudaError
    void write(DeviceSpan<Real> destination, const BufferDescriptor& layout,
               CudaStream stream = nullptr) const;

private:
    struct Data;
    std::shared_ptr<const Data> data_;
};

}  // namespace espalier::osd
