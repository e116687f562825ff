// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/cuda/cuda_evaluator.h>

#include "bound_table.h"
#include "cuda_device.h"
#include "fake_cuda.h"
#include "host_device.h"
#include "support/test.h"

// Tests which calls to CUDA are made, and what happens if they fail, on a fake device that is the
// host.
namespace espalier::osd {
namespace {

using stencils::StencilTable;
namespace fake = fake_cuda;

const StencilTable<float>& someTable() {
    static const auto table = tableOfAllKinds<float>();
    return table;
}

constexpr BufferDescriptor kXyz{0, 3, 3};

std::vector<std::string> callsOf(const auto& work) {
    fake::takeCalls();
    work();
    std::vector<std::string> calls = fake::takeCalls();
    // These are not work for a device.
    std::erase_if(calls, [](const std::string& call) {
        return call == "cudaGetDevice" || call == "cudaStreamIsCapturing";
    });
    return calls;
}

// One kernel for each kind of rows in the table, and one for each step of sums. Nothing waits, and
// nothing is allocated.
TEST(CudaCalls, DeviceToDeviceLaunchesOnlyKernels) {
    const auto& table = someTable();
    const HostDevice<float> host(table, true);
    const auto& arrays = host.arrays();
    std::ptrdiff_t kinds = arrays.panels.empty() ? 0 : 1;
    for (const auto& products : arrays.products) kinds += products.empty() ? 0 : 1;
    ASSERT_GE(kinds, 2);
    ASSERT_GT(arrays.ungrouped.count(), 0);
    const CudaEvaluator<float> cuda(table, {.hasAdjoint = true});
    const Stream stream;
    CudaWorkspace workspace = cuda.workspace(3, stream);
    CudaBuffer<float> pose(std::size_t(table.columnCount()) * 3);
    CudaBuffer<float> points(std::size_t(table.rowCount()) * 3);
    const auto kernels = [](std::ptrdiff_t count) {
        return std::vector<std::string>(count, "cudaLaunchKernel");
    };
    EXPECT_EQ(callsOf([&] {
                  cuda.evaluate(pose, kXyz, points, kXyz, {0, table.rowCount()}, workspace);
              }),
              kernels(kinds + 1));
    const auto& adjoint = host.adjointArrays();
    ASSERT_FALSE(adjoint.products.empty() || adjoint.panels.empty());
    EXPECT_EQ(
        callsOf([&] {
            cuda.evaluateAdjoint(points, kXyz, pose, kXyz, {0, table.columnCount()}, workspace);
        }),
        kernels(3 + std::ssize(adjoint.steps)));
}

TEST(CudaCalls, HostToHostCopiesTwice) {
    const auto& table = someTable();
    const CudaEvaluator<float> cuda(table);
    CudaWorkspace workspace;
    const std::vector<float> pose(std::size_t(table.columnCount()) * 3, 1);
    std::vector<float> points(std::size_t(table.rowCount()) * 3);
    const auto evaluate = [&] {
        cuda.evaluate(pose, kXyz, points, kXyz, {0, table.rowCount()}, workspace);
    };
    EXPECT_EQ(callsOf(evaluate).front(), "cudaMallocAsync");
    const auto calls = callsOf(evaluate);
    EXPECT_EQ(calls.front(), "cudaMemcpyAsync");
    EXPECT_EQ(calls.back(), "cudaMemcpyAsync");
    EXPECT_EQ(std::count(calls.begin(), calls.end(), "cudaLaunchKernel"), std::ssize(calls) - 2);
}

// Work on a stream does not run before something waits for it.
TEST(CudaCalls, WaitForNothing) {
    const auto& table = someTable();
    const CudaEvaluator<float> cuda(table);
    const Stream stream;
    CudaWorkspace workspace(stream);
    const std::vector<float> pose(std::size_t(table.columnCount()) * 3, 1);
    CudaBuffer<float> points(std::size_t(table.rowCount()) * 3);
    const auto calls = callsOf([&] {
        cuda.evaluate(pose, kXyz, points, kXyz, {0, table.rowCount()}, workspace);
        CudaWorkspace grown(stream);
        grown.reserve(100);
        grown.reserve(10'000);
        grown.reserve(1'000);
    });
    for (const char* const waiting :
         {"cudaStreamSynchronize", "cudaMalloc", "cudaFree", "cudaMemcpy"})
        EXPECT_EQ(std::count(calls.begin(), calls.end(), waiting), 0) << waiting;
    EXPECT_EQ(std::count(calls.begin(), calls.end(), "cudaMallocAsync"), 3);
    EXPECT_EQ(std::count(calls.begin(), calls.end(), "cudaFreeAsync"), 2);
}

// Each call makes the device of its table current, whatever device the calling thread uses.
TEST(CudaCalls, RestoreTheCurrentDevice) {
    ASSERT_EQ(cudaSetDevice(1), cudaSuccess);
    const CudaEvaluator<float> cuda(StencilTable<float>(1, {0, 1}, {0}, {2}));
    EXPECT_EQ(cuda.device(), 1);
    CudaWorkspace workspace;
    ASSERT_EQ(cudaSetDevice(0), cudaSuccess);
    const std::vector<float> source = {21};
    std::vector<float> result(1);
    EXPECT_THAT(callsOf([&] {
                    cuda.evaluate(source, {0, 1, 1}, result, {0, 1, 1}, {0, 1}, workspace);
                }),
                ElementsAre("cudaSetDevice", "cudaMallocAsync", "cudaMemcpyAsync",
                            "cudaLaunchKernel", "cudaMemcpyAsync", "cudaSetDevice"));
    int current = -1;
    cudaGetDevice(&current);
    EXPECT_EQ(current, 0);
    EXPECT_THAT(result, ElementsAre(42));

    // The same holds for calls that wait or copy.
    ASSERT_EQ(cudaSetDevice(1), cudaSuccess);
    CudaBuffer<float> there(1);
    ASSERT_EQ(cudaSetDevice(0), cudaSuccess);
    cuda.evaluate(source, {0, 1, 1}, there, {0, 1, 1}, {0, 1}, workspace);
    there.upload(std::vector<float>{5});
    result = {0};
    cuda.evaluate(there, {0, 1, 1}, there, {0, 1, 1}, {0, 1}, workspace);
    there.download(result);
    workspace.synchronize();
    EXPECT_THAT(result, ElementsAre(10));

    const CudaEvaluator<float> other(StencilTable<float>(1, {0, 1}, {0}, {2}));
    EXPECT_REFUSED(Error, "of CUDA device 1, the table of device 0",
                   other.evaluate(source, {0, 1, 1}, result, {0, 1, 1}, {0, 1}, workspace));
}

// Every call to CUDA fails once. The failure is an exception that names the call, except where the
// call was to free memory; and nothing leaks.
TEST(CudaCalls, FailuresAreExceptions) {
    const auto& table = someTable();
    std::vector<std::string> failed;
    for (int number = 1;; ++number) {
        const std::size_t before = fake::allocationCount();
        std::string thrown;
        try {
            const Stream stream;
            const std::vector<float> pose(std::size_t(table.columnCount()) * 4, 1);
            std::vector<float> points(std::size_t(table.rowCount()) * 4);
            fake::failCall(number);
            const CudaEvaluator<float> cuda(table, {.hasAdjoint = true});
            CudaWorkspace workspace = cuda.workspace(3, stream);
            CudaBuffer<float> there{std::span<const float>(points)};
            cuda.evaluate(pose, kXyz, there, kXyz, {0, table.rowCount()}, workspace);
            cuda.evaluate(pose, kXyz, points, {0, 3, 4}, {0, table.rowCount()}, workspace);
            cuda.evaluateAdjoint(there, kXyz, points, kXyz, {0, table.columnCount()}, workspace);
            there.upload(points, stream);
            there.download(points, stream);
            workspace.synchronize();
            cudaDeviceCount();
        } catch (const CudaError& error) {
            thrown = error.what();
            EXPECT_EQ(cudaGetLastError(), cudaSuccess);
        }
        const std::string call = fake::failCall(0);
        EXPECT_EQ(fake::allocationCount(), before) << number;
        int current = -1;
        cudaGetDevice(&current);
        EXPECT_EQ(current, 0);
        if (call.empty()) break;
        failed.push_back(call);
        if (!thrown.empty()) {
            EXPECT_THAT(thrown, ::testing::MatchesRegex(call + "( .*)? has failed: .*"));
        } else {
            EXPECT_EQ(call, "cudaGetDevice") << number;
        }
        ASSERT_LT(number, 1000);
    }
    for (const char* const call :
         {"cudaGetDevice", "cudaMalloc", "cudaMemcpy", "cudaMallocAsync", "cudaStreamIsCapturing",
          "cudaMemcpyAsync", "cudaLaunchKernel", "cudaMemcpy2DAsync", "cudaStreamSynchronize",
          "cudaGetDeviceCount", "cudaFuncGetAttributes"})
        EXPECT_THAT(failed, Contains(call));
}

// Arguments that are rejected cause no calls.
TEST(CudaCalls, RejectedArgumentsCallNothing) {
    const CudaEvaluator<float> cuda(StencilTable<float>(1, {0, 1}, {0}, {2}));
    CudaWorkspace workspace;
    CudaBuffer<float> one(1);
    EXPECT_THAT(
        callsOf([&] {
            EXPECT_THROW(cuda.evaluate(one, {0, 1, 1}, one, {1, 1, 1}, {0, 1}, workspace), Error);
            cuda.evaluate(one, {0, 1, 1}, one, {0, 1, 1}, {1, 1}, workspace);
        }),
        ElementsAre());
}

}  // namespace
}  // namespace espalier::osd
