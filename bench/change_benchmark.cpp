// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/osd/change_evaluator.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "workloads.h"

// Moves some vertices of the lattice, and compares the update with a whole evaluation. Benchmarks
// are named change/MOVED/WHO. MOVED is a number of vertices "together", around one of them, or
// "apart", all over the lattice; or "all" for CompiledTable::evaluate().
namespace espalier {
namespace {

using osd::BufferDescriptor;

struct Model {
    stencils::StencilTable<float> table = bench::regularModel().inFloat.table;
    osd::CompiledTable<float> compiled = osd::CompiledTable<float>(table);
    osd::ChangeEvaluator<float> changes = osd::ChangeEvaluator<float>(compiled);
    std::vector<float> source = bench::randomValues(table, 3);
    std::vector<float> result = std::vector<float>(3 * static_cast<std::size_t>(table.rowCount()));
};

Model& model() {
    static Model model;
    return model;
}

/// Returns some vertices, of which the first carries some of the model.
std::vector<Index> someVertices(const Model& model, std::size_t count, bool areTogether) {
    std::vector<Index> vertices(model.table.columnCount());
    std::iota(vertices.begin(), vertices.end(), Index{0});
    std::shuffle(vertices.begin(), vertices.end(), std::mt19937(1));
    const auto first = std::find_if(vertices.begin(), vertices.end(), [&](Index vertex) {
        return !model.changes.rowsOf(std::vector<Index>{vertex}).empty();
    });
    std::iter_swap(vertices.begin(), first);
    if (areTogether) {
        const auto positions = bench::regularLattice().positions;
        const auto distance = [&, center = vertices.front()](Index vertex) {
            double sum = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                const double way = positions[vertex][c] - positions[center][c];
                sum += way * way;
            }
            return sum;
        };
        std::stable_sort(vertices.begin(), vertices.end(),
                         [&](Index a, Index b) { return distance(a) < distance(b); });
    }
    vertices.resize(count);
    return vertices;
}

void change(benchmark::State& state, std::size_t count, bool areTogether, int threads) {
    const ThreadLimit limit(threads);
    Model& own = model();
    const auto xyz = BufferDescriptor::packed(3);
    const osd::RowRange rows{0, own.table.rowCount()};
    const auto moved = someVertices(own, count, areTogether);
    osd::Workspace workspace = own.changes.workspace(3);
    own.compiled.evaluate(own.source, xyz, own.result, xyz, rows);
    for (const Index vertex : moved) own.source[3 * static_cast<std::size_t>(vertex)] += 0.25F;
    const auto evaluate = [&] {
        own.changes.evaluateChanged(own.source, xyz, own.result, xyz, moved, workspace);
        benchmark::ClobberMemory();
    };
    evaluate();
    auto whole = own.result;
    own.compiled.evaluate(own.source, xyz, whole, xyz, rows);
    if (whole != own.result) return state.SkipWithError("the result is wrong");
    for (auto _ : state) evaluate();
    state.counters["vertices"] = own.table.columnCount();
    state.counters["rows"] = static_cast<double>(own.changes.rowsOf(moved).size());
}

void evaluateAll(benchmark::State& state, int threads) {
    const ThreadLimit limit(threads);
    Model& own = model();
    const auto xyz = BufferDescriptor::packed(3);
    osd::Workspace workspace = own.compiled.workspace(3);
    for (auto _ : state) {
        own.compiled.evaluate(own.source, xyz, own.result, xyz, {0, own.table.rowCount()},
                              workspace);
        benchmark::ClobberMemory();
    }
    state.counters["vertices"] = own.table.columnCount();
    state.counters["rows"] = own.table.rowCount();
}

const bool kRegistered = [] {
    for (const int threads : {1, 2}) {
        const std::string who = threads == 1 ? "Espalier" : "Espalier 2 threads";
        const auto add = [&](const std::string& moved, auto run) {
            benchmark::RegisterBenchmark(("change/" + moved + "/" + who).c_str(), run)
                ->UseRealTime()
                ->Unit(benchmark::kMillisecond);
        };
        add("all", [=](benchmark::State& state) { evaluateAll(state, threads); });
        for (const std::size_t count : {1U, 10U, 100U})
            for (const bool areTogether : {true, false})
                add(std::to_string(count) + (areTogether ? " together" : " apart"),
                    [=](benchmark::State& state) { change(state, count, areTogether, threads); });
    }
    return true;
}();

}  // namespace
}  // namespace espalier
