// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <espalier/base/parallel.h>
#include <espalier/osd/compiled_adjoint.h>
#include <espalier/osd/compiled_chain.h>
#include <espalier/osd/deformer.h>
#include <espalier/stencils/sparse_matrix.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "workloads.h"
#ifdef ESPALIER_WITH_OPENSUBDIV
#include <opensubdiv/osd/bufferDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#endif

// Multiplies a table by xyz values with our evaluators, OpenSubdiv's and Eigen's, on the same
// arrays. Benchmarks are named apply/WORKLOAD/REAL/COMPONENTS/WHO. Each result is compared with our
// plain evaluator's before it is timed. Benchmarks named addend/WORKLOAD/REAL/COMPONENTS/FORM WAY
// add points to the results. Benchmarks named deform/WORKLOAD/REAL/POSES/FORM deform a binding.
// Benchmarks named compile/WORKLOAD/REAL/WHO compile the table or copy it.
namespace espalier {
namespace {

using bench::Tables;
using bench::Workload;
using osd::BufferDescriptor;
using stencils::StencilTable;

/// Returns a workload, which is built on demand; only the latest one is kept.
const Workload& workload(const std::string& key, const std::function<Workload()>& make) {
    static std::string held;
    static std::unique_ptr<const Workload> latest;
    if (held != key) {
        latest.reset();
        latest = std::make_unique<const Workload>(make());
        held = key;
    }
    return *latest;
}

template <class Real>
const Tables<Real>& tablesOf(const Workload& workload) {
    if constexpr (sizeof(Real) == sizeof(float))
        return workload.inFloat;
    else
        return workload.inDouble;
}

/// Times evaluate(source, destination).
template <class Real, class Evaluate>
void run(benchmark::State& state, const StencilTable<Real>& table, int components, int threads,
         Evaluate evaluate) {
    const ThreadLimit limit(threads);
    const std::vector<Real> source = bench::randomValues(table, components);
    std::vector<Real> result(table.rowCount() * Offset{components});
    evaluate(source, result);
    // Compare with sums in the order of the table; values are at most 1, rows have up to 64
    // entries.
    for (Index row = 0; row < table.rowCount(); row += 997)
        for (int c = 0; c < components; ++c) {
            double sum = 0;
            for (std::size_t k = 0; k < table.columns(row).size(); ++k)
                sum += static_cast<double>(table.weights(row)[k]) *
                       source[table.columns(row)[k] * components + c];
            const double got = result[row * Offset{components} + c];
            if (!(std::abs(got - sum) <= 64 * std::numeric_limits<Real>::epsilon()))
                return state.SkipWithError("the result is wrong");
        }
    for (auto _ : state) {
        evaluate(source, result);
        benchmark::ClobberMemory();
    }
    state.counters["rows"] = table.rowCount();
    state.counters["entries"] = static_cast<double>(table.entryCount());
}

template <class Real, class Compiled>
void applyOurs(benchmark::State& state, const Compiled& compiled, const StencilTable<Real>& table,
               int components, int threads) {
    const auto layout = BufferDescriptor::packed(components);
    osd::Workspace workspace = compiled.workspace(components);
    run(state, table, components, threads,
        [&](const std::vector<Real>& source, std::vector<Real>& result) {
            compiled.evaluate(source, layout, result, layout, {0, table.rowCount()}, workspace);
        });
    const double csr = static_cast<double>(table.entryCount()) * (sizeof(Real) + sizeof(Index));
    state.counters["bytes of CSR"] = static_cast<double>(compiled.byteCount()) / csr;
    // Necessary traffic: the table, and the results, which are written once.
    const double moved = static_cast<double>(compiled.byteCount()) +
                         static_cast<double>(table.rowCount()) * components * sizeof(Real);
    state.SetBytesProcessed(static_cast<Offset>(static_cast<double>(state.iterations()) * moved));
}

template <class Real>
void applyCompiled(benchmark::State& state, const Tables<Real>& tables, int components,
                   int threads) {
    applyOurs(state, osd::CompiledTable<Real>(tables.table), tables.table, components, threads);
}

template <class Real>
void applyFactors(benchmark::State& state, const Tables<Real>& tables, int components,
                  int threads) {
    applyOurs(state, osd::CompiledChain<Real>(*tables.factors), tables.table, components, threads);
}

/// How points are added to the results of an evaluation.
enum class PointsAdded { Never, AsAddend, ByAPass };

/// Times D · source, or x + D · source, with x as the addend of the evaluation or added by a pass
/// over the results.
template <class Real, class Compiled>
void runWithPoints(benchmark::State& state, const Compiled& compiled,
                   const StencilTable<Real>& table, int components, PointsAdded how) {
    const ThreadLimit limit(1);
    const auto layout = BufferDescriptor::packed(components);
    const osd::RowRange rows{0, table.rowCount()};
    const std::vector<Real> source = bench::randomValues(table, components);
    std::vector<Real> sums(table.rowCount() * Offset{components}), result(sums.size());
    std::vector<Real> points(table.rowCount() * Offset{3});
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = static_cast<Real>(i % 1000) / 1000;
    const auto addend = osd::Addend<Real>::packed(points, 3);
    osd::Workspace workspace = compiled.workspace(components);
    const auto addPoints = [&](std::vector<Real>& values) {
        for (Offset row = 0; row < table.rowCount(); ++row)
            for (Offset c = 0; c < components; c += 3)
                for (Offset axis = 0; axis < 3; ++axis)
                    values[row * components + c + axis] += points[3 * row + axis];
    };
    const auto evaluate = [&] {
        compiled.evaluate(source, layout, result, layout, rows, workspace,
                          how == PointsAdded::AsAddend ? addend : osd::Addend<Real>());
        if (how == PointsAdded::ByAPass) addPoints(result);
        benchmark::ClobberMemory();
    };
    compiled.evaluate(source, layout, sums, layout, rows, workspace);
    if (how != PointsAdded::Never) addPoints(sums);
    evaluate();
    if (result != sums) return state.SkipWithError("the result is wrong");
    for (auto _ : state) evaluate();
}

/// Times a deformer, for some poses in one call.
template <class Real>
void deform(benchmark::State& state, const Tables<double>& tables, int poses, bool withFactors) {
    const ThreadLimit limit(1);
    bind::Binding binding{{tables.table}};
    if (withFactors) binding.factors = tables.factors;
    for (Index row = 0; row < tables.table.rowCount(); ++row)
        binding.points.push_back({0.001 * (row % 1000), 0.5, 0.25});
    binding.rest.resize(tables.table.columnCount());
    binding.statuses.resize(tables.table.rowCount());
    const osd::Deformer<Real> deformer(binding);
    std::vector<Real> source(poses * binding.rest.size() * 3, Real(0.5)),
        result(poses * binding.points.size() * 3);
    deformer.deform(source, result);
    for (auto _ : state) {
        deformer.deform(source, result);
        benchmark::ClobberMemory();
    }
    state.counters["ms a pose"] = benchmark::Counter(
        0.001 * poses, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Times Dᵀ, from values of the rows to sums over the columns.
template <class Real, class Adjoint>
void runAdjoint(benchmark::State& state, const StencilTable<Real>& table, const Adjoint& adjoint,
                int components, int threads) {
    const ThreadLimit limit(threads);
    const auto layout = BufferDescriptor::packed(components);
    const auto source = bench::randomValues(stencils::transposeTable(table), components);
    std::vector<Real> result(table.columnCount() * Offset{components});
    osd::Workspace workspace = adjoint.workspace(components);
    const auto evaluate = [&] {
        adjoint.evaluate(source, layout, result, layout, {0, adjoint.rowCount()}, workspace);
        benchmark::ClobberMemory();
    };
    evaluate();
    std::vector<double> sums(result.size(), 0), sizes(result.size(), 0);
    for (Index row = 0; row < table.rowCount(); ++row)
        for (std::size_t k = 0; k < table.columns(row).size(); ++k)
            for (int c = 0; c < components; ++c) {
                const std::size_t at = table.columns(row)[k] * components + c;
                const double product = static_cast<double>(table.weights(row)[k]) *
                                       source[row * Offset{components} + c];
                sums[at] += product;
                sizes[at] += std::abs(product);
            }
    for (std::size_t i = 0; i < result.size(); ++i)
        if (!(std::abs(result[i] - sums[i]) <=
              64 * std::numeric_limits<Real>::epsilon() * sizes[i]))
            return state.SkipWithError("the result is wrong");
    for (auto _ : state) evaluate();
    const double csr = static_cast<double>(table.entryCount()) * (sizeof(Real) + sizeof(Index));
    state.counters["bytes of CSR"] = static_cast<double>(adjoint.byteCount()) / csr;
    state.SetBytesProcessed(state.iterations() * static_cast<Offset>(adjoint.byteCount() +
                                                                     source.size() * sizeof(Real)));
}

template <class Real>
void applyAdjoint(benchmark::State& state, const Tables<Real>& tables, int components,
                  int threads) {
    runAdjoint(state, tables.table, osd::CompiledAdjoint<Real>(tables.table), components, threads);
}

template <class Real>
void applyFactorsAdjoint(benchmark::State& state, const Tables<Real>& tables, int components,
                         int threads) {
    runAdjoint(state, tables.table, osd::CompiledAdjointChain<Real>(*tables.factors), components,
               threads);
}

/// Times copying a table into memory that is there already: fresh memory would take most of the
/// time.
template <class Real>
void copyTable(benchmark::State& state, const Tables<Real>& tables, int) {
    const StencilTable<Real>& table = tables.table;
    Array<Offset> offsets(table.offsets().begin(), table.offsets().end());
    Array<Index> columns(table.columns().begin(), table.columns().end());
    Array<Real> weights(table.weights().begin(), table.weights().end());
    for (auto _ : state) {
        std::ranges::copy(table.offsets(), offsets.begin());
        std::ranges::copy(table.columns(), columns.begin());
        std::ranges::copy(table.weights(), weights.begin());
        benchmark::ClobberMemory();
    }
    if (weights.back() != table.weights().back()) state.SkipWithError("the copy is wrong");
}

/// Times compiling a table, with the destruction of the result.
template <class Compiled, class Real>
void compileTable(benchmark::State& state, const Tables<Real>& tables, int threads) {
    const ThreadLimit limit(threads);
    for (auto _ : state) {
        const Compiled compiled(tables.table);
        benchmark::DoNotOptimize(compiled.byteCount());
    }
}

/// Eigen is faster if the number of columns is known at compile time.
template <class Real>
void applyEigen(benchmark::State& state, const Tables<Real>& tables, int components, int threads) {
    const StencilTable<Real>& table = tables.table;
    constexpr int kComponents = 3;
    if (components != kComponents) return state.SkipWithError("made for three components");
    using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, kComponents, Eigen::RowMajor>;
    const stencils::SparseView<Real> view(table);
    run(state, table, components, threads,
        [&](const std::vector<Real>& source, std::vector<Real>& result) {
            const Eigen::Map<const Matrix> from(source.data(), table.columnCount(), kComponents);
            Eigen::Map<Matrix>(result.data(), table.rowCount(), kComponents).noalias() =
                view.matrix() * from;
        });
}

#ifdef ESPALIER_WITH_OPENSUBDIV
void applyOpenSubdiv(benchmark::State& state, const Tables<float>& tables, int components,
                     int threads) {
    const StencilTable<float>& table = tables.table;
    namespace Osd = OpenSubdiv::Osd;
    std::vector<int> sizes, offsets;
    for (Index row = 0; row < table.rowCount(); ++row) {
        sizes.push_back(static_cast<int>(table.columns(row).size()));
        offsets.push_back(static_cast<int>(table.offsets()[row]));
    }
    const Osd::BufferDescriptor layout(0, components, components);
    run(state, table, components, threads,
        [&](const std::vector<float>& source, std::vector<float>& result) {
            Osd::CpuEvaluator::EvalStencils(source.data(), layout, result.data(), layout,
                                            sizes.data(), offsets.data(), table.columns().data(),
                                            table.weights().data(), 0, table.rowCount());
        });
}
#endif

struct Case {
    std::string key;
    std::function<Workload()> make;
    bool hasFactors = false;
};

template <class Real>
std::string nameOf() {
    return sizeof(Real) == sizeof(float) ? "float" : "double";
}

template <class Real>
void add(const Case& chosen, int components, const std::string& who, int threads,
         void (*apply)(benchmark::State&, const Tables<Real>&, int, int)) {
    benchmark::RegisterBenchmark(("apply/" + chosen.key + "/" + nameOf<Real>() + "/" +
                                  std::to_string(components) + "/" + who)
                                     .c_str(),
                                 [=](benchmark::State& state) {
                                     const Workload& made = workload(chosen.key, chosen.make);
                                     apply(state, tablesOf<Real>(made), components, threads);
                                 })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
}

void addCompiling(const Case& chosen) {
    const auto add = [&](const std::string& who, int threads, auto work) {
        benchmark::RegisterBenchmark(("compile/" + chosen.key + "/float/" + who).c_str(),
                                     [=](benchmark::State& state) {
                                         work(state, workload(chosen.key, chosen.make).inFloat,
                                              threads);
                                     })
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
    };
    add("copy", 1, copyTable<float>);
    add("Espalier", 1, compileTable<osd::CompiledTable<float>, float>);
    add("Espalier 2 threads", 2, compileTable<osd::CompiledTable<float>, float>);
    add("Espalier adjoint", 1, compileTable<osd::CompiledAdjoint<float>, float>);
}

template <class Real>
void addPointsTo(const Case& chosen, int components, bool isFactored) {
    const std::pair<PointsAdded, const char*> ways[] = {{PointsAdded::Never, "without"},
                                                        {PointsAdded::AsAddend, "addend"},
                                                        {PointsAdded::ByAPass, "pass"}};
    for (const auto& [how, name] : ways)
        benchmark::RegisterBenchmark(
            ("addend/" + chosen.key + "/" + nameOf<Real>() + "/" + std::to_string(components) +
             (isFactored ? "/factors " : "/table ") + name)
                .c_str(),
            [=, how = how](benchmark::State& state) {
                const auto& tables = tablesOf<Real>(workload(chosen.key, chosen.make));
                if (isFactored)
                    runWithPoints(state, osd::CompiledChain<Real>(*tables.factors), tables.table,
                                  components, how);
                else
                    runWithPoints(state, osd::CompiledTable<Real>(tables.table), tables.table,
                                  components, how);
            })
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
}

template <class Real>
void addDeforming(const Case& chosen, int poses, bool isFactored) {
    benchmark::RegisterBenchmark(("deform/" + chosen.key + "/" + nameOf<Real>() + "/" +
                                  std::to_string(poses) + (isFactored ? "/factors" : "/table"))
                                     .c_str(),
                                 [=](benchmark::State& state) {
                                     deform<Real>(state, workload(chosen.key, chosen.make).inDouble,
                                                  poses, isFactored);
                                 })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
}

const bool kRegistered = [] {
    const std::vector<Case> cases = {{"surface 0.4 M", [] { return bench::surface(400'000); }},
                                     {"surface 1.6 M", [] { return bench::surface(1'600'000); }},
                                     {"regular model", bench::regularModel},
                                     {"irregular model", bench::irregularModel, true}};
    for (const Case& each : cases) {
#ifdef ESPALIER_WITH_OPENSUBDIV
        add<float>(each, 3, "OpenSubdiv", 1, applyOpenSubdiv);
#endif
        add<float>(each, 3, "Eigen", 1, applyEigen<float>);
        add<float>(each, 3, "Espalier", 1, applyCompiled<float>);
        add<float>(each, 3, "Espalier 2 threads", 2, applyCompiled<float>);
        add<float>(each, 36, "Espalier", 1, applyCompiled<float>);
        add<double>(each, 3, "Eigen", 1, applyEigen<double>);
        add<double>(each, 3, "Espalier", 1, applyCompiled<double>);
        add<float>(each, 3, "Espalier adjoint", 1, applyAdjoint<float>);
        add<float>(each, 3, "Espalier adjoint 2 threads", 2, applyAdjoint<float>);
        addCompiling(each);
        if (!each.hasFactors) continue;
        add<float>(each, 3, "Espalier factors", 1, applyFactors<float>);
        add<float>(each, 3, "Espalier factors 2 threads", 2, applyFactors<float>);
        add<float>(each, 36, "Espalier factors", 1, applyFactors<float>);
        add<double>(each, 3, "Espalier factors", 1, applyFactors<double>);
        add<float>(each, 3, "Espalier factors adjoint", 1, applyFactorsAdjoint<float>);
        add<float>(each, 3, "Espalier factors adjoint 2 threads", 2, applyFactorsAdjoint<float>);
    }
    for (const Case& each : cases) {
        if (each.key.find("model") == std::string::npos) continue;
        for (const int components : {3, 36})
            for (const bool isFactored : {false, true}) {
                if (isFactored && !each.hasFactors) continue;
                addPointsTo<float>(each, components, isFactored);
                addPointsTo<double>(each, components, isFactored);
                addDeforming<float>(each, components / 3, isFactored);
                addDeforming<double>(each, components / 3, isFactored);
            }
    }
    return true;
}();

}  // namespace
}  // namespace espalier
