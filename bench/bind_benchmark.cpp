// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/osd/binding_evaluator.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>
#include <sys/resource.h>

#include <random>

namespace espalier {
namespace {

std::vector<Point3> randomPoints(std::size_t count) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0.001, 0.999);
    std::vector<Point3> points(count);
    for (Point3& point : points) point = {uniform(random), uniform(random), uniform(random)};
    return points;
}

std::size_t peakMemory() {
    ::rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

/// Binds 1 M points to 1,000 base cells at level 3 and applies one pose: what the program's
/// `deform` does. Fails if the process has taken 3 GB or more.
void bindAndApply(benchmark::State& state) {
    constexpr std::size_t kMemoryLimit = 3'000'000'000;
    const int level = 3;
    const auto rules = stencils::Rules::Siggraph96;
    const Lattice lattice = shapes::box({.cells = {10, 10, 10}});
    const std::vector<Point3> points = randomPoints(1'000'000);
    for (auto _ : state) {
        far::TopologyRefiner refiner(lattice.complex);
        refiner.refineUniform(level);
        const auto positions = stencils::refinePositions(refiner, level, rules, lattice.positions);
        const auto embedding =
            stencils::embedPoints(refiner.level(level).complex, positions, points);
        const auto binding =
            stencils::makeBinding<double>(refiner, level, rules, embedding, points);
        const auto moved = osd::evaluateBinding(binding, lattice.positions);
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c)
                if (std::abs(moved[i][c] - points[i][c]) > 1e-12) {
                    state.SkipWithError("the rest pose does not give the points back");
                    return;
                }
        state.counters["entries a row"] =
            static_cast<double>(binding.table.entryCount()) / static_cast<double>(points.size());
    }
    state.counters["peak bytes"] = static_cast<double>(peakMemory());
    if (peakMemory() >= kMemoryLimit) state.SkipWithError("took 3 GB or more");
}
BENCHMARK(bindAndApply)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace espalier
