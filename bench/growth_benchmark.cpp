// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/embed/local_binding.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "workloads.h"

// Measures how the costs of binding and applying grow, for points of a surface in a box, and by
// level in a lattice that is not regular. Benchmarks are named growth/JOB BY SIZE/SIZE, plus
// /THREADS where threads are compared. The cost is plotted against the counter `size`.
namespace espalier {
namespace {

/// A lattice, and points of a surface in it.
struct Scene {
    std::vector<Point3> points;
    Lattice lattice;
    far::TopologyRefiner base;

    Scene(Lattice made, int pointCount)
        : points(bench::model(pointCount)), lattice(std::move(made)), base(lattice.complex) {}

    /// A box of cellCount³ cells.
    Scene(int cellCount, int pointCount)
        : Scene(shapes::box({.cells = {cellCount, cellCount, cellCount}}), pointCount) {}

    embed::BoundRows<> bind(int level) const {
        return embed::bindPoints({base, lattice.positions}, points, {.level = level});
    }
};

void bind(benchmark::State& state, const Scene& scene, int level, int threads) {
    const ThreadLimit limit(threads);
    embed::BoundRows<> binding;
    for (auto _ : state) binding = scene.bind(level);
    if (!bench::givesBack(stencils::applyLevelTable(binding.table, scene.lattice.positions),
                          scene.points))
        state.SkipWithError("the rest pose does not give the points back");
}

void bindByLevel(benchmark::State& state) {
    const auto level = static_cast<int>(state.range(0));
    const Scene scene(bench::irregularLattice(), 30'000);
    bind(state, scene, level, 1);
    // Cells of the whole level, up to a factor.
    state.counters["size"] = scene.lattice.complex.count(3) * std::pow(8, level);
}

void bindByPoints(benchmark::State& state) {
    const Scene scene(10, static_cast<int>(state.range(0)));
    bind(state, scene, 3, static_cast<int>(state.range(1)));
    state.counters["size"] = static_cast<double>(scene.points.size());
}

void bindByCells(benchmark::State& state) {
    const auto side = static_cast<int>(state.range(0));
    bind(state, Scene(side, 100'000), 3, 1);
    state.counters["size"] = std::pow(side, 3);
}

/// D of a scene on level 3, compiled.
struct Bound {
    Scene scene;
    osd::CompiledTable<float> table;

    explicit Bound(int pointCount)
        : scene(10, pointCount), table(stencils::convertTable<float>(scene.bind(3).table)) {}
};

/// Cached, since binding takes longer than applying.
const Bound& bound(int pointCount) {
    static std::map<int, Bound> made;
    return made.try_emplace(pointCount, pointCount).first->second;
}

void applyByPoints(benchmark::State& state) {
    const auto& [scene, table] = bound(static_cast<int>(state.range(0)));
    std::vector<float> source, result(3 * scene.points.size());
    for (const Point3& position : scene.lattice.positions)
        for (const double value : position) source.push_back(static_cast<float>(value));
    const ThreadLimit limit(static_cast<int>(state.range(1)));
    const auto layout = osd::BufferDescriptor::packed(3);
    const auto rowCount = static_cast<Index>(scene.points.size());
    for (auto _ : state) {
        table.evaluate(source, layout, result, layout, {0, rowCount});
        benchmark::ClobberMemory();
    }
    // Sums of about 50 products of numbers up to 1, in single precision.
    for (std::size_t i = 0; i < result.size(); ++i)
        if (!(std::abs(static_cast<double>(result[i]) - scene.points[i / 3][i % 3]) < 1e-5))
            return state.SkipWithError("the rest pose does not give the points back");
    state.counters["size"] = static_cast<double>(scene.points.size());
}

const std::vector<std::int64_t> kPointCounts = {10'000, 31'600, 100'000, 316'000, bench::kMillion};

BENCHMARK(bindByLevel)
    ->Name("growth/bind by level")
    ->DenseRange(1, 6)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(bindByPoints)
    ->Name("growth/bind by points")
    ->ArgsProduct({kPointCounts, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(bindByCells)
    ->Name("growth/bind by cells")
    ->Arg(2)
    ->Arg(3)
    ->Arg(5)
    ->Arg(8)
    ->Arg(13)
    ->Arg(20)
    ->Arg(34)
    ->Arg(58)
    ->Arg(100)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(applyByPoints)
    ->Name("growth/apply by points")
    ->ArgsProduct({kPointCounts, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace espalier
