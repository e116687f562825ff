// SPDX-License-Identifier: Apache-2.0
#include <espalier/base/executor.h>
#include <espalier/embed/local_binding.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/osd/change_evaluator.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/osd/cpu_evaluator.h>
#include <espalier/osd/deformer.h>
#include <espalier/shapes/inventory.h>

#include <atomic>
#include <functional>
#include <thread>

#include "support/refined_lattice.h"
#include "support/test.h"
#include "support/thread_pool.h"
#include "support/zoo.h"

// Several threads of a host do the same work with the same objects at the same time.
namespace espalier::osd {
namespace {

constexpr int kThreads = 6;

/// Calls work(thread) on all threads at once: first each thread alone, then each with a shared
/// thread pool. oneTBB's arena is not used, because the thread sanitizer does not understand it.
template <class Work>
void onThreads(Work work) {
    ThreadPool pool(2);
    for (const bool isShared : {false, true}) {
        std::atomic<int> ready = 0;
        std::vector<std::thread> threads;
        for (int thread = 0; thread < kThreads; ++thread)
            threads.emplace_back([&, thread] {
                SerialExecutor serial;
                Executor& executor = isShared ? static_cast<Executor&>(pool) : serial;
                const ExecutorScope scope(executor);
                ++ready;
                while (ready < kThreads) std::this_thread::yield();
                work(thread);
            });
        for (std::thread& thread : threads) thread.join();
    }
}

const Lattice& lattice() {
    static const Lattice lattice = shapes::cylinder({.sectors = 5});
    return lattice;
}

std::vector<Point3> points(std::size_t count) {
    return pointsIn(Refined(lattice(), 2), count, 7);
}

/// Returns the pose of a thread; each thread has a different one.
std::vector<float> valuesOf(int thread, Index entries) {
    const auto values = randomValues(3 * std::size_t(entries), unsigned(thread));
    return {values.begin(), values.end()};
}

/// Expects that evaluate(source, destination) gives the same on all threads as on one.
void expectSame(Index rowCount, Index columnCount,
                const std::function<void(std::span<const float>, std::span<float>)>& evaluate) {
    std::vector<std::vector<float>> expected;
    for (int thread = 0; thread < kThreads; ++thread) {
        expected.emplace_back(3 * std::size_t(rowCount));
        evaluate(valuesOf(thread, columnCount), expected.back());
    }
    onThreads([&](int thread) {
        const auto source = valuesOf(thread, columnCount);
        std::vector<float> result(3 * std::size_t(rowCount));
        for (int repeat = 0; repeat < 3; ++repeat) {
            std::fill(result.begin(), result.end(), 99.0F);
            evaluate(source, result);
            EXPECT_EQ(result, expected[thread]);
        }
    });
}

TEST(Concurrency, EvaluatorsOfOneTable) {
    const TopologyRefiner base(lattice().complex);
    const auto model = points(6000);
    const auto table = stencils::convertTable<float>(
        embed::bindPoints({base, lattice().positions}, model, {.level = 3}).table);
    const auto factors = stencils::convertTable<float>(
        embed::bindFactored({base, lattice().positions}, model, {.level = 3}).table);
    const auto xyz = BufferDescriptor::packed(3);
    const Index rows = table.rowCount(), columns = table.columnCount();
    expectSame(rows, columns, [&](auto source, auto result) {
        CpuEvaluator::evaluate(table, source, xyz, result, xyz, {0, rows});
    });
    const CompiledTable<float> compiled(table);
    expectSame(rows, columns, [&](auto source, auto result) {
        compiled.evaluate(source, xyz, result, xyz, {0, rows});
    });
    const CompiledChain<float> chain(factors);
    expectSame(rows, columns, [&](auto source, auto result) {
        chain.evaluate(source, xyz, result, xyz, {0, rows});
    });
    const CompiledAdjoint<float> adjoint(table);
    expectSame(columns, rows, [&](auto source, auto result) {
        adjoint.evaluate(source, xyz, result, xyz, {0, columns});
    });
    const CompiledAdjointChain<float> adjointChain(factors);
    expectSame(columns, rows, [&](auto source, auto result) {
        adjointChain.evaluate(source, xyz, result, xyz, {0, columns});
    });
    const ChangeEvaluator<float> changes(compiled);
    expectSame(rows, columns, [&](auto source, auto result) {
        std::vector<float> before(source.begin(), source.end());
        before[3 * 4 + 1] += 1;
        compiled.evaluate(before, xyz, result, xyz, {0, rows});
        changes.evaluateChanged(source, xyz, result, xyz, std::vector<Index>{4});
    });
}

TEST(Concurrency, OneBinding) {
    const auto binding = bind::bindPoints({TopologyRefiner(lattice().complex), lattice().positions},
                                          points(3000), bind::Level{3});
    const auto expected = evaluateBinding(binding, lattice().positions);
    onThreads([&](int) { EXPECT_EQ(evaluateBinding(binding, lattice().positions), expected); });

    // A deformer: five poses are a batch of four and one alone.
    const Deformer<double> deformer(binding);
    std::vector<double> poses;
    for (int pose = 0; pose < 5; ++pose)
        for (const Point3& p : lattice().positions)
            for (const double x : p) poses.push_back(x * (1 + 0.1 * pose));
    const std::size_t size = 5 * 3 * binding.points.size();
    std::vector<double> once(size);
    deformer.deform(poses, once);
    onThreads([&](int) {
        std::vector<double> own(size);
        deformer.deform(poses, own);
        EXPECT_EQ(own, once);
    });
}

// The threads share a refiner, which derives its relations on first use.
TEST(Concurrency, BindingToOneLattice) {
    const auto model = points(2000);
    const auto bind = [&](const TopologyRefiner& base) {
        return embed::bindPoints({base, lattice().positions}, model, {.level = 3});
    };
    const auto expected = bind(TopologyRefiner(shapes::cylinder({.sectors = 5}).complex));
    // A new refiner, which has derived nothing yet.
    const TopologyRefiner fresh(shapes::cylinder({.sectors = 5}).complex);
    onThreads([&](int) { EXPECT_EQ(bind(fresh), expected); });
}

}  // namespace
}  // namespace espalier::osd
