// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/array.h>
#include <espalier/shapes/inventory.h>
#include <espalier/solve/rigid_pull.h>

#include <string>
#include <vector>

// Drags the end of a bar of 500 vertices sideways, while its cells stay as rigid as they can.
// Benchmarks are named pull/PART: "factor" makes the solver, "frame" moves the target by a
// hundredth of the bar's length and updates the pose of the frame before, "from rest" finds the
// pose of a pull by a quarter of the length. "into the bar" is a frame of a drag into the bar, by
// 0.3 to 0.45 of its length, against the barrier that keeps cells from folding. The counter
// "iterations" is the mean for each, and "at barrier" the part of the frames that meet the barrier.
namespace espalier {
namespace {

constexpr double kLength = 20;

/// A bar, and a row of D for the middle of its last cell.
struct Bar {
    Lattice lattice = shapes::box({.cells = {4, 4, 19}, .min = {0, 0, 0}, .max = {4, 4, kLength}});
    stencils::StencilTable<double> deformation = [this] {
        Array<Index> columns;
        for (const Index vertex : lattice.complex.relation(3, 0)[lattice.complex.count(3) - 1])
            columns.push_back(vertex);
        const Array<double> weights(columns.size(), 1.0 / 8);
        return stencils::StencilTable<double>(
            lattice.complex.count(0), {0, static_cast<Offset>(columns.size())}, columns, weights);
    }();

    solve::RigidPull pull(int maxIterations) const {
        return solve::RigidPull(lattice.complex, lattice.positions, deformation,
                                {.maxIterations = maxIterations});
    }
};

void factor(benchmark::State& state) {
    const Bar bar;
    for (auto _ : state) benchmark::DoNotOptimize(bar.pull(1));
}

/// Drags by steps along an axis, between two distances, forwards and back.
void frame(benchmark::State& state, std::size_t axis, double from, double to) {
    const Bar bar;
    const auto pull = bar.pull(static_cast<int>(state.range(0)));
    std::vector<Point3> pose;
    double iterations = 0, atBarrier = 0, at = from * kLength, step = 0.01 * kLength;
    for (auto _ : state) {
        if (at + step > to * kLength || at + step < from * kLength) step = -step;
        at += step;
        Point3 by = {0, 0, 0};
        by[axis] = at;
        const auto found = pull.solve(std::vector<Point3>{by}, pose);
        iterations += found.iterations;
        atBarrier += found.meetsBarrier ? 1 : 0;
        pose = found.displacements;
    }
    state.counters["at barrier"] = atBarrier / static_cast<double>(state.iterations());
    state.counters["iterations"] = iterations / static_cast<double>(state.iterations());
}

void fromRest(benchmark::State& state) {
    const Bar bar;
    const auto pull = bar.pull(500);
    double iterations = 0;
    for (auto _ : state)
        iterations += pull.solve(std::vector<Point3>{{kLength / 4, 0, 0}}).iterations;
    state.counters["iterations"] = iterations / static_cast<double>(state.iterations());
}

BENCHMARK(factor)->Name("pull/factor")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, sideways, 0, -0.4, 0.4)
    ->Name("pull/frame")
    ->Arg(1)
    ->Arg(20)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, along, 2, -0.45, -0.3)
    ->Name("pull/frame into the bar")
    ->Arg(1)
    ->Arg(20)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(fromRest)->Name("pull/from rest")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace espalier
