// SPDX-License-Identifier: Apache-2.0
//
// Measures tables on a GPU, for docs/gpu.md: prints a table, and fails if a result is wrong.
//
//     cuda_bench [MILLIONS]...    regular models with MILLIONS of points; the default is 1 and 30

#include <cuda_runtime_api.h>
#include <cusparse.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/cuda/cuda_evaluator.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cuda_peers.h"
#include "workloads.h"

namespace espalier {
namespace {

using osd::BufferDescriptor;
using stencils::StencilTable;

void check(cudaError_t error) {
    if (error != cudaSuccess) throw std::runtime_error(cudaGetErrorString(error));
}

void check(cusparseStatus_t status) {
    if (status != CUSPARSE_STATUS_SUCCESS) throw std::runtime_error(cusparseGetErrorString(status));
}

/// Times work on the default stream with a cold cache: the median of many runs, each preceded by
/// reading a larger array. (Writing that array would leave a cache full of data to be written back,
/// at the cost of the measured run.)
class Timer {
public:
    Timer() : other_(kOtherCount), sum_(1) {
        check(cudaMemset(other_.data(), 0, kOtherCount * sizeof(float)));
        check(cudaEventCreate(&start_));
        check(cudaEventCreate(&stop_));
    }
    ~Timer() {
        cudaEventDestroy(start_);
        cudaEventDestroy(stop_);
    }
    Timer(const Timer&) = delete;
    Timer& operator=(const Timer&) = delete;

    double milliseconds(const std::function<void()>& work) {
        constexpr int kRuns = 21;
        std::vector<float> times;
        for (int run = -3; run < kRuns; ++run) {
            check(bench::readAll(other_.data(), kOtherCount, sum_.data(), nullptr));
            check(cudaEventRecord(start_, nullptr));
            work();
            check(cudaEventRecord(stop_, nullptr));
            check(cudaEventSynchronize(stop_));
            float time = 0;
            check(cudaEventElapsedTime(&time, start_, stop_));
            if (run >= 0) times.push_back(time);
        }
        std::nth_element(times.begin(), times.begin() + kRuns / 2, times.end());
        return static_cast<double>(times[kRuns / 2]);
    }

private:
    static constexpr std::size_t kOtherCount = std::size_t{1} << 27;

    osd::CudaBuffer<float> other_, sum_;
    cudaEvent_t start_ = nullptr, stop_ = nullptr;
};

/// Bandwidth of a copy in bytes per millisecond, reads plus writes.
double copyBandwidth(Timer& timer) {
    constexpr std::size_t kBytes = std::size_t{1} << 32;
    osd::CudaBuffer<float> from(kBytes / sizeof(float)), to(from.size());
    check(cudaMemset(from.data(), 1, kBytes));
    return 2.0 * kBytes / timer.milliseconds([&] {
        check(cudaMemcpyAsync(to.data(), from.data(), kBytes, cudaMemcpyDeviceToDevice, nullptr));
    });
}

/// Sets every byte, so that values that nobody writes are NaN.
template <class Real>
void poison(osd::CudaBuffer<Real>& buffer) {
    check(cudaMemset(buffer.data(), 0xFF, buffer.size() * sizeof(Real)));
}

/// A table on the device in the form that peers take.
template <class Real>
class PeerTable {
public:
    explicit PeerTable(const StencilTable<Real>& table)
        : rowCount_(table.rowCount()),
          columnCount_(table.columnCount()),
          entryCount_(table.entryCount()),
          offsets_(copied(table.offsets())),
          columns_(copied(table.columns())),
          weights_(copied(table.weights())) {
        // cuSPARSE requires offsets and columns of the same size: 32 bits, which is less to read.
        if (entryCount_ > std::numeric_limits<std::int32_t>::max())
            throw std::runtime_error("too many entries for cuSPARSE's 32-bit offsets");
        const std::vector<std::int32_t> shortOffsets(table.offsets().begin(),
                                                     table.offsets().end());
        shortOffsets_ = static_cast<std::int32_t*>(copied(std::span(shortOffsets)));
        check(cusparseCreate(&handle_));
        check(cusparseCreateCsr(&matrix_, rowCount_, columnCount_, entryCount_, shortOffsets_,
                                columns_, weights_, CUSPARSE_INDEX_32I, CUSPARSE_INDEX_32I,
                                CUSPARSE_INDEX_BASE_ZERO, kType));
    }
    ~PeerTable() {
        cusparseDestroySpMat(matrix_);
        cusparseDestroy(handle_);
        for (void* const array : arrays_) cudaFree(array);
    }
    PeerTable(const PeerTable&) = delete;
    PeerTable& operator=(const PeerTable&) = delete;

    /// Evaluates with one thread per row.
    void evaluateByRows(const Real* source, Real* destination, int components) const {
        const bench::DeviceTable<Real> table = {static_cast<const std::int64_t*>(offsets_),
                                                static_cast<const std::int32_t*>(columns_),
                                                static_cast<const Real*>(weights_), rowCount_};
        check(bench::evaluateByRows(table, source, destination, components, nullptr));
    }

    /// Times cuSPARSE's product with a dense matrix whose rows are entries: the fastest of its
    /// algorithms, each prepared before it is timed, with its result checked. An algorithm that
    /// does not support this product, or needs more memory than is left, is skipped.
    double milliseconds(Timer& timer, bool isTransposed, const Real* source,
                        osd::CudaBuffer<Real>& result, int components,
                        const std::function<void()>& checkResult) {
        const auto operation =
            isTransposed ? CUSPARSE_OPERATION_TRANSPOSE : CUSPARSE_OPERATION_NON_TRANSPOSE;
        const Index rows = isTransposed ? columnCount_ : rowCount_;
        const Index columns = isTransposed ? rowCount_ : columnCount_;
        cusparseDnMatDescr_t from = nullptr, to = nullptr;
        check(cusparseCreateDnMat(&from, columns, components, components, const_cast<Real*>(source),
                                  kType, CUSPARSE_ORDER_ROW));
        check(cusparseCreateDnMat(&to, rows, components, components, result.data(), kType,
                                  CUSPARSE_ORDER_ROW));
        double best = std::numeric_limits<double>::infinity();
        for (const auto algorithm : {CUSPARSE_SPMM_ALG_DEFAULT, CUSPARSE_SPMM_CSR_ALG1,
                                     CUSPARSE_SPMM_CSR_ALG2, CUSPARSE_SPMM_CSR_ALG3}) {
            const Real one = 1, zero = 0;
            const auto call = [&](auto function, auto extra) {
                return function(handle_, operation, CUSPARSE_OPERATION_NON_TRANSPOSE, &one, matrix_,
                                from, &zero, to, kType, algorithm, extra);
            };
            std::size_t bytes = 0;
            if (call(cusparseSpMM_bufferSize, &bytes) != CUSPARSE_STATUS_SUCCESS) continue;
            void* buffer = nullptr;
            if (cudaMalloc(&buffer, std::max<std::size_t>(bytes, 1)) != cudaSuccess) {
                cudaGetLastError();
                continue;
            }
            poison(result);
            if (call(cusparseSpMM_preprocess, buffer) == CUSPARSE_STATUS_SUCCESS &&
                call(cusparseSpMM, buffer) == CUSPARSE_STATUS_SUCCESS) {
                checkResult();
                best =
                    std::min(best, timer.milliseconds([&] { check(call(cusparseSpMM, buffer)); }));
            }
            check(cudaFree(buffer));
        }
        check(cusparseDestroyDnMat(from));
        check(cusparseDestroyDnMat(to));
        return best;
    }

private:
    static constexpr auto kType = sizeof(Real) == 4 ? CUDA_R_32F : CUDA_R_64F;

    template <class T>
    void* copied(std::span<const T> values) {
        void* array = nullptr;
        check(cudaMalloc(&array, std::max<std::size_t>(values.size_bytes(), 1)));
        arrays_.push_back(array);
        check(cudaMemcpy(array, values.data(), values.size_bytes(), cudaMemcpyHostToDevice));
        return array;
    }

    Index rowCount_, columnCount_;
    Offset entryCount_;
    std::vector<void*> arrays_;
    void *offsets_, *columns_, *weights_;
    void* shortOffsets_ = nullptr;
    cusparseHandle_t handle_ = nullptr;
    cusparseSpMatDescr_t matrix_ = nullptr;
};

template <class Real>
std::vector<Real> valuesOf(const osd::CudaBuffer<Real>& buffer) {
    std::vector<Real> values(buffer.size());
    buffer.download(values);
    check(cudaDeviceSynchronize());
    return values;
}

void refuse(const char* who, double error) {
    throw std::runtime_error(std::string("the result of ") + who + " is off by " +
                             std::to_string(error));
}

/// Compares some rows with sums in the order of the table. Values are at most 1, rows have up to 64
/// entries.
template <class Real>
void checkForward(const StencilTable<Real>& table, const std::vector<Real>& pose, int components,
                  const osd::CudaBuffer<Real>& result, const char* who) {
    const std::vector<Real> values = valuesOf(result);
    for (Index row = 0; row < table.rowCount(); row += 997)
        for (int c = 0; c < components; ++c) {
            double sum = 0;
            for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                sum += static_cast<double>(table.weights(row)[k]) *
                       static_cast<double>(pose[table.columns(row)[k] * Offset{components} + c]);
            const double got = static_cast<double>(values[row * Offset{components} + c]);
            if (!(std::abs(got - sum) <= 64 * std::numeric_limits<Real>::epsilon()))
                refuse(who, std::abs(got - sum));
        }
}

/// Compares with sums that were computed otherwise. A sum has up to `rowCount` values of at most 1,
/// and the rounding of the sum grows with the root of their number.
template <class Real>
void checkAdjoint(const std::vector<Real>& expected, Index rowCount,
                  const osd::CudaBuffer<Real>& result, const char* who) {
    const std::vector<Real> values = valuesOf(result);
    const double bound =
        16 * std::numeric_limits<Real>::epsilon() * std::sqrt(static_cast<double>(rowCount));
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double error =
            std::abs(static_cast<double>(values[i]) - static_cast<double>(expected[i]));
        if (!(error <= bound * std::max(1.0, std::abs(static_cast<double>(expected[i])))))
            refuse(who, error);
    }
}

struct Row {
    double bytes;         ///< traffic of our form
    double grouped, csr;  ///< milliseconds
    double cuSparse;
    std::optional<double> byRows;
    std::optional<double> parametric;  ///< rows without a table
    double parametricBytes;            ///< their traffic
};

void printHead() {
    std::printf(
        "| table | direction | components | reads and writes | ours | of the copy's "
        "bandwidth | ours, compressed rows | cuSPARSE | ratio | a thread a row | ratio | "
        "parameters | of ours | of the copy's bandwidth |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
}

void print(const std::string& table, const char* direction, int components, const Row& row,
           double bandwidth) {
    std::printf("| %s | %s | %d | %.3g GB | %.3g ms | %.2f | %.3g ms | %.3g ms | %.1f × |",
                table.c_str(), direction, components, row.bytes / 1e9, row.grouped,
                row.bytes / row.grouped / bandwidth, row.csr, row.cuSparse,
                row.cuSparse / row.grouped);
    if (row.byRows)
        std::printf(" %.3g ms | %.1f × |", *row.byRows, *row.byRows / row.grouped);
    else
        std::printf("  |  |");
    if (row.parametric)
        std::printf(" %.3g ms | %.2f | %.2f |\n", *row.parametric, *row.parametric / row.grouped,
                    row.parametricBytes / *row.parametric / bandwidth);
    else
        std::printf("  |  |  |\n");
    std::fflush(stdout);
}

/// Benchmarks a table on the device, in both of our forms and in the peers'.
template <class Real>
class TableBench {
public:
    TableBench(Timer& timer, const StencilTable<Real>& table, bool hasAdjoint)
        : timer_(timer),
          table_(table),
          grouped_(table, {.hasAdjoint = hasAdjoint}),
          parametric_(table, {.hasParameters = true, .hasAdjoint = hasAdjoint}),
          csr_(table, {.isGrouped = false, .hasAdjoint = hasAdjoint}),
          peer_(table) {}

    Row forward(int components) {
        const auto layout = BufferDescriptor::packed(components);
        const std::vector<Real> pose = bench::randomValues(table_, components);
        const osd::CudaBuffer<Real> source{std::span<const Real>(pose)};
        osd::CudaBuffer<Real> result(table_.rowCount() * layout.length);
        osd::CudaWorkspace workspace;
        const auto timeOf = [&](const std::function<void()>& evaluate, const char* who) {
            poison(result);
            evaluate();
            checkForward(table_, pose, components, result, who);
            return timer_.milliseconds(evaluate);
        };
        const auto ours = [&](const osd::CudaEvaluator<Real>& evaluator) {
            return [&] {
                evaluator.evaluate(source, layout, result, layout, {0, table_.rowCount()},
                                   workspace);
            };
        };
        Row row = {};
        row.bytes = bytesOf(grouped_, pose.size() + result.size());
        row.grouped = timeOf(ours(grouped_), "ours");
        if (parametric_.parametricRowCount() > 0) {
            row.parametric = timeOf(ours(parametric_), "ours from parameters");
            row.parametricBytes = bytesOf(parametric_, pose.size() + result.size());
        }
        row.csr = timeOf(ours(csr_), "ours in compressed rows");
        row.byRows = timeOf([&] { peer_.evaluateByRows(source.data(), result.data(), components); },
                            "a thread a row");
        row.cuSparse = peer_.milliseconds(timer_, false, source.data(), result, components, [&] {
            checkForward(table_, pose, components, result, "cuSPARSE");
        });
        return row;
    }

    Row adjoint(int components) {
        const auto layout = BufferDescriptor::packed(components);
        const osd::RowRange columns{0, table_.columnCount()};
        std::vector<Real> gradients(table_.rowCount() * layout.length);
        for (std::size_t i = 0; i < gradients.size(); ++i)
            gradients[i] = static_cast<Real>(std::sin(static_cast<double>(i)));
        std::vector<Real> expected(table_.columnCount() * layout.length);
        osd::CompiledAdjoint<Real>(table_).evaluate(gradients, layout, expected, layout, columns);
        const osd::CudaBuffer<Real> source{std::span<const Real>(gradients)};
        osd::CudaBuffer<Real> result(expected.size());
        const auto timeOf = [&](const osd::CudaEvaluator<Real>& evaluator, const char* who) {
            osd::CudaWorkspace workspace = evaluator.workspace(components);
            const auto evaluate = [&] {
                evaluator.evaluateAdjoint(source, layout, result, layout, columns, workspace);
            };
            poison(result);
            evaluate();
            checkAdjoint(expected, table_.rowCount(), result, who);
            return timer_.milliseconds(evaluate);
        };
        Row row = {};
        row.bytes = bytesOf(grouped_, gradients.size() + result.size());
        row.grouped = timeOf(grouped_, "our adjoint");
        if (parametric_.parametricRowCount() > 0) {
            row.parametric = timeOf(parametric_, "our adjoint from parameters");
            row.parametricBytes = bytesOf(parametric_, gradients.size() + result.size());
        }
        row.csr = timeOf(csr_, "our adjoint in compressed rows");
        // The transposed product of the table, or the product of its transpose: the faster one
        // counts.
        PeerTable<Real> transpose(stencils::transposeTable(table_));
        for (const bool isTransposed : {true, false}) {
            PeerTable<Real>& peer = isTransposed ? peer_ : transpose;
            const double time = peer.milliseconds(
                timer_, isTransposed, source.data(), result, components,
                [&] { checkAdjoint(expected, table_.rowCount(), result, "cuSPARSE's adjoint"); });
            row.cuSparse = isTransposed ? time : std::min(row.cuSparse, time);
        }
        return row;
    }

private:
    static double bytesOf(const osd::CudaEvaluator<Real>& evaluator, std::size_t values) {
        return static_cast<double>(evaluator.tableByteCount() + values * sizeof(Real));
    }

    Timer& timer_;
    const StencilTable<Real>& table_;
    osd::CudaEvaluator<Real> grouped_, parametric_, csr_;
    PeerTable<Real> peer_;
};

template <class Real>
void benchTable(Timer& timer, const std::string& name, const StencilTable<Real>& table,
                double bandwidth) {
    // The largest tables have no adjoint here: during transposition the host would hold them four
    // times.
    const bool hasAdjoint = table.entryCount() < Offset{1} << 28;
    TableBench<Real> bench(timer, table, hasAdjoint);
    const std::string full = name + (sizeof(Real) == 4 ? ", float" : ", double");
    for (const int components : {3, 12})
        print(full, "forward", components, bench.forward(components), bandwidth);
    if (hasAdjoint) print(full, "adjoint", 3, bench.adjoint(3), bandwidth);
}

void run(const std::vector<int>& millions) {
    cudaDeviceProp properties;
    check(cudaGetDeviceProperties(&properties, 0));
    Timer timer;
    const double bandwidth = copyBandwidth(timer);
    std::printf("Device: %s. A copy on it reads and writes %.2f TB/s.\n\n", properties.name,
                bandwidth / 1e9);
    printHead();
    for (const int count : millions) {
        const std::string name = "regular, " + std::to_string(count) + " M points";
        benchTable(timer, name, bench::regularTable<float>(count * bench::kMillion), bandwidth);
        benchTable(timer, name, bench::regularTable<double>(count * bench::kMillion), bandwidth);
    }
    const bench::Workload irregular = bench::irregularModel();
    benchTable(timer, "irregular, 1 M points", irregular.inFloat.table, bandwidth);
    benchTable(timer, "irregular, 1 M points", irregular.inDouble.table, bandwidth);
}

}  // namespace
}  // namespace espalier

int main(int argc, char** argv) {
    try {
        std::vector<int> millions;
        for (int i = 1; i < argc; ++i) {
            millions.push_back(std::atoi(argv[i]));
            if (millions.back() < 1 || millions.back() > 33) {  // ×64: cuSPARSE's 32-bit offsets
                std::fprintf(stderr, "usage: cuda_bench [MILLIONS]..., from 1 to 33\n");
                return 2;
            }
        }
        espalier::run(millions.empty() ? std::vector{1, 30} : millions);
        return EXIT_SUCCESS;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "cuda_bench: %s\n", error.what());
        return EXIT_FAILURE;
    }
}
