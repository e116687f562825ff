// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/embed/local_binding.h>
#include <espalier/osd/change_evaluator.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/osd/deformer.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <memory>
#include <mutex>

#include "support/call_counts.h"
#include "support/mesh_shapes.h"
#include "support/refined_lattice.h"
#include "support/tables.h"
#include "support/test.h"
#include "support/thread_pool.h"
#include "support/zoo.h"

// Real-time hosts need this: after binding, evaluations allocate nothing and take no lock.
namespace espalier::osd {
namespace {

using stencils::FactoredTable;

constexpr CallCounts kNone = {};

TEST(RealTime, CallsAreCounted) {
    EXPECT_EQ(callsOf([] { ::operator delete(::operator new(8)); }).allocations, 1);
    EXPECT_EQ(callsOf([] { std::vector<double>(1000).clear(); }).allocations, 1);
    EXPECT_EQ(callsOf([] { Workspace(100).reserve(50); }).allocations, 1);
    std::mutex mutex;
    EXPECT_EQ(callsOf([&] { const std::lock_guard lock(mutex); }), (CallCounts{0, 1}));
}

/// Tables with all forms of rows: outer products, panels, ungrouped rows, and rows too long for the
/// stack.
template <class Real>
struct Tables {
    std::vector<StencilTable<Real>> tables;
    FactoredTable<Real> factored;

    Tables() {
        for (const Lattice& lattice :
             {shapes::box({.cells = {5, 4, 4}}), shapes::cylinder({.sectors = 5})}) {
            const TopologyRefiner base(lattice.complex);
            const auto points = pointsIn(Refined(lattice, 1), 12'000, 5);
            tables.push_back(stencils::convertTable<Real>(
                embed::bindPoints({base, lattice.positions}, points, {.level = 3}).table));
            factored = stencils::convertTable<Real>(
                embed::bindFactored({base, lattice.positions}, points, {.level = 3}).table);
        }
        const Lattice torus = surfaceOf(shapes::torus());
        TopologyRefiner refiner = refined(torus.complex, 4);
        tables.push_back(stencils::convertTable<Real>(stencils::buildStencils(refiner, 4)));
        tables.push_back(tableOfLongRows<Real>(60, 2500, [](std::size_t) { return 0.001; }));
    }
};

/// Calls evaluate(source, destination, layout) for packed xyz, for padded xyz, and for twelve
/// poses.
template <class Real, class Evaluate>
void forEachLayout(Index rowCount, Index columnCount, Evaluate evaluate) {
    for (const BufferDescriptor layout :
         {BufferDescriptor{0, 3, 3}, BufferDescriptor{0, 3, 4}, BufferDescriptor{0, 36, 36}}) {
        const std::vector<Real> source(columnCount * layout.stride, 1);
        std::vector<Real> destination(rowCount * layout.stride);
        evaluate(std::span<const Real>(source), std::span<Real>(destination), layout);
    }
}

/// Checks that evaluations make no calls: with a workspace from the evaluator from the first
/// evaluation on, with an empty workspace from the second on.
template <class Real, class Evaluator>
void expectNoCalls(const Evaluator& evaluator) {
    const RowRange rows{0, evaluator.rowCount()};
    forEachLayout<Real>(evaluator.rowCount(), evaluator.columnCount(),
                        [&](auto source, auto destination, const BufferDescriptor& layout) {
                            const auto evaluate = [&](Workspace& workspace) {
                                return callsOf([&] {
                                    evaluator.evaluate(source, layout, destination, layout, rows,
                                                       workspace);
                                });
                            };
                            Workspace own = evaluator.workspace(layout.length), empty;
                            EXPECT_EQ(evaluate(own), kNone);
                            evaluate(empty);
                            EXPECT_EQ(evaluate(empty), kNone);
                        });
}

template <class Real>
class RealTimeTest : public ::testing::Test {
protected:
    static const Tables<Real>& tables() {
        static const Tables<Real> tables;
        return tables;
    }
    SerialExecutor serial;
};
TYPED_TEST_SUITE(RealTimeTest, Reals);

TYPED_TEST(RealTimeTest, CompiledEvaluators) {
    using Real = TypeParam;
    const auto& factored = this->tables().factored;
    const ExecutorScope scope(this->serial);
    for (const auto& table : this->tables().tables) {
        expectNoCalls<Real>(CompiledTable<Real>(table));
        expectNoCalls<Real>(CompiledAdjoint<Real>(table));
    }
    expectNoCalls<Real>(CompiledChain<Real>(factored));
    expectNoCalls<Real>(CompiledAdjointChain<Real>(factored));
}

TYPED_TEST(RealTimeTest, PlainEvaluators) {
    using Real = TypeParam;
    const ExecutorScope scope(this->serial);
    for (const auto& table : this->tables().tables) {
        const RowRange rows{0, table.rowCount()};
        forEachLayout<Real>(table.rowCount(), table.columnCount(),
                            [&](auto source, auto destination, const BufferDescriptor& layout) {
                                EXPECT_EQ(callsOf([&] {
                                              CpuEvaluator::evaluate(table, source, layout,
                                                                     destination, layout, rows);
                                          }),
                                          kNone);
                            });
    }
}

TYPED_TEST(RealTimeTest, Changes) {
    using Real = TypeParam;
    const ExecutorScope scope(this->serial);
    for (const auto& table : this->tables().tables) {
        const CompiledTable<Real> compiled(table);
        const ChangeEvaluator<Real> changes(compiled);
        std::vector<Index> all(table.columnCount());
        std::iota(all.begin(), all.end(), Index{0});
        forEachLayout<Real>(
            table.rowCount(), table.columnCount(),
            [&](auto source, auto destination, const BufferDescriptor& layout) {
                Workspace workspace = changes.workspace(layout.length);
                for (const std::size_t count : {std::size_t{1}, std::size_t{10}, all.size()})
                    EXPECT_EQ(callsOf([&] {
                                  changes.evaluateChanged(source, layout, destination, layout,
                                                          std::span(all).first(count), workspace);
                              }),
                              kNone);
            });
    }
}

// A source with the padded layout needs no copy.
TYPED_TEST(RealTimeTest, PaddedSourcesNeedNoWorkspace) {
    using Real = TypeParam;
    const ExecutorScope scope(this->serial);
    const auto& table = this->tables().tables.front();
    const CompiledTable<Real> compiled(table);
    const BufferDescriptor padded{0, 3, 4}, packed{0, 3, 3};
    const auto count = std::size_t(table.columnCount()) * 4 * sizeof(Real);
    Workspace memory(count);
    auto* const values = reinterpret_cast<Real*>(memory.reserve(count));
    std::uninitialized_fill_n(values, count / sizeof(Real), Real{1});
    std::vector<Real> destination(3 * std::size_t(table.rowCount()));
    const auto evaluate = [&](const BufferDescriptor& layout) {
        return callsOf([&] {
            compiled.evaluate(std::span<const Real>(values, count / sizeof(Real)), layout,
                              destination, packed, {0, table.rowCount()});
        });
    };
    EXPECT_EQ(evaluate(padded), kNone);
    EXPECT_EQ(evaluate(packed), (CallCounts{1, 0}));
}

// Runs on threads of the host, which have locks of their own.
TYPED_TEST(RealTimeTest, HostExecutorAllocatesNothing) {
    using Real = TypeParam;
    ThreadPool pool(2);
    const ExecutorScope scope(pool);
    const auto& table = this->tables().tables.front();
    const CompiledTable<Real> compiled(table);
    Workspace workspace = compiled.workspace(3);
    const std::vector<Real> source(3 * std::size_t(table.columnCount()), 1);
    std::vector<Real> destination(3 * std::size_t(table.rowCount()));
    const auto xyz = BufferDescriptor::packed(3);
    EXPECT_EQ(
        callsOf([&] {
            compiled.evaluate(source, xyz, destination, xyz, {0, table.rowCount()}, workspace);
        }).allocations,
        0);
}

// After the first call, a deformer allocates nothing, also for several poses at once. A point
// outside stays exactly where it was.
TYPED_TEST(RealTimeTest, Deforming) {
    using Real = TypeParam;
    const Lattice cube = shapes::box();
    const std::vector<Point3> points = {{0.5, 0.25, 0.75}, {3, 3.25, 3}, {1, 1, 1}};
    const auto binding =
        bind::bindPoints({TopologyRefiner(cube.complex), cube.positions}, points, bind::Level{2});
    const Deformer<Real> deformer(binding);
    std::vector<Real> poses;
    for (int pose = 0; pose < 5; ++pose)
        for (const Point3& p : cube.positions)
            for (const double x : p) poses.push_back(static_cast<Real>(x * (pose + 1)));
    std::vector<Real> result(5 * 9, 99);
    const std::vector<Index> changed = {0, 3};
    const std::span first(poses.data(), 3 * cube.positions.size());
    const auto deform = [&] {
        deformer.deform(poses, result);
        deformer.deformChanged(first, changed, std::span(result).first(9));
    };
    const ExecutorScope scope(this->serial);
    deform();
    EXPECT_EQ(callsOf(deform).allocations, 0);
    for (int pose = 0; pose < 5; ++pose) EXPECT_EQ(result[9 * pose + 4], Real(3.25));
}

}  // namespace
}  // namespace espalier::osd
