// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/far/complex_builder.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/shapes/inventory.h>
#include <espalier/stencils/composition.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "workloads.h"
#ifdef ESPALIER_WITH_OPENSUBDIV
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTableFactory.h>

#include "open_subdiv_mesh.h"
#endif

// Work that is done once for a lattice or a mesh: its levels and their tables; and carrying values
// to a level without a table. Benchmarks are named JOB/WORKLOAD/LEVEL/WHO.
namespace espalier {
namespace {

/// Returns one value for each vertex; the values distinguish vertices.
std::vector<double> valuesOf(Index count) {
    std::vector<double> values(3 * static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = std::sin(static_cast<double>(i) * 0.7);
    return values;
}

far::TopologyRefiner refined(const far::CellComplex& complex, int level) {
    far::TopologyRefiner refiner(complex);
    refiner.refineUniform(level);
    return refiner;
}

/// Number of entities of the complex's own dimension in levels 1 to the last.
double childCount(const far::TopologyRefiner& refiner) {
    double count = 0;
    for (int k = 1; k <= refiner.maxLevel(); ++k)
        count += refiner.level(k).complex.count(refiner.dimension());
    return count;
}

void refine(benchmark::State& state, const far::CellComplex& complex, int level, int threads) {
    const ThreadLimit limit(threads);
    const far::TopologyRefiner base(complex);
    double children = 0;
    for (auto _ : state) {
        // As for the peer, the base is made and classified outside the measured time.
        far::TopologyRefiner refiner = base;
        refiner.refineUniform(level);
        state.PauseTiming();
        children = childCount(refiner);
        state.ResumeTiming();
    }
    state.counters["items"] = children;
}

void build(benchmark::State& state, const far::CellComplex& complex, int level, int threads) {
    const ThreadLimit limit(threads);
    const far::TopologyRefiner refiner = refined(complex, level);
    double rows = 0, entries = 0;
    for (auto _ : state) {
        const auto table = stencils::buildStencils<float>(refiner, level);
        rows = table.rowCount();
        entries = static_cast<double>(table.entryCount());
    }
    state.counters["items"] = rows;
    state.counters["entries"] = entries;
}

/// Times carrying values to a level, as for one pose after another: everything that is independent
/// of the values is made before, as OpenSubdiv's levels are.
template <class Evaluator>
void carry(benchmark::State& state, const far::TopologyRefiner& refiner, int level, int threads,
           const Evaluator& evaluator) {
    const ThreadLimit limit(threads);
    const auto values = valuesOf(refiner.level(0).complex.count(0));
    const std::vector<float> source(values.begin(), values.end());
    std::vector<float> result(3 * static_cast<std::size_t>(evaluator.rowCount()));
    const auto layout = osd::BufferDescriptor::packed(3);
    osd::Workspace workspace = evaluator.workspace(3);
    for (auto _ : state) {
        evaluator.evaluate(source, layout, result, layout, {0, evaluator.rowCount()}, workspace);
        benchmark::ClobberMemory();
    }
    const auto expected = stencils::refineValues(refiner, level, values, 3);
    // Tolerance for sums in single precision over all levels.
    if (!std::equal(expected.begin(), expected.end(), result.begin(), result.end(),
                    [](double x, float y) { return std::abs(x - static_cast<double>(y)) < 1e-5; }))
        state.SkipWithError("the values are wrong");
    state.counters["items"] = refiner.level(level).complex.count(0);
}

/// Uses R_1 to R_n.
void inTurn(benchmark::State& state, const far::CellComplex& complex, int level, int threads) {
    const far::TopologyRefiner refiner = refined(complex, level);
    std::vector<stencils::StencilTable<float>> tables;
    for (auto& table : stencils::buildLevelTables(refiner, level))
        tables.push_back(stencils::convertTable<float>(std::move(table)));
    carry(state, refiner, level, threads, osd::CompiledChain<float>(tables));
}

/// Uses S_n.
void atOnce(benchmark::State& state, const far::CellComplex& complex, int level, int threads) {
    const far::TopologyRefiner refiner = refined(complex, level);
    carry(state, refiner, level, threads,
          osd::CompiledTable<float>(stencils::buildStencils<float>(refiner, level)));
}

#ifdef ESPALIER_WITH_OPENSUBDIV

namespace Far = OpenSubdiv::Far;

/// xyz in single precision, in the form that OpenSubdiv's refiner requires.
struct Xyz {
    float values[3];
    void Clear() { values[0] = values[1] = values[2] = 0; }
    void AddWithWeight(const Xyz& other, float weight) {
        for (int c = 0; c < 3; ++c) values[c] += weight * other.values[c];
    }
};

std::vector<Xyz> asXyz(const std::vector<double>& values) {
    std::vector<Xyz> result(values.size() / 3);
    for (std::size_t i = 0; i < values.size(); ++i)
        result[i / 3].values[i % 3] = static_cast<float>(values[i]);
    return result;
}

/// True if two sets of points are equal in some order, since the levels are numbered differently.
bool areSame(const std::vector<Xyz>& theirs, const std::vector<double>& ours) {
    std::vector<float> a, b;
    for (const Xyz& point : theirs) a.push_back(point.values[0] + 2 * point.values[1]);
    for (std::size_t i = 0; i < ours.size(); i += 3)
        b.push_back(static_cast<float>(ours[i] + 2 * ours[i + 1]));
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    // OpenSubdiv's values are sums in single precision over all levels.
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](float x, float y) {
               return std::abs(x - y) < 1e-5F;
           });
}

std::vector<double> ourValues(const bench::Mesh& mesh, int level) {
    const auto refiner = refined(far::buildMesh(mesh.vertexCount, mesh.loops), level);
    return stencils::refineValues(refiner, level, valuesOf(mesh.vertexCount), 3);
}

void refineOpenSubdiv(benchmark::State& state, const bench::Mesh& mesh, int level) {
    double faces = 0;
    for (auto _ : state) {
        state.PauseTiming();
        const auto refiner = bench::openSubdivRefiner(mesh);
        state.ResumeTiming();
        refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(level));
        faces = refiner->GetNumFacesTotal() - refiner->GetLevel(0).GetNumFaces();
    }
    state.counters["items"] = faces;
}

void buildOpenSubdiv(benchmark::State& state, const bench::Mesh& mesh, int level) {
    const auto refiner = bench::openSubdivRefiner(mesh);
    refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(level));
    Far::StencilTableFactory::Options options;
    options.generateOffsets = true;
    options.generateIntermediateLevels = false;
    std::unique_ptr<const Far::StencilTable> table;
    for (auto _ : state) table.reset(Far::StencilTableFactory::Create(*refiner, options));
    const std::vector<Xyz> from = asXyz(valuesOf(mesh.vertexCount));
    std::vector<Xyz> to(table->GetNumStencils());
    table->UpdateValues(from.data(), to.data());
    if (!areSame(to, ourValues(mesh, level))) state.SkipWithError("their table is not ours");
    state.counters["items"] = table->GetNumStencils();
}

void inTurnOpenSubdiv(benchmark::State& state, const bench::Mesh& mesh, int level) {
    const auto refiner = bench::openSubdivRefiner(mesh);
    refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(level));
    const Far::PrimvarRefiner primvarRefiner(*refiner);
    std::vector<std::vector<Xyz>> levels = {asXyz(valuesOf(mesh.vertexCount))};
    for (int k = 1; k <= level; ++k)
        levels.emplace_back(static_cast<std::size_t>(refiner->GetLevel(k).GetNumVertices()));
    for (auto _ : state)
        for (int k = 1; k <= level; ++k) {
            const std::size_t at = k;
            primvarRefiner.Interpolate(k, levels[at - 1], levels[at]);
            benchmark::ClobberMemory();
        }
    if (!areSame(levels.back(), ourValues(mesh, level)))
        state.SkipWithError("their values are not ours");
    state.counters["items"] = static_cast<double>(levels.back().size());
}

#endif

/// \param job called with (state, workload, level, ...)
template <class Workload, class... More>
void add(const std::string& name, int level, const std::string& who,
         void (*job)(benchmark::State&, const Workload&, int, More...), const Workload& workload,
         More... more) {
    benchmark::RegisterBenchmark(
        (name + "/" + std::to_string(level) + "/" + who).c_str(),
        [=](benchmark::State& state) { job(state, workload, level, more...); })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
}

const bool kRegistered = [] {
    struct Job {
        std::string name;
        void (*ours)(benchmark::State&, const far::CellComplex&, int, int);
#ifdef ESPALIER_WITH_OPENSUBDIV
        void (*theirs)(benchmark::State&, const bench::Mesh&, int);
#endif
    };
#ifdef ESPALIER_WITH_OPENSUBDIV
    const std::vector<Job> jobs = {{"refine", refine, refineOpenSubdiv},
                                   {"build", build, buildOpenSubdiv},
                                   {"in turn", inTurn, inTurnOpenSubdiv},
                                   {"at once", atOnce, nullptr}};
#else
    const std::vector<Job> jobs = {
        {"refine", refine}, {"build", build}, {"in turn", inTurn}, {"at once", atOnce}};
#endif
    const bench::Mesh mesh = bench::torus(40);
    const far::CellComplex surface = far::buildMesh(mesh.vertexCount, mesh.loops);
    const far::CellComplex lattice = shapes::box({.cells = {10, 10, 10}}).complex;
    for (const Job& job : jobs)
        for (int level = 3; level <= 5; ++level) {
#ifdef ESPALIER_WITH_OPENSUBDIV
            if (job.theirs) add(job.name + "/surface", level, "OpenSubdiv", job.theirs, mesh);
#endif
            add(job.name + "/surface", level, "Espalier", job.ours, surface, 1);
            add(job.name + "/surface", level, "Espalier 2 threads", job.ours, surface, 2);
            if (level == 3) {
                add(job.name + "/lattice", level, "Espalier", job.ours, lattice, 1);
                add(job.name + "/lattice", level, "Espalier 2 threads", job.ours, lattice, 2);
            }
        }
    return true;
}();

}  // namespace
}  // namespace espalier
