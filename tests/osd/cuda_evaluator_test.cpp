// SPDX-License-Identifier: Apache-2.0
#include <espalier/osd/cuda/cuda_evaluator.h>

#include <utility>

#include "bound_table.h"
#include "cuda_device.h"
#include "host_device.h"
#include "sums.h"
#include "support/test.h"

// Tests what goes beyond the contract of all evaluators, which cuda_suite_test.cpp tests. Runs on a
// device, and on a fake device that is the host (fake_cuda.h).
namespace espalier::osd {
namespace {

using stencils::StencilTable;

using Device = CudaTest;

template <class Real>
const StencilTable<Real>& someTable() {
    static const auto table = tableOfAllKinds<Real>();
    return table;
}

template <class Real>
std::vector<Real> hostResults(const HostDevice<Real>& host, Index rowCount,
                              std::span<const Real> source, Offset length, bool isAdjoint) {
    std::vector<Real> results(rowCount * length);
    const auto layout = BufferDescriptor::packed(length);
    if (isAdjoint)
        host.evaluateAdjoint(source, layout, results, layout, {0, rowCount});
    else
        host.evaluate(source, layout, results, layout, {0, rowCount});
    return results;
}

template <class Real>
class CudaEvaluatorTest : public CudaTest {};
TYPED_TEST_SUITE(CudaEvaluatorTest, Reals);

// The device and the host add the same products in the same order.
TYPED_TEST(CudaEvaluatorTest, EqualsTheHostBitForBit) {
    using Real = TypeParam;
    for (const Lattice& lattice :
         {shapes::box({.cells = {4, 3, 3}}), shapes::cylinder({.sectors = 5})}) {
        const auto table = boundTable<Real>(lattice);
        for (const auto& [isGrouped, hasParameters] :
             std::vector<std::pair<bool, bool>>{{true, false}, {true, true}, {false, false}}) {
            const HostDevice<Real> host(table, isGrouped, hasParameters);
            const CudaEvaluator<Real> cuda(
                table,
                {.isGrouped = isGrouped, .hasParameters = hasParameters, .hasAdjoint = true});
            EXPECT_EQ(cuda.parametricRowCount(), host.arrays().parametricRowCount);
            EXPECT_EQ(cuda.rowCount(), table.rowCount());
            EXPECT_EQ(cuda.columnCount(), table.columnCount());
            CudaWorkspace workspace;
            for (const Offset length : {1, 7, 12}) {  // 7 is 4 and 3
                const auto layout = BufferDescriptor::packed(length);
                const auto pose = randomValues<Real>(table.columnCount() * length, 1);
                std::vector<Real> points(table.rowCount() * length);
                cuda.evaluate(pose, layout, points, layout, {0, table.rowCount()}, workspace);
                workspace.synchronize();
                EXPECT_EQ(points, hostResults<Real>(host, table.rowCount(), pose, length, false));

                const auto gradients = randomValues<Real>(table.rowCount() * length, 2);
                std::vector<Real> back(table.columnCount() * length);
                cuda.evaluateAdjoint(gradients, layout, back, layout, {0, table.columnCount()},
                                     workspace);
                workspace.synchronize();
                EXPECT_EQ(back,
                          hostResults<Real>(host, table.columnCount(), gradients, length, true));
            }
        }
    }
}

// Source and destination are each on the host or on the device, with gaps between entries.
TYPED_TEST(CudaEvaluatorTest, AcceptsSourcesAndDestinationsOnHostOrDevice) {
    using Real = TypeParam;
    const auto& table = someTable<Real>();
    const CudaEvaluator<Real> cuda(table);
    const Stream stream;
    CudaWorkspace workspace(stream);
    const BufferDescriptor from{2, 3, 5}, to{1, 3, 4};
    const auto source = randomValues<Real>(2 + table.columnCount() * from.stride, 3);
    const RowRange rows{table.rowCount() / 4, table.rowCount() / 2};
    const std::size_t size = 1 + rows.last * to.stride;
    std::vector<Real> expected(size, 99);
    HostDevice<Real>(table, true).evaluate(source, from, expected, to, rows);

    std::vector<Real> result(size, 99);
    cuda.evaluate(source, from, result, to, rows, workspace);
    workspace.synchronize();
    EXPECT_EQ(result, expected);

    const CudaBuffer<Real> sourceThere{std::span<const Real>(source)};
    std::fill(result.begin(), result.end(), Real{99});
    cuda.evaluate(sourceThere, from, result, to, rows, workspace);
    workspace.synchronize();
    EXPECT_EQ(result, expected);

    for (const bool isSourceThere : {false, true}) {
        std::fill(result.begin(), result.end(), Real{99});
        CudaBuffer<Real> there{std::span<const Real>(result)};
        if (isSourceThere)
            cuda.evaluate(sourceThere, from, there, to, rows, workspace);
        else
            cuda.evaluate(source, from, there, to, rows, workspace);
        there.download(result, stream);
        workspace.synchronize();
        EXPECT_EQ(result, expected);
    }
}

// Evaluations follow each other on a stream without waiting; each uses the results of the one
// before.
TYPED_TEST(CudaEvaluatorTest, RunsInTheOrderOfItsStream) {
    using Real = TypeParam;
    const auto& table = someTable<Real>();
    const CudaEvaluator<Real> cuda(table, {.hasAdjoint = true});
    const Stream stream;
    CudaWorkspace workspace = cuda.workspace(3, stream);
    EXPECT_EQ(workspace.stream(), static_cast<CudaStream>(stream));
    const auto xyz = BufferDescriptor::packed(3);
    const RowRange points{0, table.rowCount()}, vertices{0, table.columnCount()};
    const auto pose = randomValues<Real>(table.columnCount() * 3, 4);
    CudaBuffer<Real> there(std::size_t(table.rowCount()) * 3);
    CudaBuffer<Real> back{std::span<const Real>(pose)};
    const std::size_t bytes = workspace.byteCount();
    EXPECT_GT(bytes, 0U);
    // Applies DᵀD to the pose twice.
    for (int i = 0; i < 2; ++i) {
        cuda.evaluate(back, xyz, there, xyz, points, workspace);
        cuda.evaluateAdjoint(there, xyz, back, xyz, vertices, workspace);
    }
    EXPECT_EQ(workspace.byteCount(), bytes);
    std::vector<Real> result(pose.size());
    back.download(result, stream);
    workspace.synchronize();

    const HostDevice<Real> host(table, true);
    std::vector<Real> expected = pose;
    for (int i = 0; i < 2; ++i) {
        const auto moved = hostResults<Real>(host, table.rowCount(), expected, 3, false);
        expected = hostResults<Real>(host, table.columnCount(), moved, 3, true);
    }
    EXPECT_EQ(result, expected);
}

// A CUDA graph of two evaluations is launched again after the pose has changed in place.
TYPED_TEST(CudaEvaluatorTest, CanBeCapturedInAGraph) {
    using Real = TypeParam;
    const auto& table = someTable<Real>();
    const CudaEvaluator<Real> cuda(table, {.hasAdjoint = true});
    const Stream stream;
    CudaWorkspace workspace = cuda.workspace(3, stream);
    const auto xyz = BufferDescriptor::packed(3);
    CudaBuffer<Real> pose(std::size_t(table.columnCount()) * 3), back(pose.size());
    CudaBuffer<Real> points(std::size_t(table.rowCount()) * 3);

    cudaGraph_t graph = nullptr;
    cudaGraphExec_t executable = nullptr;
    ASSERT_EQ(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), cudaSuccess);
    cuda.evaluate(pose, xyz, points, xyz, {0, table.rowCount()}, workspace);
    cuda.evaluateAdjoint(points, xyz, back, xyz, {0, table.columnCount()}, workspace);
    ASSERT_EQ(cudaStreamEndCapture(stream, &graph), cudaSuccess);
    ASSERT_EQ(cudaGraphInstantiate(&executable, graph, 0), cudaSuccess);

    const HostDevice<Real> host(table, true);
    for (const unsigned seed : {5U, 6U}) {
        const auto values = randomValues<Real>(table.columnCount() * 3, seed);
        pose.upload(values, stream);
        ASSERT_EQ(cudaGraphLaunch(executable, stream), cudaSuccess);
        std::vector<Real> moved(points.size()), result(back.size());
        points.download(moved, stream);
        back.download(result, stream);
        workspace.synchronize();
        const auto expected = hostResults<Real>(host, table.rowCount(), values, 3, false);
        EXPECT_EQ(moved, expected);
        EXPECT_EQ(result, hostResults<Real>(host, table.columnCount(), expected, 3, true));
    }
    cudaGraphExecDestroy(executable);
    cudaGraphDestroy(graph);
}

TEST_F(Device, WorkspaceCannotGrowWhileItsStreamIsCaptured) {
    const auto& table = someTable<float>();
    const CudaEvaluator<float> cuda(table, {.hasAdjoint = true});
    const Stream stream;
    CudaWorkspace workspace(stream);
    const auto xyz = BufferDescriptor::packed(3);
    CudaBuffer<float> points(std::size_t(table.rowCount()) * 3);
    CudaBuffer<float> back(std::size_t(table.columnCount()) * 3);
    ASSERT_EQ(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), cudaSuccess);
    EXPECT_THAT(
        messageOf([&] {
            cuda.evaluateAdjoint(points, xyz, back, xyz, {0, table.columnCount()}, workspace);
        }),
        AllOf(HasSubstr("is used in a CUDA graph and holds 0 bytes"),
              HasSubstr("CudaEvaluator::workspace()")));
    cudaGraph_t graph = nullptr;
    ASSERT_EQ(cudaStreamEndCapture(stream, &graph), cudaSuccess);
    cudaGraphDestroy(graph);
}

// The graph holds the address of the memory.
TEST_F(Device, WorkspaceCannotGrowOnceAGraphUsesIt) {
    const auto& table = someTable<float>();
    const CudaEvaluator<float> cuda(table, {.hasAdjoint = true});
    const Stream stream;
    CudaWorkspace workspace = cuda.workspace(3, stream);
    const std::byte* const memory = workspace.reserve(1);
    const auto xyz = BufferDescriptor::packed(3);
    CudaBuffer<float> points(std::size_t(table.rowCount()) * 3);
    CudaBuffer<float> back(std::size_t(table.columnCount()) * 3);
    ASSERT_EQ(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), cudaSuccess);
    cuda.evaluateAdjoint(points, xyz, back, xyz, {0, table.columnCount()}, workspace);
    cudaGraph_t graph = nullptr;
    ASSERT_EQ(cudaStreamEndCapture(stream, &graph), cudaSuccess);
    cudaGraphDestroy(graph);
    EXPECT_THROW(workspace.reserve(workspace.byteCount() + 1), Error);
    CudaWorkspace moved = std::move(workspace);
    EXPECT_THROW(moved.reserve(moved.byteCount() + 1), Error);
    EXPECT_EQ(moved.reserve(moved.byteCount()), memory);
}

/// Numbers in page-locked memory.
class PageLocked {
public:
    explicit PageLocked(std::size_t size) {
        void* memory = nullptr;
        if (cudaMallocHost(&memory, size * sizeof(float)) != cudaSuccess)
            throw std::runtime_error("cudaMallocHost");
        values_ = {static_cast<float*>(memory), size};
    }
    ~PageLocked() { cudaFreeHost(values_.data()); }
    PageLocked(const PageLocked&) = delete;
    PageLocked& operator=(const PageLocked&) = delete;

    std::span<float> values() const { return values_; }

private:
    std::span<float> values_;
};

// Copies from and to page-locked memory run on the stream, in order with the products.
TEST_F(Device, PageLockedMemoryIsCopiedOnTheStream) {
    const auto& table = someTable<float>();
    const CudaEvaluator<float> cuda(table);
    const Stream stream;
    CudaWorkspace workspace(stream);
    const auto xyz = BufferDescriptor::packed(3);
    const auto count = std::size_t(table.rowCount()) * 3;
    const PageLocked pose(std::size_t(table.columnCount()) * 3);
    const PageLocked first(count), second(count);
    const auto values = randomValues<float>(table.columnCount() * 3, 8);
    std::copy(values.begin(), values.end(), pose.values().begin());
    cuda.evaluate(pose.values(), xyz, first.values(), xyz, {0, table.rowCount()}, workspace);
    cuda.evaluate(pose.values(), xyz, second.values(), {0, 3, 3}, {0, table.rowCount() / 2},
                  workspace);
    workspace.synchronize();
    const auto expected =
        hostResults<float>(HostDevice<float>(table, true), table.rowCount(), values, 3, false);
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), first.values().begin()));
    EXPECT_TRUE(std::equal(expected.begin(), expected.begin() + table.rowCount() / 2 * 3,
                           second.values().begin()));
}

TEST_F(Device, MovedObjectsStayValid) {
    const StencilTable<float> twice(1, {0, 1}, {0}, {2}), thrice(1, {0, 1}, {0}, {3});
    CudaEvaluator<float> cuda(twice);
    cuda = CudaEvaluator<float>(thrice);
    CudaWorkspace workspace;
    workspace.reserve(1000);
    CudaWorkspace other(std::move(workspace));
    EXPECT_EQ(other.byteCount(), 1000U);
    workspace = std::move(other);
    EXPECT_EQ(workspace.byteCount(), 1000U);
    CudaBuffer<float> source{std::span<const float>(std::vector<float>{7})}, result(1);
    source = CudaBuffer<float>(std::span<const float>(std::vector<float>{14}));
    cuda.evaluate(source, {0, 1, 1}, result, {0, 1, 1}, {0, 1}, workspace);
    std::vector<float> value(1);
    result.download(value);
    workspace.synchronize();
    EXPECT_THAT(value, ElementsAre(42));
}

TEST_F(Device, AdjointMustBeRequested) {
    const auto& table = someTable<float>();
    const CudaEvaluator<float> cuda(table);
    const CudaEvaluator<float> both(table, {.hasAdjoint = true});
    EXPECT_EQ(cuda.byteCount(), cuda.tableByteCount());
    EXPECT_EQ(both.tableByteCount(), cuda.tableByteCount());
    EXPECT_GT(both.byteCount(), cuda.byteCount());
    CudaWorkspace workspace;
    std::vector<float> points(table.rowCount(), 1);
    std::vector<float> back(table.columnCount());
    EXPECT_REFUSED(Error, "CudaTableOptions::hasAdjoint",
                   cuda.evaluateAdjoint(points, {0, 1, 1}, back, {0, 1, 1},
                                        {0, table.columnCount()}, workspace));
}

TEST_F(Device, RowsOfSplinesTakeLessMemory) {
    const auto table = boundTable<float>(shapes::box({.cells = {4, 3, 3}}));
    const CudaEvaluator<float> cuda(table), parametric(table, {.hasParameters = true});
    EXPECT_EQ(cuda.parametricRowCount(), 0);
    EXPECT_GT(parametric.parametricRowCount(), table.rowCount() / 2);
    EXPECT_LT(parametric.byteCount() + std::size_t(parametric.parametricRowCount()) * 24,
              cuda.byteCount());
    EXPECT_REFUSED(Error, "needs isGrouped",
                   CudaEvaluator<float>(table, {.isGrouped = false, .hasParameters = true}));
}

// By hand, with a row without entries; and each kind of row against the sums without an addend.
TEST_F(Device, AnAddendIsAddedToEachSum) {
    const StencilTable<float> small(2, {0, 1, 1, 2, 2}, {1, 0}, {1, 1});
    const CudaEvaluator<float> cuda(small);
    const Stream stream;
    CudaWorkspace workspace(stream);
    const std::vector<float> moves = {10, 20, 30, 40, 50, 60};
    const CudaBuffer<float> atRest{
        std::span<const float>(std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12})};
    const BufferDescriptor to{1, 3, 4};
    CudaBuffer<float> points{std::span<const float>(std::vector<float>(1 + 4 * 4, 99))};
    cuda.evaluate(moves, {0, 3, 3}, points, to, {0, 4}, workspace,
                  CudaAddend<float>::packed(atRest, 3));
    std::vector<float> result(points.size());
    points.download(result, stream);
    workspace.synchronize();
    EXPECT_THAT(result,
                ElementsAre(99, 41, 52, 63, 99, 4, 5, 6, 99, 17, 28, 39, 99, 10, 11, 12, 99));
    EXPECT_REFUSED(
        Error, "the addend buffer holds 12",
        cuda.evaluate(moves, {0, 3, 3}, points, to, {0, 4}, workspace, {atRest, {1, 3, 3}}));

    const auto table = boundTable<float>(shapes::cylinder({.sectors = 5}), 1500);
    const Index rows = table.rowCount();
    const auto source = randomValues<float>(table.columnCount() * 6, 1);
    const auto rest = randomValues<float>(rows * 3, 2);
    const CudaBuffer<float> restOnDevice{std::span<const float>(rest)};
    const auto layout = BufferDescriptor::packed(6);
    for (const bool isGrouped : {true, false}) {
        const CudaEvaluator<float> large(table, {.isGrouped = isGrouped});
        std::vector<float> sums(rows * 6), moved(rows * 6);
        large.evaluate(source, layout, sums, layout, {0, rows}, workspace);
        // To the host, and in two ranges; the poses share the addend.
        for (const RowRange range : {RowRange{0, rows / 3}, RowRange{rows / 3, rows}})
            large.evaluate(source, layout, moved, layout, range, workspace,
                           CudaAddend<float>::packed(restOnDevice, 3));
        workspace.synchronize();
        for (std::size_t i = 0; i < sums.size(); ++i)
            ASSERT_EQ(moved[i], sums[i] + rest[i / 6 * 3 + i % 3]) << i;
    }
}

TEST_F(Device, BuffersHoldUploadedValues) {
    const std::vector<float> values = {1, 2, 3};
    CudaBuffer<float> buffer{std::span<const float>(values)};
    EXPECT_EQ(buffer.size(), 3U);
    std::vector<float> result(3), tooMany(4);
    CudaBuffer<float> moved = std::move(buffer);
    moved.upload(std::vector<float>{7});
    moved.download(result);
    CudaWorkspace().synchronize();
    EXPECT_THAT(result, ElementsAre(7, 2, 3));
    EXPECT_THROW(CudaEvaluator<float>(StencilTable<float>(1, {0, 1}, {0}, {1})).workspace(0),
                 Error);
    EXPECT_THROW(moved.upload(tooMany), Error);
    EXPECT_THROW(moved.download(tooMany), Error);
    const CudaBuffer<float> empty(0);
    EXPECT_EQ(empty.data(), nullptr);
}

TEST_F(Device, EvaluatesTablesWithoutRowsOrEntries) {
    CudaWorkspace workspace;
    std::vector<float> none, two(2, 99);
    const CudaEvaluator<float> nothing((StencilTable<float>()), {.hasAdjoint = true});
    nothing.evaluate(none, {0, 1, 1}, none, {0, 1, 1}, {0, 0}, workspace);
    nothing.evaluateAdjoint(none, {0, 1, 1}, none, {0, 1, 1}, {0, 0}, workspace);
    const CudaEvaluator<float> empty(StencilTable<float>(0, {0, 0, 0}, {}, {}),
                                     {.hasAdjoint = true});
    empty.evaluate(none, {0, 1, 1}, two, {0, 1, 1}, {0, 2}, workspace);
    empty.evaluateAdjoint(two, {0, 1, 1}, none, {0, 1, 1}, {0, 0}, workspace);
    workspace.synchronize();
    EXPECT_THAT(two, ElementsAre(0, 0));
}

// Runs only where there is no device.
TEST(NoDevice, IsReportedByTheFailingCall) {
    if (cudaDeviceCount() > 0) GTEST_SKIP() << "there is a device";
    try {
        const CudaEvaluator<float> evaluator(StencilTable<float>(1, {0, 1}, {0}, {1}));
        ADD_FAILURE() << "there is none, and it was found";
    } catch (const CudaError& error) {
        EXPECT_THAT(error.what(),
                    AllOf(HasSubstr("cudaGetDevice has failed: "), HasSubstr("(cuda")));
        EXPECT_NE(error.code(), 0);
    }
}

}  // namespace
}  // namespace espalier::osd
