// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/limit/limit_binding.h>
#include <espalier/osd/compiled_table.h>
#include <espalier/stencils/composition.h>

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "workloads.h"

// Binds the points of a surface to the limit, and to levels 5 and 6, and measures the distance of
// these from the limit. Benchmarks are named limit/bind/LATTICE/WHAT and limit/apply/LATTICE/WHAT.
// In the box all cells are regular; the cylinder has an irregular axis.
namespace espalier {
namespace {

constexpr int kPointCount = 200'000;

struct Scene {
    Lattice lattice;
    std::vector<Point3> points = bench::model(kPointCount);
    far::TopologyRefiner base{lattice.complex};

    /// Returns D for a level, or for the limit if the level is 0.
    embed::BoundRows<> bind(int level) const {
        if (level > 0)
            return embed::bindPoints({base, lattice.positions}, points, {.level = level});
        return limit::bindLimit({base, lattice.positions}, points);
    }

    /// Returns a pose that moves all vertices differently, by sines of their positions.
    std::vector<Point3> pose() const {
        std::vector<Point3> result = lattice.positions;
        for (Point3& p : result)
            p = {p[0] + 0.1 * std::sin(7 * p[1]), p[1] + 0.1 * std::sin(5 * p[2]),
                 p[2] + 0.1 * std::sin(6 * p[0])};
        return result;
    }
};

const Scene& scene(bool isRegular) {
    static const Scene regular{bench::regularLattice()};
    static const Scene irregular{bench::irregularLattice()};
    return isRegular ? regular : irregular;
}

/// Returns a cached binding, made on all threads, for benchmarks that do not measure binding.
const embed::BoundRows<>& bound(bool isRegular, int level) {
    static std::map<std::pair<bool, int>, embed::BoundRows<>> made;
    const auto [place, isNew] = made.try_emplace({isRegular, level});
    if (isNew) place->second = scene(isRegular).bind(level);
    return place->second;
}

/// Mean distance of two poses of a model.
double meanDistance(const std::vector<Point3>& first, const std::vector<Point3>& second) {
    double sum = 0;
    for (std::size_t i = 0; i < first.size(); ++i)
        sum += std::hypot(first[i][0] - second[i][0], first[i][1] - second[i][1],
                          first[i][2] - second[i][2]);
    return sum / static_cast<double>(first.size());
}

void bind(benchmark::State& state, bool isRegular, int level, int threads) {
    const ThreadLimit limit(threads);
    const Scene& made = scene(isRegular);
    embed::BoundRows<> binding;
    for (auto _ : state) binding = made.bind(level);
    if (!bench::givesBack(stencils::applyLevelTable(binding.table, made.lattice.positions),
                          made.points))
        return state.SkipWithError("the rest pose does not give the points back");
    state.counters["entries a row"] =
        static_cast<double>(binding.table.entryCount()) / binding.table.rowCount();
    state.counters["items"] = static_cast<double>(made.points.size());
    if (level > 0)
        state.counters["distance from the limit"] =
            meanDistance(stencils::applyLevelTable(binding.table, made.pose()),
                         stencils::applyLevelTable(bound(isRegular, 0).table, made.pose()));
}

void apply(benchmark::State& state, bool isRegular, int level) {
    const auto table = stencils::convertTable<float>(bound(isRegular, level).table);
    const ThreadLimit limit(1);
    const osd::CompiledTable<float> compiled(table);
    const auto layout = osd::BufferDescriptor::packed(3);
    const std::vector<float> source = bench::randomValues(table, 3);
    std::vector<float> result(3 * static_cast<std::size_t>(table.rowCount()));
    for (auto _ : state) {
        compiled.evaluate(source, layout, result, layout, {0, table.rowCount()});
        benchmark::ClobberMemory();
    }
    state.counters["items"] = table.rowCount();
}

const bool kRegistered = [] {
    for (const bool isRegular : {true, false})
        for (const int level : {5, 6, 0}) {
            const std::string what = std::string(isRegular ? "regular" : "irregular") + "/" +
                                     (level > 0 ? "level " + std::to_string(level) : "limit");
            for (const int threads : {1, 2})
                benchmark::RegisterBenchmark(
                    ("limit/bind/" + what + (threads == 1 ? "" : " 2 threads")).c_str(),
                    [=](auto& state) { bind(state, isRegular, level, threads); })
                    ->UseRealTime()
                    ->Unit(benchmark::kMillisecond)
                    ->Iterations(1);
            benchmark::RegisterBenchmark(("limit/apply/" + what).c_str(),
                                         [=](auto& state) { apply(state, isRegular, level); })
                ->UseRealTime()
                ->Unit(benchmark::kMillisecond);
        }
    return true;
}();

}  // namespace
}  // namespace espalier
